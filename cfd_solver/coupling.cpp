#include "coupling.hpp"

#include "cell_lattice.hpp"
#include "closures.hpp"
#include "vectorised.hpp"

#include <cmath>
#include <utility>

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

constexpr double hottest = 1e5; // [K], beyond it something is wrong

/// kernelWidth is in diameters of the coarse particle
KernelWidth kernel(const CouplingSettings& settings)
{
    return settings.windowLength > 0 ? KernelWidth{0.0, 0.5 * settings.windowLength}
                                     : KernelWidth{settings.kernelWidth, 0.0};
}

/// whole registers, where it is more than a few values
constexpr int padded(int fields)
{
    return fields <= 2 ? fields : fields <= 8 ? 8 : 12;
}

} // namespace

Coupling::Coupling(const CouplingSettings& settings, const fvMesh& mesh, Dem& dem, Gas& gas, Timing& timing)
    : settings_(settings), mesh_(mesh), dem_(dem), gas_(gas), timing_(timing),
      heat_(settings.heatTransfer && dem.heat()), push_(dem.moving() && dem.drag()), heatAt_(push_ ? 5 : 1),
      volumeAt_(heatAt_ + (heat_ ? 6 : 0)), sumFields_(padded(volumeAt_ + 1)), readHeatAt_(push_ ? 6 : 0),
      readFields_(padded(readHeatAt_ + (heat_ ? 5 : 0))), answerHeatAt_(push_ ? 2 : 1),
      answerFields_(answerHeatAt_ + (heat_ ? 2 : 0)), halfExtent_(mesh.nCells()),
      mapping_(MPI_COMM_WORLD, makeCells(settings)), cellSums_(std::size_t(mapping_.cells().places()) * sumFields_)
{
    for (label c = 0; c < mesh.nCells(); ++c) place_.push_back(std::size_t(mapping_.cells().place(c)));
    dem.carry(answerFields_);
    smallestCell_ = GREAT;
    for (const vector& half : halfExtent_) smallestCell_ = std::min(smallestCell_, 2.0 * cmptMin(half));
    reduce(smallestCell_, minOp<double>());
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
    return latticeOver(mesh_, settings.kernelSamples, kernel(settings).half(dem_.largestRadius()));
}

