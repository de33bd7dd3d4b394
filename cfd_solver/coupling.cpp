#include "coupling.hpp"

#include "cell_lattice.hpp"
#include "closures.hpp"

#include <cmath>

using namespace Foam;

namespace hotbed
{
namespace
{

/// the axis-aligned box of a cell, and whether the cell fills it
bool cellBox(const fvMesh& mesh, label c, Box& box)
{
    const boundBox bounds(mesh.points(), mesh.cellPoints()[c], false);
    for (int a = 0; a < 3; ++a)
    {
        box.low[a] = bounds.min()[a];
        box.high[a] = bounds.max()[a];
    }
    const scalar volume = bounds.volume();
    return mag(volume - mesh.V()[c]) < 1e-9 * volume;
}

constexpr int gasFields = 8; // voidage, U, rho, mu, kappa, Cp: one cache line a cell

} // namespace

Coupling::Coupling(const CouplingSettings& settings, const fvMesh& mesh, Dem& dem, Gas& gas, Timing& timing)
    : settings_(settings), mesh_(mesh), dem_(dem), gas_(gas), timing_(timing),
      heat_(settings.heatTransfer && dem.heat()), push_(dem.moving() && dem.drag()), dragFields_(push_ ? 8 : 1),
      halfExtent_(mesh.nCells()), mapping_(MPI_COMM_WORLD, makeCells(settings))
{
}

std::unique_ptr<const Cells> Coupling::makeCells(const CouplingSettings& settings)
{
    std::vector<Box> boxes(mesh_.nCells());
    bool allBoxes = true;
    for (label c = 0; c < mesh_.nCells(); ++c)
    {
        allBoxes = cellBox(mesh_, c, boxes[c]) && allBoxes;
        for (int a = 0; a < 3; ++a) halfExtent_[c][a] = 0.5 * (boxes[c].high[a] - boxes[c].low[a]);
    }
    reduce(allBoxes, andOp<bool>());
    const boundBox& whole = mesh_.bounds(); // over all ranks
    if (allBoxes)
    {
        Info << "Mapping: box cells, exact kernel integrals" << nl;
        Box domain;
        if (mag(gSum(mesh_.V()) - whole.volume()) < 1e-9 * whole.volume())
            for (int a = 0; a < 3; ++a)
            {
                domain.low[a] = whole.min()[a];
                domain.high[a] = whole.max()[a];
            }
        return std::make_unique<BoxCells>(boxes, domain);
    }
    Info << "Mapping: cells of any shape, through a lattice of about " << settings.kernelSamples << "^3 boxes a cell"
         << nl;
    return latticeOver(
        mesh_, settings.kernelSamples,
        0.5 * (settings.windowLength > 0 ? settings.windowLength : settings.kernelWidth * 2.0 * dem_.largestRadius()));
}

void Coupling::refuseOutside() const
{
    label outside = 0;
    label first = -1;
    for (std::size_t i = 0; i < inside_.size(); ++i)
        if (!inside_[i])
        {
            if (first < 0) first = label(i);
            ++outside;
        }
    if (first >= 0)
    {
        const double* x = dem_.position()[first];
        Pout << "particle " << dem_.tag()[first] << " at (" << x[0] << ' ' << x[1] << ' ' << x[2]
             << ") lies outside the mesh" << endl;
    }
    reduce(outside, sumOp<label>());
    if (outside)
        FatalErrorInFunction << outside << " particles of " << settings_.demScript << " lie outside the mesh "
                             << mesh_.bounds() << ": place them inside it, or enlarge the mesh in system/blockMeshDict"
                             << exit(FatalError);
}

void Coupling::map()
{
    if (mapped_ && !dem_.moving()) return;
    {
        const auto time = timing_.measure("weights");
        const int n = dem_.size();
        halfWidth_.resize(n);
        widest_ = 0.0;
        for (int i = 0; i < n; ++i)
        {
            halfWidth_[i] = 0.5 * (settings_.windowLength > 0 ? settings_.windowLength
                                                              : settings_.kernelWidth * 2.0 * dem_.radius()[i]);
            widest_ = std::max(widest_, halfWidth_[i]);
        }
        inside_ = mapping_.update({n, dem_.position(), halfWidth_.data()});
        reduce(widest_, maxOp<double>());
        if (!warned_ && 2.0 * widest_ > cmptMin(mesh_.bounds().span()))
        {
            warned_ = true;
            WarningInFunction << "the kernel is " << 2.0 * widest_ << " m wide, wider than the domain "
                              << mesh_.bounds().span() << ": set a smaller kernelWidth or windowLength in "
                              << "constant/couplingProperties, or a smaller coarse-graining ratio" << endl;
        }
    }
    const auto time = timing_.measure("voidage");
    const int n = dem_.size();
    std::vector<double> volume(n);
    for (int i = 0; i < n; ++i) volume[i] = sphereVolume(dem_.radius()[i]);
    cellValues_.assign(mesh_.nCells(), 0.0);
    mapping_.deposit(1, mapping_.toCopies(1, volume.data()), cellValues_.data());
    volScalarField& voidage = gas_.voidage();
    for (label c = 0; c < mesh_.nCells(); ++c) voidage[c] = 1.0 - cellValues_[c] / mesh_.V()[c];
    const scalar least = gMin(voidage.primitiveField());
    if (!(least > 0.01))
    {
        FatalErrorInFunction << "the voidage of a cell is " << least << ": the particles overlap too much, or "
                             << "the kernel is too narrow for the cells (set a larger kernelWidth in "
                             << "constant/couplingProperties)" << exit(FatalError);
    }
    voidage.correctBoundaryConditions();
    mapped_ = true;
}

void Coupling::particlesToGas()
{
    closures();
    if (heat_) heatToGas();
}

void Coupling::closures()
{
    const double* at;
    const int n = dem_.size();
    {
        const auto time = timing_.measure("gas at particles");
        const scalarField& voidage = gas_.voidage();
        const vectorField& U = gas_.U();
        const fluidThermo& thermo = gas_.thermo();
        const tmp<volScalarField> rho = thermo.rho(), mu = thermo.mu(), kappa = thermo.kappa(), Cp = thermo.Cp();
        cellValues_.resize(std::size_t(mesh_.nCells()) * gasFields);
        for (label c = 0; c < mesh_.nCells(); ++c)
        {
            double* f = &cellValues_[std::size_t(c) * gasFields];
            f[0] = voidage[c];
            for (int a = 0; a < 3; ++a) f[1 + a] = U[c][a];
            f[4] = rho()[c];
            f[5] = mu()[c];
            f[6] = kappa()[c];
            f[7] = Cp()[c];
        }
        at = mapping_.interpolate(gasFields, cellValues_.data());
    }
    {
        const auto time = timing_.measure("closures");
        const double l = dem_.ratio();
        const double* radius = dem_.radius();
        double* nusselts = heat_ ? dem_.nusselt() : nullptr;
        const double(*v)[3] = dem_.velocity();
        drag_.resize(std::size_t(n) * dragFields_);
        conductance_.resize(heat_ ? n : 0);
        std::vector<double>& work = closureWork_;
        work.assign(std::size_t(n) * 5, 0.0);
        double *voidage = work.data(), *reynolds = voidage + n, *prandtl = reynolds + n, *beta = prandtl + n,
               *nusselt = beta + n;
        for (int i = 0; i < n; ++i)
        {
            const double* g = at + std::size_t(i) * gasFields;
            if (!inside_[i])
            {
                voidage[i] = prandtl[i] = 1.0; // has left the mesh: any numbers, it exchanges nothing
                continue;
            }
            const double slip[3] = {g[1] - v[i][0], g[2] - v[i][1], g[3] - v[i][2]};
            const double speed = std::sqrt(slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2]);
            voidage[i] = g[0];
            reynolds[i] = g[0] * g[4] * speed * (2.0 * radius[i] / l) / g[5];
            prandtl[i] = g[5] * g[7] / g[6];
        }
        if (settings_.drag) settings_.drag(n, voidage, reynolds, beta);
        if (heat_) gunn(n, voidage, reynolds, prandtl, nusselt);
        for (int i = 0; i < n; ++i)
        {
            const double* g = at + std::size_t(i) * gasFields;
            const double d = 2.0 * radius[i] / l, inside = inside_[i] ? 1.0 : 0.0;
            dragOn(i, inside * dragCoefficient(beta[i], g[5], voidage[i], d, l), g,
                   &drag_[std::size_t(i) * dragFields_]);
            if (!heat_) continue;
            nusselts[i] = inside * nusselt[i];
            conductance_[i] = heatConductance(nusselts[i], g[6], d, l);
        }
    }
    const auto time = timing_.measure("drag to gas");
    Exchange& exchange = gas_.exchange();
    cellValues_.assign(std::size_t(mesh_.nCells()) * dragFields_, 0.0);
    mapping_.deposit(dragFields_, mapping_.toCopies(dragFields_, drag_.data()), cellValues_.data());
    for (label c = 0; c < mesh_.nCells(); ++c)
    {
        const double* sum = &cellValues_[std::size_t(c) * dragFields_];
        exchange.drag[c] = sum[0];
        if (!push_) continue;
        for (int a = 0; a < 3; ++a) exchange.dragSource[c][a] = sum[1 + a];
        exchange.passedOn[c] = sum[4];
    }
}

void Coupling::gasToParticles()
{
    mismatch_ = 0.0;
    if (push_) momentumToParticles();
    if (heat_) heatToParticles();
}

} // namespace hotbed
