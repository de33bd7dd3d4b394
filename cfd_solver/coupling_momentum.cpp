#include "coupling.hpp"

#include "relaxation.hpp"
#include "vectorised.hpp"

#include <cmath>

using namespace Foam;

namespace hotbed
{
/// What a particle does to the gas in a step, F = G u' - c + V held grad p', with the gas velocity u' and the pressure
/// gradient at the end of the step. A particle that the gas can move answers exactly to u' and to a constant
/// acceleration a from all other forces,
///     m dv/dt = B (u' - v) + m a,   b = B dt/m,   F = (m/dt) [gain (u' - v) - held a dt],   held = 1 - gain/b,
/// for any b: G is m/dt at most. `a` is that of the pressure gradient, -V grad p'/m, and of the rest, for which the
/// mean over the last gas step is taken: a particle at rest in a bed then feels all of B u', one that falls reaches its
/// terminal velocity. Both do so whatever `gain` is.
/// @param gas  voidage, velocity, density, ... at the particles
/// @param B    [kg/s]; given_ is set: G, c, V held
HOTBED_VECTORISED void Coupling::dragOn(int first, int count, const double* gas, const double* B)
{
    double* given = &given_[std::size_t(first) * givenFields_];
    if (!push_)
    {
        for (int k = 0; k < count; ++k) given[k * givenFields_] = B[k];
        return;
    }
    constexpr int block = Mapping::block;
    alignas(64) double voidage[block], gasDensity[block], density[block], b[block], gain[block], early[block],
        held[block]; // share of other forces' work that the drag takes in the step
    const double dt = mesh_.time().deltaTValue(), rate = 1.0 / dt;
    const double *m = dem_.mass() + first, *radius = dem_.radius() + first;
    for (int k = 0; k < count; ++k)
    {
        voidage[k] = gas[k * gasFields];
        gasDensity[k] = gas[k * gasFields + 4];
        density[k] = m[k] / sphereVolume(radius[k]);
        b[k] = B[k] * dt / m[k];
    }
    relaxation(count, b, gain, early);
    boundGain(count, voidage, gasDensity, density, b, gain);
    for (int k = 0; k < count; ++k) held[k] = B[k] > 0.0 ? 1.0 - gain[k] / (B[k] > 0.0 ? b[k] : 1.0) : 0.0;

    const double(*v)[3] = dem_.velocity() + first;
    const double(*lasts)[4] = dem_.lastGasStep() + first;
    const double(*gasForce)[3] = dem_.gasForce() + first;
    const double(*force)[3] = dem_.force() + first;
    for (int k = 0; k < count; ++k, given += givenFields_)
    {
        const double* last = lasts[k];
        const double momentum = last[3] > 0.0 ? m[k] / last[3] : 0.0;
        given[0] = m[k] * gain[k] * rate;
        for (int a = 0; a < 3; ++a)
        {
            const double all = last[3] > 0.0 ? momentum * (v[k][a] - last[a]) : force[k][a];
            const double other = all - gasForce[k][a];
            given[1 + a] = given[0] * v[k][a] + held[k] * other;
        }
        given[4] = held[k] * sphereVolume(radius[k]);
    }
}

void Coupling::dragToGas(const label* cell, const label* end)
{
    Exchange& exchange = gas_.exchange();
    for (; cell != end; ++cell)
    {
        const label c = *cell;
        const double* sum = &cellSums_[std::size_t(c) * sumFields_];
        exchange.drag[c] = sum[0];
        if (!push_) continue;
        for (int a = 0; a < 3; ++a) exchange.dragSource[c][a] = sum[1 + a];
        exchange.passedOn[c] = sum[4];
    }
}

void Coupling::momentumInCells(const label* cell, const label* end)
{
    const vectorField& U = gas_.U();
    const vectorField& gradient = gas_.pressureGradient();
    for (; cell != end; ++cell)
    {
        const label c = *cell;
        double* read = &cellValues_[std::size_t(c) * readFields_];
        for (int a = 0; a < 3; ++a)
        {
            read[a] = U[c][a];
            read[3 + a] = gradient[c][a];
        }
    }
}

/// Force of the gas, constant over the DEM steps of the gas step: the drag that the gas equation used, with the gas
/// velocity at the end of its step, and the pressure gradient (eq 16).
HOTBED_VECTORISED void Coupling::momentumToParticles(int first, int count, const double* read)
{
    const double dt = mesh_.time().deltaTValue();
    const double* radius = dem_.radius();
    const double(*v)[3] = dem_.velocity();
    double(*lasts)[4] = dem_.lastGasStep();
    vector received(Zero), dragReceived(Zero), exchanged(Zero); // by axis: sums of their own do not wait for each other
    double forces[Mapping::block][3];
    for (int i = first; i < first + count; ++i, read += readFields_)
    {
        const double* given = &given_[std::size_t(i) * givenFields_];
        const double volume = sphereVolume(radius[i]);
        double* force = forces[i - first];
        double* last = lasts[i];
        for (int a = 0; a < 3; ++a)
        {
            const double drag = given[0] * read[a] - given[1 + a] + given[4] * read[3 + a];
            force[a] = drag - volume * read[3 + a];
            last[a] = v[i][a];
            received[a] += force[a];
            dragReceived[a] += drag;
            exchanged[a] += std::abs(drag);
        }
        last[3] = dt;
    }
    dem_.setGasForce(first, count, forces);
    impulse_ += dt * received;
    dragReceived_ += dragReceived;
    dragExchanged_ += cmptSum(exchanged);
}

void Coupling::momentumMismatch()
{
    const vectorField& U = gas_.U();
    const vectorField& gradient = gas_.pressureGradient();
    const Exchange& exchange = gas_.exchange();
    vector dragGiven(Zero);
    for (const label c : reached_)
        dragGiven += exchange.drag[c] * U[c] - exchange.dragSource[c] + exchange.passedOn[c] * gradient[c];
    reduce(impulse_, sumOp<vector>());
    mismatch_ = relative(mag(returnReduce(vector(dragGiven - dragReceived_), sumOp<vector>())),
                         returnReduce(dragExchanged_, sumOp<double>()));
}

} // namespace hotbed
