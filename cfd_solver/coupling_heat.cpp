#include "coupling.hpp"

#include "relaxation.hpp"

#include <numeric>

using namespace Foam;

namespace hotbed
{
namespace
{

constexpr int heatSums = 8;     // G, X, G T, G decay, G x, and nothing: a cache line
constexpr double hottest = 1e5; // [K], beyond it something is wrong
constexpr int readFields = 8;   // T - grad T . x, grad T, what the early share adds

} // namespace

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
        if (!(T[i] > 0.0 && T[i] < hottest))
            FatalErrorInFunction << dem_.describe(i).c_str() << " has the temperature " << T[i]
                                 << " K. Likely the DEM script gives it (initial_temperature of fix hotbed/heat, set, "
                                 << "set_property), or the heat capacity or an inlet temperature is impossible. The "
                                 << "restarts written before are whole" << exit(FatalError);
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
