#include "coupling.hpp"

#include "closures.hpp"
#include "meshSearch.H"
#include "relaxation.hpp"

#include <cmath>
#include <numeric>

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

double relative(double difference, double size)
{
    return size > 0.0 ? difference / size : difference;
}

double sphereVolume(double radius)
{
    return 4.0 / 3.0 * M_PI * radius * radius * radius;
}

constexpr int gasFields = 8;  // voidage, U, rho, mu, kappa, Cp: one cache line a cell
constexpr int heatSums = 8;   // G, X, G T, G decay, G x, and nothing: a cache line
constexpr int pushFields = 8; // U, grad p
constexpr int readFields = 8; // T - grad T . x, grad T, what the early share adds

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
    sampled_ = true;
    Info << "Mapping: cells of any shape, kernel sampled at " << settings.kernelSamples << "^3 points" << nl;
    Box bounds;
    if (mesh_.nCells())
    {
        const boundBox mine(mesh_.points(), false);
        for (int a = 0; a < 3; ++a)
        {
            bounds.low[a] = mine.min()[a];
            bounds.high[a] = mine.max()[a];
        }
    }
    auto search = std::make_shared<meshSearch>(mesh_);
    return std::make_unique<SampledCells>(
        int(mesh_.nCells()), bounds,
        [search](const Point& x) { return int(search->findCell(point(x[0], x[1], x[2]))); }, settings.kernelSamples);
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
        scalar smallest = GREAT; // extent of a cell
        for (const vector& half : halfExtent_) smallest = min(smallest, 2 * cmptMin(half));
        reduce(smallest, minOp<scalar>());
        const int samples = int(std::ceil(2 * 2 * widest_ / smallest)); // two in the smallest cell
        FatalErrorInFunction << "the voidage of a cell is " << least << ": the particles overlap too much, or ";
        if (sampled_ && settings_.kernelSamples < samples)
            FatalError << "the kernel has too few samples for the cells (set kernelSamples in "
                       << "constant/couplingProperties to " << samples << ", it is " << settings_.kernelSamples << ')';
        else
            FatalError << "the kernel is too narrow for the cells (set a larger kernelWidth in "
                       << "constant/couplingProperties)";
        FatalError << exit(FatalError);
    }
    voidage.correctBoundaryConditions();
    mapped_ = true;
}

void Coupling::particlesToGas()
{
    closures();
    if (heat_) heatToGas();
}

