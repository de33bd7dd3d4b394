#include "coupling.hpp"

#include "relaxation.hpp"
#include "vectorised.hpp"

using namespace Foam;

namespace hotbed
{
/// The particle's exact answer to a gas temperature that is linear in time (relaxation.hpp), pair by pair:
/// cell c gets  w [G (T_i - T_c') - early_c X (T_c - T_c')]  with G = m c gain / dt, X = m c early / dt. The share
/// early_c of the first-order term is 1 wherever that keeps the gas bounded and a closed pair from passing its
/// equilibrium, and falls to 0 (fully implicit) as the gas gets stiff. With `exchange implicit` G is h A and X is 0.
/// Sets answers: gain, early.
HOTBED_VECTORISED void Coupling::heatOn(int first, int count, const Seen& seen)
{
    alignas(64) double mc[part], b[part], gain[part], early[part];
    const double dt = mesh_.time().deltaTValue();
    dem_.heatCapacity(first, count, mc);
    for (int k = 0; k < count; ++k) b[k] = gain[k] = seen.conductance[k] * dt / mc[k];
    if (settings_.linearExchange)
        relaxation(count, b, gain, early);
    else
        std::fill_n(early, count, 0.0);
    double* answer = answers(first) + answerHeatAt_;
    for (int k = 0; k < count; ++k, answer += answerFields_)
    {
        answer[0] = gain[k];
        answer[1] = early[k];
    }
}

/// Sets given: G, X, G T from the reference on, G x (3).
HOTBED_VECTORISED void Coupling::giveHeat(int first, int count, double* given) const
{
    alignas(64) double mc[part];
    const double rate = 1.0 / mesh_.time().deltaTValue(), reference = gas_.exchange().reference;
    const double(*x)[3] = dem_.position() + first;
    const double *T = dem_.temperature() + first, *answer = answers(first) + answerHeatAt_;
    dem_.heatCapacity(first, count, mc);
    for (int k = 0; k < count; ++k, answer += answerFields_, given += sumFields_)
    {
        __builtin_prefetch(T + k + ahead);
        const double perShare = mc[k] * rate, G = perShare * answer[0];
        given[0] = G;
        given[1] = perShare * answer[1];
        *reinterpret_cast<Row4*>(given + 2) = G * Row4{T[k] - reference, x[k][0], x[k][1], x[k][2]};
    }
}

void Coupling::heatToGas(const label* cell, const label* end)
{
    const double dt = mesh_.time().deltaTValue();
    Exchange& exchange = gas_.exchange();
    for (; cell != end; ++cell)
    {
        const label c = *cell;
        const double* sum = &cellSums_[place_[c] * sumFields_ + heatAt_];
        const double G = sum[0], X = sum[1];
        const double capacity = gas_.mass()[c] * specificHeat_[c] * mesh_.V()[c];
        early_[c] = X > 0.0 ? std::min(1.0, capacity / dt * leastDecay(X / G) / X) : 0.0;
        exchange.conductance[c] = G - early_[c] * X;
        exchange.heatSource[c] = sum[2] - early_[c] * X * (temperatureBefore_[c] - exchange.reference);
    }
}

/// The gas temperature at the particle rather than at its cells: a linear profile about the exchange-weighted centre of
/// the particles of the cell, so that nothing changes for the gas, limited so that no reading leaves the range of the
/// gas. Without it the kernel spreads heat fronts like a conduction that grows with l.
/// @param slope  gradient of the gas enthalpy, which the convection scheme has made; null: the temperature of the cells
/// @param range  of the gas temperature before and after its step, all cells
void Coupling::heatInCells(const label* cell, const label* end, const volVectorField* slope, const scalarMinMax& range)
{
    const scalarField& T = gas_.exchangeTemperature();
    const Exchange& exchange = gas_.exchange();
    for (; cell != end; ++cell)
    {
        const label c = *cell;
        const double* sum = &cellSums_[place_[c] * sumFields_ + heatAt_];
        double* f = &cellValues_[place_[c] * readFields_ + readHeatAt_];
        f[0] = T[c] - exchange.reference;
        f[1] = f[2] = f[3] = 0.0;
        f[4] = early_[c] * (temperatureBefore_[c] - T[c]);
        if (!slope || !(sum[0] > 0.0)) continue;
        vector gradient = (*slope)[c] / specificHeat_[c];
        const vector centre = vector(sum[3], sum[4], sum[5]) / sum[0];
        scalar change = 0.0; // the most that a particle of this cell can be off its reading
        for (int a = 0; a < 3; ++a)
            change += mag(gradient[a]) * (widest_ + halfExtent_[c][a] + mag(centre[a] - mesh_.C()[c][a]));
        // what a particle sees on average over the step lies between T and, where `early` is all of half the gain,
        // the middle between before and after: no reading may leave the range from either
        const scalar middle = T[c] + 0.5 * f[4];
        const scalar room = max(min(min(T[c], middle) - range.min(), range.max() - max(T[c], middle)), 0.0);
        if (change > room) gradient *= room / change;
        for (int a = 0; a < 3; ++a)
        {
            f[0] -= gradient[a] * centre[a];
            f[1 + a] = gradient[a];
        }
    }
}

HOTBED_VECTORISED void Coupling::heatToParticles(int first, int count, const double* read)
{
    const double reference = gas_.exchange().reference;
    const double(*x)[3] = dem_.position() + first;
    const double *T = dem_.temperature() + first, *answer = answers(first) + answerHeatAt_;
    double mc[Mapping::block], change[Mapping::block], sum = 0.0, exchanged = 0.0;
    dem_.heatCapacity(first, count, mc);
    for (int k = 0; k < count; ++k, read += readFields_, answer += answerFields_)
    {
        __builtin_prefetch(x[k + ahead]);
        __builtin_prefetch(T + k + ahead);
        const double* r = read + readHeatAt_; // T - grad T . x, grad T, what the early share adds
        const double gas = r[0] + r[1] * x[k][0] + r[2] * x[k][1] + r[3] * x[k][2];
        change[k] = answer[0] * (gas - (T[k] - reference)) + answer[1] * r[4];
        const double heat = mc[k] * change[k];
        sum += heat;
        exchanged += std::abs(heat);
    }
    heatReceived_ += sum;
    heatExchanged_ += exchanged;
    dem_.warm(first, count, change);
}

void Coupling::heatMismatch()
{
    reduce(heatExchanged_, sumOp<double>());
    const scalarField& T = gas_.exchangeTemperature();
    const Exchange& exchange = gas_.exchange();
    const double dt = mesh_.time().deltaTValue();
    double mismatch = heatReceived_;
    for (const label c : reached_)
        mismatch += dt * (exchange.heatSource[c] - exchange.conductance[c] * (T[c] - exchange.reference));
    reduce(mismatch, sumOp<double>());
    mismatch_ = std::max(mismatch_, relative(std::abs(mismatch), heatExchanged_));
}

} // namespace hotbed
