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

/// whole registers, where it is more than one value
constexpr int padded(int fields)
{
    return fields == 1 ? 1 : fields <= 8 ? 8 : 12;
}

/// Rows of what particles give (given_) to rows of what their cells sum up (cellSums_).
template <bool push, bool heat>
HOTBED_VECTORISED void fillAs(int count, const double (*__restrict position)[3], const double* __restrict given,
                              double* __restrict sums)
{
    constexpr int heatAt = push ? 5 : 1, givenFields = heatAt + (heat ? 4 : 0);
    constexpr int sumFields = padded(heatAt + (heat ? 7 : 0));
    for (int k = 0; k < count; ++k, given += givenFields, sums += sumFields)
    {
        if (!heat)
        {
            for (int f = 0; f < heatAt; ++f) sums[f] = given[f];
            continue;
        }
        for (int f = 0; f < heatAt + 2; ++f) sums[f] = given[f];
        const double *of = given + heatAt, *x = position[k];
        double* to = sums + heatAt + 2;
        to[0] = of[0] * of[2];
        *reinterpret_cast<Row4*>(to + 1) = of[0] * Row4{of[3], x[0], x[1], x[2]};
    }
}

} // namespace

Coupling::Coupling(const CouplingSettings& settings, const fvMesh& mesh, Dem& dem, Gas& gas, Timing& timing)
    : settings_(settings), mesh_(mesh), dem_(dem), gas_(gas), timing_(timing),
      heat_(settings.heatTransfer && dem.heat()), push_(dem.moving() && dem.drag()), heatAt_(push_ ? 5 : 1),
      givenFields_(heatAt_ + (heat_ ? 4 : 0)), sumFields_(padded(heatAt_ + (heat_ ? 7 : 0))),
      readHeatAt_(push_ ? 6 : 0), readFields_(padded(readHeatAt_ + (heat_ ? 5 : 0))), halfExtent_(mesh.nCells()),
      mapping_(MPI_COMM_WORLD, makeCells(settings))
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
    return latticeOver(mesh_, settings.kernelSamples, kernel(settings).half(dem_.largestRadius()));
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
        cellValues_.assign(mesh_.nCells(), 0.0);
        inside_ = mapping_.update({dem_.size(), dem_.position(), dem_.radius(), kernel(settings_)}, cellValues_.data());
        widest_ = returnReduce(mapping_.widest(), maxOp<double>());
        if (!warned_ && 2.0 * widest_ > cmptMin(mesh_.bounds().span()))
        {
            warned_ = true;
            WarningInFunction << "the kernel is " << 2.0 * widest_ << " m wide, wider than the domain "
                              << mesh_.bounds().span() << ": set a smaller kernelWidth or windowLength in "
                              << "constant/couplingProperties, or a smaller coarse-graining ratio" << endl;
        }
    }
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
        voidage[c] = 1.0 - cellValues_[c] / mesh_.V()[c];
        if (cellValues_[c] > 0.0) reached_.push_back(c);
    }
    const scalar least = gMin(voidage.primitiveField());
    if (!(least > 0.01))
        FatalErrorInFunction << "the voidage of a cell is " << least << ": the particles overlap too much, or "
                             << "the kernel is too narrow for the cells (set a larger kernelWidth in "
                             << "constant/couplingProperties)" << exit(FatalError);
    voidage.correctBoundaryConditions();
    mapped_ = true;
}

void Coupling::particlesToGas()
{
    const auto time = timing_.measure("to gas");
    timing_.add("to gas: closures", 0); // the table lists the same on every rank, also on one without particles
    const scalarField& voidage = gas_.voidage();
    const vectorField& U = gas_.U();
    const fluidThermo& thermo = gas_.thermo();
    const tmp<volScalarField> rho = thermo.rho(), mu = thermo.mu(), Cp = thermo.Cp();
    const scalarField& alpha = thermo.alpha(); // kappa/Cp
    const NoTraps guard;
    cellValues_.resize(std::size_t(mesh_.nCells()) * gasFields);
    for (const label c : reached_)
    {
        double* f = &cellValues_[std::size_t(c) * gasFields];
        f[0] = voidage[c];
        for (int a = 0; a < 3; ++a) f[1 + a] = U[c][a];
        f[4] = rho()[c];
        f[5] = mu()[c];
        f[6] = alpha[c] * Cp()[c];
        f[7] = heat_ ? std::cbrt(mu()[c] / alpha[c]) : 0.0;
    }
    if (heat_)
    {
        // temperatures from a common one on: in a well mixed bed the differences that drive the heat are small
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
                FatalErrorInFunction
                    << dem_.describe(i).c_str() << " has the temperature " << T[i]
                    << " K. Likely the DEM script gives it (initial_temperature of fix hotbed/heat, set, "
                    << "set_property), or the heat capacity or an inlet temperature is impossible. The "
                    << "restarts written before are whole" << exit(FatalError);
        MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
        gas_.exchange().reference = sum[1] > 0.0 ? sum[0] / sum[1] : 0.0;
    }
    given_.resize(std::size_t(dem_.size()) * givenFields_);
    cellSums_.resize(std::size_t(mesh_.nCells()) * sumFields_);
    for (const label c : reached_) std::fill_n(&cellSums_[std::size_t(c) * sumFields_], sumFields_, 0.0);
    mapping_.answer(
        gasFields, cellValues_.data(),
        [this](int first, int count, const double* gas)
        {
            const auto time = timing_.measure("to gas: closures");
            closures(first, count, gas);
        },
        dem_.position(), givenFields_, given_.data(),
        [this](int count, const double(*position)[3], const double* given, double* sums)
        { fill(count, position, given, sums); },
        sumFields_, cellSums_.data());
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

/// What particles add to the sums of their cells, from what they give.
void Coupling::fill(int count, const double (*position)[3], const double* given, double* sums) const
{
    if (push_ && heat_)
        fillAs<true, true>(count, position, given, sums);
    else if (push_)
        fillAs<true, false>(count, position, given, sums);
    else if (heat_)
        fillAs<false, true>(count, position, given, sums);
    else
        std::copy_n(given, count, sums);
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
    const char* inside = inside_.data() + first;
    const double original = 2.0 / l; // diameter over the coarse radius
    for (int k = 0; k < count; ++k)
    {
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
    cellValues_.resize(std::size_t(mesh_.nCells()) * readFields_);
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