/// What a particle does to the gas in a step, F = G u' - c + V held grad p', with the gas velocity u' and the pressure
/// gradient at the end of the step. A particle that the gas can move answers exactly to u' and to a constant
/// acceleration a from all other forces,
///     m dv/dt = B (u' - v) + m a,   b = B dt/m,   F = (m/dt) [gain (u' - v) - held a dt],   held = 1 - gain/b,
/// for any b: G is m/dt at most. `a` is that of the pressure gradient, -V grad p'/m, and of the rest, for which the
/// mean over the last gas step is taken: a particle at rest in a bed then feels all of B u', one that falls reaches its
/// terminal velocity. Both do so whatever `gain` is.
///
/// Gas and particles take turns: the gas sees in which way particles have closed its path only in the next step.
/// Between the two a disturbance grows by 1 - lambda from step to step in a gas that cannot be compressed, lambda being
/// how far a pressure that stops the gas moves the particles. Where it would be more than 1.5, in dense beds of
/// particles that follow the gas within a step or are as light as it is, `gain` is made smaller: they answer in a few
/// steps.
/// @param gas       voidage, velocity, density, ... at the particle
/// @param exchange  G, c, V held
void Coupling::dragOn(int i, double B, const double* gas, double* exchange) const
{
    std::fill_n(exchange, dragFields_, 0.0);
    exchange[0] = B;
    if (!push_ || !(B > 0.0)) return;
    const double dt = mesh_.time().deltaTValue();
    const double m = dem_.mass()[i];
    const double volume = sphereVolume(dem_.radius()[i]);
    const double b = B * dt / m;
    double gain = relaxation(b).gain;

    const double voidage = gas[0];
    const double fluid = voidage * gas[4], solids = (1.0 - voidage) * m / volume; // in a volume of the bed [kg/m3]
    const double follows = gain * solids / (fluid + gain * solids); // what the gas takes on of the particles' velocity
    const double gasPushed = voidage + (1.0 - gain / b) * (1.0 - voidage);
    const double lambda =
        ((1.0 - voidage) / voidage + follows) * (gain + gain / b * (fluid + gain * solids) / (m / volume * gasPushed));
    if (lambda > 1.5) gain *= 1.5 / lambda;

    const double held = 1.0 - gain / b; // share of other forces' work that the drag takes in the step
    const double* v = dem_.velocity()[i];
    const double* last = dem_.lastGasStep()[i];
    exchange[0] = m * gain / dt;
    for (int a = 0; a < 3; ++a)
    {
        const double other =
            last[6] > 0.0 ? m * (v[a] - last[a]) / last[6] - last[3 + a] : dem_.force()[i][a] - dem_.gasForce()[i][a];
        exchange[1 + a] = exchange[0] * v[a] + held * other;
    }
    exchange[4] = held * volume;
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

/// The particle's exact answer to a gas temperature that is linear in time (relaxation.hpp), pair by pair:
/// cell c gets  w [G (T_i - T_c') - early_c X (T_c - T_c')]  with G = m c gain / dt, X = m c early / dt. The share
/// early_c of the first-order term is 1 wherever that keeps the gas bounded and a closed pair from passing its
/// equilibrium, and falls to 0 (fully implicit) as the gas gets stiff. With `exchange implicit` G is h A and X is 0.
void Coupling::heatToGas()
{
    const auto time = timing_.measure("heat to gas");
    const double dt = mesh_.time().deltaTValue();
    const int n = dem_.size();
    const double* T = dem_.temperature();
    heatGiven_.resize(std::size_t(n) * 4);
    // temperatures from a common one on: in a well mixed bed the differences that drive the heat are small
    double sum[2] = {std::accumulate(T, T + n, 0.0), double(n)};
    MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    Exchange& exchange = gas_.exchange();
    exchange.reference = sum[1] > 0.0 ? sum[0] / sum[1] : 0.0;
    for (int i = 0; i < n; ++i)
    {
        const double mc = dem_.heatCapacity(i);
        const double b = conductance_[i] * dt / mc;
        const Relaxation r = settings_.linearExchange ? relaxation(b) : Relaxation{b, 0.0};
        double* give = &heatGiven_[std::size_t(i) * 4];
        give[0] = mc * r.gain / dt;
        give[1] = mc * r.early / dt;
        give[2] = T[i] - exchange.reference;
        give[3] = 1.0 - r.gain;
    }
    const double* copy = mapping_.toCopies(4, heatGiven_.data());
    copyHeat_.resize(std::size_t(mapping_.copies()) * heatSums);
    for (int k = 0; k < mapping_.copies(); ++k)
    {
        const double* give = copy + std::size_t(k) * 4;
        const Point& x = mapping_.copyPosition(k);
        double* sum = &copyHeat_[std::size_t(k) * heatSums];
        sum[0] = give[0];
        sum[1] = give[1];
        sum[2] = give[0] * give[2];
        sum[3] = give[0] * give[3];
        for (int a = 0; a < 3; ++a) sum[4 + a] = give[0] * x[a];
    }
    cellHeat_.assign(std::size_t(mesh_.nCells()) * heatSums, 0.0);
    mapping_.deposit(heatSums, copyHeat_.data(), cellHeat_.data());

    temperatureBefore_ = gas_.T().primitiveField();
    const scalarField capacity(gas_.heatCapacity());
    early_.resize(mesh_.nCells());
    for (label c = 0; c < mesh_.nCells(); ++c)
    {
        const double* sum = &cellHeat_[std::size_t(c) * heatSums];
        const double G = sum[0], X = sum[1];
        early_[c] = X > 0.0 ? std::min(1.0, capacity[c] / dt * (sum[3] / G) / X) : 0.0;
        exchange.conductance[c] = G - early_[c] * X;
        exchange.heatSource[c] = sum[2] - early_[c] * X * (temperatureBefore_[c] - exchange.reference);
    }
}

void Coupling::gasToParticles()
{
    mismatch_ = 0.0;
    if (push_) momentumToParticles();
    if (heat_) heatToParticles();
}

/// Force of the gas, constant over the DEM steps of the gas step: the drag that the gas equation used, with the gas
/// velocity at the end of its step, and the pressure gradient (eq 16).
void Coupling::momentumToParticles()
{
    const auto time = timing_.measure("momentum to particles");
    const vectorField& U = gas_.U();
    const vectorField& gradient = gas_.pressureGradient();
    cellValues_.resize(std::size_t(mesh_.nCells()) * pushFields);
    for (label c = 0; c < mesh_.nCells(); ++c)
        for (int a = 0; a < 3; ++a)
        {
            cellValues_[std::size_t(c) * pushFields + a] = U[c][a];
            cellValues_[std::size_t(c) * pushFields + 3 + a] = gradient[c][a];
        }
    const double* read = mapping_.interpolate(pushFields, cellValues_.data());
    const double dt = mesh_.time().deltaTValue();
    const double(*v)[3] = dem_.velocity();
    vector received(Zero), dragReceived(Zero), dragGiven(Zero);
    double exchanged = 0.0;
    for (int i = 0; i < dem_.size(); ++i)
    {
        const double* r = read + std::size_t(i) * pushFields;
        const double* exchange = &drag_[std::size_t(i) * dragFields_];
        const double volume = sphereVolume(dem_.radius()[i]);
        double force[3];
        double* last = dem_.lastGasStep()[i];
        for (int a = 0; a < 3; ++a)
        {
            const double drag = exchange[0] * r[a] - exchange[1 + a] + exchange[4] * r[3 + a];
            force[a] = drag - volume * r[3 + a];
            last[a] = v[i][a];
            last[3 + a] = force[a];
            received[a] += force[a];
            dragReceived[a] += drag;
            exchanged += std::abs(drag);
        }
        last[6] = dt;
        dem_.setGasForce(i, force);
    }
    const Exchange& exchange = gas_.exchange();
    for (label c = 0; c < mesh_.nCells(); ++c)
        dragGiven += exchange.drag[c] * U[c] - exchange.dragSource[c] + exchange.passedOn[c] * gradient[c];
    impulse_ = dt * returnReduce(received, sumOp<vector>());
    mismatch_ = relative(mag(returnReduce(vector(dragGiven - dragReceived), sumOp<vector>())),
                         returnReduce(exchanged, sumOp<double>()));
}

void Coupling::heatToParticles()
{
    const auto time = timing_.measure("heat to particles");
    const scalarField& T = gas_.exchangeTemperature();
    const Exchange& exchange = gas_.exchange();

    // The gas temperature at the particle rather than at its cells: a linear profile about the exchange-weighted
    // centre of the particles of the cell, so that nothing changes for the gas, limited so that no reading leaves the
    // range of the gas. Without it the kernel spreads heat fronts like a conduction that grows with l.
    vectorField gradient(mesh_.nCells(), Zero);
    if (settings_.temperatureGradient)
    {
        gradient = fvc::grad(gas_.T())().primitiveField();
        const scalar lowest = min(min(gMin(T), gMin(temperatureBefore_)), gMin(gas_.T()));
        const scalar highest = max(max(gMax(T), gMax(temperatureBefore_)), gMax(gas_.T()));
        for (label c = 0; c < mesh_.nCells(); ++c)
        {
            const double* sum = &cellHeat_[std::size_t(c) * heatSums];
            if (!(sum[0] > 0.0)) continue;
            scalar change = 0.0; // the most that a particle of this cell can be off its reading
            for (int a = 0; a < 3; ++a)
                change +=
                    mag(gradient[c][a]) * (widest_ + halfExtent_[c][a] + mag(sum[4 + a] / sum[0] - mesh_.C()[c][a]));
            // what a particle sees on average over the step lies between T and, where `early` is all of half the gain,
            // the middle between before and after: no reading may leave the range from either
            const scalar middle = T[c] + 0.5 * early_[c] * (temperatureBefore_[c] - T[c]);
            const scalar room = max(min(min(T[c], middle) - lowest, highest - max(T[c], middle)), 0.0);
            if (change > room) gradient[c] *= room / change;
        }
    }

    cellValues_.resize(std::size_t(mesh_.nCells()) * readFields);
    for (label c = 0; c < mesh_.nCells(); ++c)
    {
        const double* sum = &cellHeat_[std::size_t(c) * heatSums];
        double* f = &cellValues_[std::size_t(c) * readFields];
        f[0] = T[c] - exchange.reference;
        f[1] = f[2] = f[3] = 0.0;
        if (sum[0] > 0.0)
            for (int a = 0; a < 3; ++a)
            {
                f[0] -= gradient[c][a] * sum[4 + a] / sum[0];
                f[1 + a] = gradient[c][a];
            }
        f[4] = early_[c] * (temperatureBefore_[c] - T[c]);
    }
    const double* read = mapping_.interpolate(readFields, cellValues_.data());

    const double dt = mesh_.time().deltaTValue();
    const double(*x)[3] = dem_.position();
    const int n = dem_.size();
    heatReceived_.resize(n);
    heatExchanged_ = 0.0;
    for (int i = 0; i < n; ++i)
    {
        const double* r = read + std::size_t(i) * readFields;
        const double* given = &heatGiven_[std::size_t(i) * 4];
        const double gas = r[0] + r[1] * x[i][0] + r[2] * x[i][1] + r[3] * x[i][2];
        heatReceived_[i] = dt * (given[0] * (gas - given[2]) + given[1] * r[4]);
        heatExchanged_ += std::abs(heatReceived_[i]);
    }
    reduce(heatExchanged_, sumOp<double>());
    dem_.receive(heatReceived_.data());

    double mismatch = std::accumulate(heatReceived_.begin(), heatReceived_.end(), 0.0);
    for (label c = 0; c < mesh_.nCells(); ++c)
        mismatch += dt * (exchange.heatSource[c] - exchange.conductance[c] * (T[c] - exchange.reference));
    reduce(mismatch, sumOp<double>());
    mismatch_ = std::max(mismatch_, relative(std::abs(mismatch), heatExchanged_));
}

} // namespace hotbed
