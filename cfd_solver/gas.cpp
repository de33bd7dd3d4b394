#include "gas.hpp"

#include "closures.hpp"
#include "constrainHbyA.H"
#include "constrainPressure.H"
#include "gaussConvectionScheme.H"
#include "gaussLaplacianScheme.H"
#include "linear.H"
#include "uncorrectedSnGrad.H"
#include "upwind.H"

using namespace Foam;

namespace hotbed
{
namespace
{

IOobject inputOutput(const word& name, const fvMesh& mesh, IOobject::readOption read, IOobject::writeOption write)
{
    return IOobject(name, mesh.time().timeName(), mesh, read, write);
}

IOobject gravityFile(const fvMesh& mesh)
{
    return IOobject("g", mesh.time().constant(), mesh, IOobject::MUST_READ, IOobject::NO_WRITE);
}

template <class Type> using CellField = GeometricField<Type, fvPatchField, volMesh>;

/// Implicit diffusion as if all lines between cell centres were at right angles to the faces.
template <class Type>
tmp<fvMatrix<Type>> straightLaplacian(const surfaceScalarField& gamma, const CellField<Type>& field)
{
    const fvMesh& mesh = field.mesh();
    fv::gaussLaplacianScheme<Type, scalar> scheme(mesh,
                                                  tmp<surfaceInterpolationScheme<scalar>>(new linear<scalar>(mesh)),
                                                  tmp<fv::snGradScheme<Type>>(new fv::uncorrectedSnGrad<Type>(mesh)));
    return scheme.fvmLaplacian(gamma, field);
}

/// By the dictionary's scheme where it has anything to correct.
template <class Type>
tmp<fvMatrix<Type>> laplacian(const surfaceScalarField& gamma, const CellField<Type>& field, bool oblique)
{
    return oblique ? fvm::laplacian(gamma, field) : straightLaplacian(gamma, field);
}

/// Fields of an incompressible case say so here, not in the middle of an equation.
template <class Type> void checkDimensions(const CellField<Type>& field, const dimensionSet& expected)
{
    if (field.dimensions() != expected)
        FatalErrorInFunction << field.objectPath().c_str() << ": dimensions must be " << expected << ", not "
                             << field.dimensions() << exit(FatalError);
}

} // namespace

Gas::Gas(fvMesh& mesh, bool energy, Timing& timing)
    : mesh_(mesh), energyOn_(energy),
      oblique_(gMax(scalarField(mag(mesh.nonOrthCorrectionVectors().primitiveField()))) > 1e-9), timing_(timing),
      pimple_(mesh), thermo_(fluidThermo::New(mesh)), p_(thermo_->p()),
      voidage_(inputOutput("voidage", mesh, IOobject::READ_IF_PRESENT, IOobject::AUTO_WRITE), mesh,
               dimensionedScalar("voidage", dimless, 1.0), zeroGradientFvPatchScalarField::typeName),
      rho_(inputOutput("rho", mesh, IOobject::NO_READ, IOobject::NO_WRITE), thermo_->rho()),
      pressureShare_(inputOutput("pressureShare", mesh, IOobject::NO_READ, IOobject::NO_WRITE), voidage_),
      U_(inputOutput("U", mesh, IOobject::MUST_READ, IOobject::AUTO_WRITE), mesh),
      mass_(inputOutput("gasMass", mesh, IOobject::READ_IF_PRESENT, IOobject::AUTO_WRITE), voidage_ * rho_),
      phi_(inputOutput("phi", mesh, IOobject::READ_IF_PRESENT, IOobject::AUTO_WRITE), fvc::flux(mass_ * U_)),
      g_(gravityFile(mesh)), exchangeTemperature_(thermo_->T().primitiveField())
{
    thermo_->validate("hotbedFoam", "h");
    checkDimensions(p_, dimPressure);
    checkDimensions(thermo_->T(), dimTemperature);
    checkDimensions(U_, dimVelocity);
    if (energyOn_)
    {
        // a restart goes on with the enthalpy itself: made from the temperature it would differ in the last digit
        volScalarField& h = thermo_->he();
        h.writeOpt() = IOobject::AUTO_WRITE;
        IOobject written("h", mesh.time().timeName(), mesh, IOobject::MUST_READ, IOobject::NO_WRITE, false);
        if (written.typeHeaderOk<volScalarField>())
            h.primitiveFieldRef() = volScalarField(written, mesh).primitiveField();
        h.correctBoundaryConditions();
    }
    mesh_.setFluxRequired(p_.name());
    setRefCell(p_, pimple_.dict(), pressureCell_, pressureValue_);
    const label n = mesh.nCells();
    exchange_.drag.setSize(n, 0.0);
    exchange_.dragSource.setSize(n, Zero);
    exchange_.passedOn.setSize(n, 0.0);
    exchange_.conductance.setSize(n, 0.0);
    exchange_.heatSource.setSize(n, 0.0);
}

void Gas::initialise(bool resumed)
{
    if (!resumed)
    {
        voidage_.correctBoundaryConditions();
        U_.correctBoundaryConditions(); // the interstitial inlet velocity follows the voidage
        mass_ = voidage_ * rho_;
        phi_ = fvc::flux(mass_ * U_);
    }
    pressureGradient_.reset(new volVectorField("grad(p)", fvc::grad(p_)));
    // fields of the step before, as they are now: made before anything touches their boundary values
    U_.oldTime();
    phi_.oldTime();
    mass_.oldTime();
    // the turbulence model sees voidage * rho as its density: then its equations are those of the bed
    turbulence_ = compressible::turbulenceModel::New(mass_, U_, phi_, *thermo_);
    turbulence_->validate();
    if (energyOn_)
        enthalpyFlux_.reset(
            new surfaceScalarField(inputOutput("enthalpyFlux", mesh_, IOobject::READ_IF_PRESENT, IOobject::AUTO_WRITE),
                                   fvc::flux(phi_, thermo_->he(), "div(phi,h)")));
}

void Gas::advance()
{
    rho_ = thermo_->rho();
    mass_.oldTime();
    voidage_.correctBoundaryConditions();
    pressureShare_.primitiveFieldRef() = voidage_.primitiveField() + exchange_.passedOn / mesh_.V();
    pressureShare_.correctBoundaryConditions();
    while (pimple_.loop())
    {
        momentum();
        while (pimple_.correct()) pressure();
        if (energyOn_) energy();
        if (pimple_.turbCorr())
        {
            const auto time = timing_.measure("gas: turbulence");
            turbulence_->correct();
        }
    }
    if (energyOn_) enthalpyFlux_() = fvc::flux(phi_, thermo_->he(), "div(phi,h)");
}

void Gas::continuity()
{
    // eq 1, explicit: what phi brings is what the cell holds, to round-off
    mass_.primitiveFieldRef() =
        mass_.oldTime().primitiveField() - mesh_.time().deltaTValue() * fvc::div(phi_)->primitiveField();
    mass_.boundaryFieldRef() = voidage_.boundaryField() * rho_.boundaryField();
    mass_.correctBoundaryConditions();
}

void Gas::momentum()
{
    const auto time = timing_.measure("gas: momentum equation");
    continuity();
    U_.correctBoundaryConditions();

    viscosity_.reset(new volScalarField("muEff", voidage_ * thermo_->mu() + turbulence_->mut()));
    const volTensorField transposed(viscosity_() * dev2(Foam::T(fvc::grad(U_))));
    transposedStress_ = Zero;
    forAll(transposed.boundaryField(), patch) if (!mesh_.boundary()[patch].coupled()) transposedStress_ +=
        sum(mesh_.Sf().boundaryField()[patch] & transposed.boundaryField()[patch]);
    UEqn_ = fvm::ddt(mass_, U_) + fvm::div(phi_, U_) - laplacian(fvc::interpolate(viscosity_()), U_, oblique_) -
            fvc::div(transposed, "div((muEff*dev2(T(grad(U)))))");
    fvVectorMatrix& UEqn = UEqn_.ref();
    UEqn.diag() += exchange_.drag;
    UEqn.source() += exchange_.dragSource;
    if (mag(g_.value()) > 0) UEqn.source() += mass_.primitiveField() * g_.value() * mesh_.V();
    UEqn.relax();

    rAU_.reset(new volScalarField("rAU", 1.0 / UEqn.A()));
    yield_.reset(new surfaceScalarField("yield", fvc::interpolate(pressureShare_ * rAU_())));
    fluxMemory_.reset(new surfaceScalarField("fluxMemory", fvc::interpolate(rAU_()) * fvc::ddtCorr(mass_, U_, phi_)));

    if (pimple_.momentumPredictor()) solve(UEqn == -pressureShare_ * pressureGradient_());
}

void Gas::pressure()
{
    const auto time = timing_.measure("gas: pressure equation");
    rho_ = thermo_->rho();
    const volScalarField psip0(thermo_->psi() * p_);
    const volScalarField& rAU = rAU_();
    const volVectorField HbyA(constrainHbyA(rAU * UEqn_->H(), U_, p_));
    const volScalarField mass(voidage_ * rho_);
    const surfaceScalarField massf(fvc::interpolate(mass));
    const surfaceScalarField rAUf("rAUf", massf * yield_());

    surfaceScalarField phiHbyA("phiHbyA", massf * (fvc::flux(HbyA) + fluxMemory_()));
    constrainPressure(p_, mass, U_, phiHbyA, rAUf);

    const dimensionedScalar rDeltaT = 1.0 / mesh_.time().deltaT();
    const volScalarField compressibility(voidage_ * thermo_->psi() * rDeltaT);
    const volScalarField storage((mass - mass_.oldTime()) * rDeltaT - compressibility * p_);
    while (pimple_.correctNonOrthogonal())
    {
        fvScalarMatrix pEqn(fvm::Sp(compressibility, p_) + storage + fvc::div(phiHbyA) - laplacian(rAUf, p_, oblique_));
        pEqn.setReference(pressureCell_, pressureValue_);
        pEqn.solve(mesh_.solver(p_.select(pimple_.finalInnerIter())));
        if (pimple_.finalNonOrthogonalIter()) phi_ = phiHbyA + pEqn.flux();
    }
    p_.relax();
    pressureGradient_() = fvc::grad(p_);
    U_ = HbyA - rAU * pressureShare_ * pressureGradient_();
    U_.correctBoundaryConditions();
    thermo_->correctRho(thermo_->psi() * p_ - psip0); // density at the new pressure
    continuity();
}

tmp<volScalarField> Gas::diffusivity() const
{
    // eq 11, 12 on the enthalpy: voidage * k_eff / c_p
    tmp<volScalarField> t(new volScalarField("alphaEff", voidage_ * thermo_->kappa() / thermo_->Cp()));
    volScalarField& alpha = t.ref();
    forAll(alpha, c) alpha[c] *= effectiveConductivity(voidage_[c]);
    forAll(alpha.boundaryField(), patch)
    {
        scalarField& face = alpha.boundaryFieldRef()[patch];
        const scalarField& voidage = voidage_.boundaryField()[patch];
        forAll(face, f) face[f] *= effectiveConductivity(voidage[f]);
    }
    alpha += turbulence_->alphat();
    // gas brings its own enthalpy in and no more: what conduction took upstream it would bring back
    forAll(phi_.boundaryField(), patch)
    {
        if (mesh_.boundary()[patch].coupled()) continue;
        const scalarField& flux = phi_.boundaryField()[patch];
        scalarField& face = alpha.boundaryFieldRef()[patch];
        forAll(face, f) if (flux[f] < 0) face[f] = 0;
    }
    return t;
}

namespace
{

/// Zalesak's limiter (J. Comput. Phys. 31 (1979) 335): scales face fluxes down until no cell leaves the range of its
/// own and its neighbours' values. Fluxes through the boundary of the domain are taken out.
/// @param h           field before the correction, with up-to-date boundary values
/// @param storage     change of the cell's content over that of its value, by cell
/// @param correction  face fluxes out of the owner, limited on return
void limitCorrection(const volScalarField& h, const scalarField& storage, surfaceScalarField& correction)
{
    const fvMesh& mesh = h.mesh();
    const labelUList& owner = mesh.owner();
    const labelUList& neighbour = mesh.neighbour();
    scalarField highest(h.primitiveField()), lowest(h.primitiveField());
    scalarField in(h.size(), 0.0), out(h.size(), 0.0);
    forAll(owner, f)
    {
        const label o = owner[f], n = neighbour[f];
        highest[o] = max(highest[o], h[n]);
        lowest[o] = min(lowest[o], h[n]);
        highest[n] = max(highest[n], h[o]);
        lowest[n] = min(lowest[n], h[o]);
        (correction[f] > 0 ? out[o] : in[o]) += mag(correction[f]);
        (correction[f] > 0 ? in[n] : out[n]) += mag(correction[f]);
    }
    forAll(h.boundaryField(), patch)
    {
        const fvPatchScalarField& face = h.boundaryField()[patch];
        scalarField& flux = correction.boundaryFieldRef()[patch];
        if (!face.coupled())
        {
            flux = 0.0;
            continue;
        }
        const labelUList& cells = mesh.boundary()[patch].faceCells();
        const scalarField other(face.patchNeighbourField());
        forAll(cells, f)
        {
            highest[cells[f]] = max(highest[cells[f]], other[f]);
            lowest[cells[f]] = min(lowest[cells[f]], other[f]);
            (flux[f] > 0 ? out : in)[cells[f]] += mag(flux[f]);
        }
    }

    // the shares of the inflow and of the outflow that a cell can take; as fields, for the other ranks' cells
    volScalarField takes(IOobject("takes", mesh.time().timeName(), mesh), mesh, dimensionedScalar("one", dimless, 1.0),
                         zeroGradientFvPatchScalarField::typeName);
    volScalarField gives("gives", takes);
    forAll(h, c)
    {
        if (in[c] > 0) takes[c] = min(1.0, storage[c] * (highest[c] - h[c]) / in[c]);
        if (out[c] > 0) gives[c] = min(1.0, storage[c] * (h[c] - lowest[c]) / out[c]);
    }
    takes.correctBoundaryConditions();
    gives.correctBoundaryConditions();
    forAll(owner, f) correction[f] *=
        correction[f] > 0 ? min(gives[owner[f]], takes[neighbour[f]]) : min(takes[owner[f]], gives[neighbour[f]]);
    forAll(h.boundaryField(), patch)
    {
        if (!h.boundaryField()[patch].coupled()) continue;
        scalarField& flux = correction.boundaryFieldRef()[patch];
        const labelUList& cells = mesh.boundary()[patch].faceCells();
        const scalarField takesThere(takes.boundaryField()[patch].patchNeighbourField());
        const scalarField givesThere(gives.boundaryField()[patch].patchNeighbourField());
        forAll(cells, f) flux[f] *=
            flux[f] > 0 ? min(gives[cells[f]], takesThere[f]) : min(takes[cells[f]], givesThere[f]);
    }
}

} // namespace

/// Eq 7, bounded by construction: an implicit upwind step whose matrix has no negative influence, then the difference
/// to the scheme of the dictionary, averaged over the step (second order in time), and what conduction through oblique
/// faces adds, as far as they make no new extremum (flux-corrected transport). Twice, since the second pass sees the
/// first one's result.
void Gas::energy()
{
    const auto time = timing_.measure("gas: energy equation");
    volScalarField& h = thermo_->he();
    const scalar dt = mesh_.time().deltaTValue();
    const scalarField& V = mesh_.V();
    const scalarField Cp(thermo_->Cp()->primitiveField());
    const scalarField h0(h.primitiveField());
    const scalarField T0(thermo_->T().primitiveField());
    const scalarField implicitPart(exchange_.conductance / Cp); // per enthalpy [kg/s]

    const tmp<volScalarField> alpha = diffusivity();
    const fv::gaussConvectionScheme<scalar> convection(
        mesh_, phi_, tmp<surfaceInterpolationScheme<scalar>>(new upwind<scalar>(mesh_, phi_)));
    const surfaceScalarField conduction(fvc::interpolate(alpha()));
    fvScalarMatrix hEqn(fvm::ddt(mass_, h) + convection.fvmDiv(phi_, h) - straightLaplacian(conduction, h));
    hEqn.diag() += implicitPart;
    hEqn.source() += exchange_.heatSource - exchange_.conductance * (T0 - exchange_.reference) + implicitPart * h0;
    hEqn.solve(mesh_.solver(h.select(pimple_.finalInnerIter())));

    // what crosses the boundary is what the matrix saw
    energyInflow_ = 0;
    forAll(h.boundaryField(), patch)
    {
        if (mesh_.boundary()[patch].coupled()) continue;
        const fvPatchScalarField& face = h.boundaryField()[patch];
        energyInflow_ -=
            dt * sum(phi_.boundaryField()[patch] * face -
                     alpha().boundaryField()[patch] * mesh_.magSf().boundaryField()[patch] * face.snGrad());
    }
    reduce(energyInflow_, sumOp<scalar>());

    surfaceScalarField used("used", convection.flux(phi_, h));
    const scalarField storage(mass_.primitiveField() * V / dt + implicitPart);
    const tmp<fv::snGradScheme<scalar>> snGrad(
        fv::snGradScheme<scalar>::New(mesh_, mesh_.snGradScheme("snGrad(" + h.name() + ')')));
    for (int pass = 0; pass < 2; ++pass)
    {
        surfaceScalarField wanted(0.5 * (fvc::flux(phi_, h, "div(phi,h)") + enthalpyFlux_()));
        if (oblique_ && snGrad().corrected()) wanted -= conduction * mesh_.magSf() * snGrad().correction(h);
        surfaceScalarField correction("correction", wanted - used);
        limitCorrection(h, storage, correction);
        h.primitiveFieldRef() -= fvc::surfaceIntegrate(correction)->primitiveField() * V / storage;
        h.correctBoundaryConditions();
        used += correction;
    }

    exchangeTemperature_ = T0 + (h.primitiveField() - h0) / Cp;
    thermo_->correct();
}

vector Gas::momentumContent() const
{
    return gSum(vectorField(mass_.primitiveField() * U_.primitiveField() * mesh_.V()));
}

vector Gas::momentumInflow() const
{
    vector force = transposedStress_;
    forAll(U_.boundaryField(), patch)
    {
        if (mesh_.boundary()[patch].coupled()) continue;
        const fvPatchVectorField& U = U_.boundaryField()[patch];
        force += sum(viscosity_().boundaryField()[patch] * mesh_.magSf().boundaryField()[patch] * U.snGrad() -
                     phi_.boundaryField()[patch] * U - p_.boundaryField()[patch] * mesh_.Sf().boundaryField()[patch]);
    }
    force += g_.value() * sum(mass_.primitiveField() * mesh_.V());
    reduce(force, sumOp<vector>());
    return force * mesh_.time().deltaTValue();
}

scalar Gas::pressureDrop() const
{
    scalar in[2] = {0, 0}, out[2] = {0, 0}; // area, area times pressure
    forAll(p_.boundaryField(), patch)
    {
        if (mesh_.boundary()[patch].coupled()) continue;
        // by patch, not by face: gas that falls back through an outlet makes no inlet of it
        const scalar flux = gSum(phi_.boundaryField()[patch]);
        if (flux == 0) continue;
        scalar* side = flux < 0 ? in : out;
        side[0] += gSum(mesh_.magSf().boundaryField()[patch]);
        side[1] += gSum(scalarField(mesh_.magSf().boundaryField()[patch] * p_.boundaryField()[patch]));
    }
    return in[0] > 0 && out[0] > 0 ? in[1] / in[0] - out[1] / out[0] : 0;
}

scalar Gas::inflow() const
{
    scalar sum = 0;
    forAll(phi_.boundaryField(), patch) if (!mesh_.boundary()[patch].coupled()) sum +=
        max(-gSum(scalarField(phi_.boundaryField()[patch] / rho_.boundaryField()[patch])), 0.0);
    return sum;
}

scalar Gas::courantRate() const
{
    const scalarField sumPhi(fvc::surfaceSum(mag(phi_))->primitiveField());
    return 0.5 * gMax(scalarField(sumPhi / (mass_.primitiveField() * mesh_.V())));
}

scalar Gas::energyContent() const
{
    return gSum(scalarField(mass_.primitiveField() * thermo_->he().primitiveField() * mesh_.V()));
}

} // namespace hotbed