void Coupling::refuseOutside() const
{
    label outside = 0;
    label first = -1;
    const std::vector<char>& inside = mapping_.inside();
    for (std::size_t i = 0; i < inside.size(); ++i)
        if (!inside[i])
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

ParticlePositions Coupling::particles() const
{
    return {dem_.size(), dem_.position(), dem_.radius(), kernel(settings_)};
}

void Coupling::map()
{
    if (mapped_ && !dem_.moving()) return;
    cellValues_.assign(std::size_t(mapping_.cells().places()), 0.0);
    const Gift volume = {1, [this](int first, int count, double* given) { giveVolume(first, count, given, 1); }};
    updateWeights(volume, cellValues_.data());
    setVoidage(cellValues_.data(), 1);
}

void Coupling::updateWeights(const Gift& gift, double* sums)
{
    const auto time = timing_.measure("weights");
    mapping_.update(particles(), &gift, sums);
    widest_ = returnReduce(mapping_.widest(), maxOp<double>());
    if (!warned_ && 2.0 * widest_ > cmptMin(mesh_.bounds().span()))
    {
        warned_ = true;
        WarningInFunction << "the kernel is " << 2.0 * widest_ << " m wide, wider than the domain "
                          << mesh_.bounds().span() << ": set a smaller kernelWidth or windowLength in "
                          << "constant/couplingProperties, or a smaller coarse-graining ratio" << endl;
    }
}

/// @param volumes  of the particles in the first cell [m3]
/// @param stride   from there to that in the next place
void Coupling::setVoidage(const double* volumes, int stride)
{
    const auto time = timing_.measure("voidage");
    Exchange& exchange = gas_.exchange();
    for (const label c : reached_)
    {
        exchange.drag[c] = exchange.passedOn[c] = exchange.conductance[c] = exchange.heatSource[c] = 0.0;
        exchange.dragSource[c] = Zero;
    }
    reached_.clear();
    volScalarField& voidage = gas_.voidage();
    for (label c = 0; c < mesh_.nCells(); ++c)
    {
        const double volume = volumes[place_[c] * stride];
        voidage[c] = 1.0 - volume / mesh_.V()[c];
        if (volume > 0.0) reached_.push_back(c);
    }
    const scalar least = gMin(voidage.primitiveField());
    if (!(least > 0.01))
        FatalErrorInFunction << "the voidage of a cell is " << least << ": the particles overlap too much, or "
                             << "the kernel is too narrow for the cells (set a larger kernelWidth in "
                             << "constant/couplingProperties)" << exit(FatalError);
    voidage.correctBoundaryConditions();
    mapped_ = true;
}

/// Whether in this gas step particles answer to the gas as the closures told for an earlier one (FixHotbedCarried).
/// They read the gas, and closures are evaluated, once it or they have crossed a part of a cell since then
/// (closureCo), the fastest gas has changed by that part, or a tenth of it of the particles' relaxation time is over,
/// to which drag answers at once; also where the step has another length, from which the answers follow, and for new
/// particles. The same on any number of ranks.
bool Coupling::keepAnswers(double courantRate)
{
    const double dt = mesh_.time().deltaTValue(), part = settings_.closureCo;
    if (!dem_.moving() || part == 0.0) return false;
    double largest[3] = {fastest_ / smallestCell_, 10.0 * stiffest_, dem_.newParticles() ? 1.0 : 0.0};
    MPI_Allreduce(MPI_IN_PLACE, largest, 3, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    const double more = dt * std::max({courantRate, largest[0], largest[1]});
    const bool keep = dt == answersStep_ && largest[2] == 0.0 && sinceClosures_ + more <= part &&
                      std::abs(courantRate - courantThen_) <= part * courantThen_;
    sinceClosures_ = keep ? sinceClosures_ + more : more;
    if (!keep) courantThen_ = courantRate;
    answersStep_ = dt;
    return keep;
}

void Coupling::particlesToGas(double courantRate)
{
    const NoTraps guard;
    const bool keep = keepAnswers(courantRate);
    for (const label c : reached_) std::fill_n(&cellSums_[place_[c] * sumFields_], sumFields_, 0.0);
    if (heat_) setReference();
    timing_.add("to gas: closures", 0); // the table lists the same on every rank, also on one without particles
    const Gift gift = {sumFields_, [&](int first, int count, double* given)
                       {
                           if (keep) forgetOutside(first, count);
                           give(first, count, given);
                       }};
    if (keep) // without a look at the gas, so at once
    {
        updateWeights(gift, cellSums_.data());
        setVoidage(&cellSums_[std::size_t(volumeAt_)], sumFields_);
    }
    else
        map();
    const auto time = timing_.measure("to gas");
    const tmp<volScalarField> Cp = gas_.thermo().Cp();
    if (!keep)
    {
        ++evaluations_;
        gasInCells(Cp());
        fastest_ = stiffest_ = 0.0;
        mapping_.answer(
            gasFields, cellValues_.data(),
            [this](int first, int count, const double* gas)
            {
                const auto time = timing_.measure("to gas: closures");
                closures(first, count, gas);
            },
            gift, cellSums_.data());
    }
    if (heat_)
    {
        temperatureBefore_ = gas_.T().primitiveField();
        specificHeat_ = Cp().primitiveField();
        early_.resize(mesh_.nCells());
    }
    inBlocks(
        [this](const label* cell, const label* end)
        {
            dragToGas(cell, end);
            if (heat_) heatToGas(cell, end);
        });
}

/// Temperatures from a common one on: in a well mixed bed the differences that drive the heat are small.
void Coupling::setReference()
{
    const int n = dem_.size();
    const double* T = dem_.temperature();
    int impossible = 0;
    double sum[2] = {0.0, double(n)}, &all = sum[0];
#pragma omp simd reduction(+ : impossible, all)
    for (int i = 0; i < n; ++i)
    {
        impossible += !(T[i] > 0.0 && T[i] <= hottest);
        all += T[i];
    }
    for (int i = 0; impossible && i < n; ++i)
        if (!(T[i] > 0.0 && T[i] <= hottest))
            FatalErrorInFunction << dem_.describe(i).c_str() << " has the temperature " << T[i]
                                 << " K. Likely the DEM script gives it (initial_temperature of fix hotbed/heat, set, "
                                 << "set_property), or the heat capacity or an inlet temperature is impossible. The "
                                 << "restarts written before are whole" << exit(FatalError);
    MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    gas_.exchange().reference = sum[1] > 0.0 ? sum[0] / sum[1] : 0.0;
}

/// Particles that have left the mesh do not answer any more.
void Coupling::forgetOutside(int first, int count)
{
    const char* inside = mapping_.inside().data();
    for (int i = first; i < first + count; ++i)
        if (!inside[i]) std::fill_n(answers(i), answerFields_, 0.0);
}

/// What particles give in this step. @param given  [count][sumFields_]
void Coupling::give(int first, int count, double* given) const
{
    if (push_)
        giveMomentum(first, count, given);
    else
        for (int k = 0; k < count; ++k) given[k * sumFields_] = answers(first + k)[0];
    if (heat_) giveHeat(first, count, given + heatAt_);
    giveVolume(first, count, given + volumeAt_, sumFields_);
}

/// @param stride  from a particle's volume to that of the next one
void Coupling::giveVolume(int first, int count, double* given, int stride) const
{
    const double* radius = dem_.radius() + first;
    for (int k = 0; k < count; ++k) given[k * stride] = sphereVolume(radius[k]);
}

/// What particles read of the gas, by cell.
void Coupling::gasInCells(const scalarField& Cp)
{
    const scalarField& voidage = gas_.voidage();
    const vectorField& U = gas_.U();
    const fluidThermo& thermo = gas_.thermo();
    const tmp<volScalarField> rho = thermo.rho(), mu = thermo.mu();
    const scalarField& alpha = thermo.alpha(); // kappa/Cp
    cellValues_.resize(std::size_t(mapping_.cells().places()) * gasFields);
    for (const label c : reached_)
    {
        double* f = &cellValues_[place_[c] * gasFields];
        f[0] = voidage[c];
        for (int a = 0; a < 3; ++a) f[1 + a] = U[c][a];
        f[4] = rho()[c];
        f[5] = mu()[c];
        f[6] = alpha[c] * Cp[c];
        f[7] = heat_ ? std::cbrt(mu()[c] / alpha[c]) : 0.0;
    }
}

HOTBED_VECTORISED void Coupling::closures(int first, int count, const double* gas)
{
    for (int end = first + count; first < end; first += part, gas += part * gasFields)
        closuresOf(first, std::min(part, end - first), gas);
}

void Coupling::closuresOf(int first, int count, const double* gas)
{
    Seen seen;
    alignas(64) double reynolds[part], logReynolds[part], prandtlRoot[part], beta[part], nusselt[part], here[part];
    const double l = dem_.ratio();
    const double* radius = dem_.radius() + first;
    const double(*v)[3] = dem_.velocity() + first;
    const char* inside = mapping_.inside().data() + first;
    const double original = 2.0 / l; // diameter over the coarse radius
    double fastest = fastest_ * fastest_;
#pragma omp simd reduction(max : fastest)
    for (int k = 0; k < count; ++k)
    {
        const double square = v[k][0] * v[k][0] + v[k][1] * v[k][1] + v[k][2] * v[k][2];
        fastest = square > fastest ? square : fastest;
        const double* g = gas + k * gasFields;
        const double slip[3] = {g[1] - v[k][0], g[2] - v[k][1], g[3] - v[k][2]};
        here[k] = inside[k] ? 1.0 : 0.0; // else it has left the mesh: any numbers, it exchanges nothing
        const double one = 1.0 - here[k];
        seen.voidage[k] = g[0] + one;
        seen.density[k] = g[4];
        seen.viscosity[k] = g[5] + one;
        seen.conductivity[k] = g[6];
        reynolds[k] = g[0] * g[4] * std::sqrt(slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2]) *
                      (original * radius[k]) / seen.viscosity[k];
        prandtlRoot[k] = g[7];
    }
    fastest_ = std::sqrt(fastest);
    logarithms(count, reynolds, logReynolds);
    if (settings_.drag)
        settings_.drag(count, seen.voidage, reynolds, logReynolds, beta);
    else
        std::fill_n(beta, count, 0.0);
    for (int k = 0; k < count; ++k)
        seen.B[k] = here[k] * dragCoefficient(beta[k], seen.viscosity[k], seen.voidage[k], original * radius[k], l);
    dragOn(first, count, seen);
    if (!heat_) return;
    settings_.heatTransfer(count, seen.voidage, logReynolds, prandtlRoot, nusselt);
    double* result = dem_.nusselt() + first;
    for (int k = 0; k < count; ++k)
    {
        result[k] = nusselt[k] * here[k];
        seen.conductance[k] = heatConductance(result[k], seen.conductivity[k], original * radius[k], l);
    }
    heatOn(first, count, seen);
}

void Coupling::gasToParticles()
{
    mismatch_ = 0.0;
    if (!push_ && !heat_) return;
    const auto time = timing_.measure("to particles");
    const NoTraps guard;
    cellValues_.resize(std::size_t(mapping_.cells().places()) * readFields_);
    impulse_ = dragReceived_ = Zero;
    dragExchanged_ = heatExchanged_ = heatReceived_ = 0.0;
    tmp<volVectorField> slope;
    scalarMinMax range;
    if (heat_ && settings_.temperatureGradient)
    {
        slope = fvc::grad(gas_.thermo().he());
        for (const scalarField* field :
             {&gas_.exchangeTemperature(), &std::as_const(temperatureBefore_), &gas_.T().primitiveField()})
            range += gMinMax(*field);
    }
    inBlocks(
        [&](const label* cell, const label* end)
        {
            if (push_) momentumInCells(cell, end);
            if (heat_) heatInCells(cell, end, slope ? &slope() : nullptr, range);
        });
    mapping_.interpolate(readFields_, cellValues_.data(),
                         [this](int first, int count, const double* read)
                         {
                             if (push_) momentumToParticles(first, count, read);
                             if (heat_) heatToParticles(first, count, read);
                         });
    if (push_) momentumMismatch();
    if (heat_) heatMismatch();
}

} // namespace hotbed
