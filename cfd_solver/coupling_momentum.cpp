#include "coupling.hpp"

#include "relaxation.hpp"
#include "vectorised.hpp"

#include <cmath>

using namespace Foam;

namespace hotbed
{
namespace
{

inline Row4 row(const double (&x)[3])
{
    return Row4{x[0], x[1], x[2], 0.0};
}

} // namespace

/// What a particle does to the gas in a step, F = G u' - c + V held grad p', with the gas velocity u' and the pressure
/// gradient at the end of the step. A particle that the gas can move answers exactly to u' and to a constant
/// acceleration a from all other forces,
///     m dv/dt = B (u' - v) + m a,   b = B dt/m,   F = (m/dt) [gain (u' - v) - held a dt],   held = 1 - gain/b,
/// for any b: G is m/dt at most. `a` is that of the pressure gradient, -V grad p'/m, and of the rest, for which the
/// mean over the last gas step is taken: a particle at rest in a bed then feels all of B u', one that falls reaches its
/// terminal velocity. Both do so whatever `gain` is.
/// Sets given_: G, c, V held.
HOTBED_VECTORISED void Coupling::dragOn(int first, int count, const Seen& seen)
{
    const double* B = seen.B;
    double* given = &given_[std::size_t(first) * givenFields_];
    if (!push_)
    {
        for (int k = 0; k < count; ++k) given[k * givenFields_] = B[k];
        return;
    }
    alignas(64) double volume[part], b[part], gain[part], held[part], G[part], others[part];
    const double dt = mesh_.time().deltaTValue(), rate = 1.0 / dt;
    const double *m = dem_.mass() + first, *radius = dem_.radius() + first;
    for (int k = 0; k < count; ++k)
    {
        volume[k] = sphereVolume(radius[k]);
        b[k] = B[k] * dt / m[k];
    }
    dragAnswer(count, seen.voidage, seen.density, m, volume, b, gain, held);

    const double(*v)[3] = dem_.velocity() + first;
    const double(*alone)[4] = dem_.gasAlone() + first;
    for (int k = 0; k < count; ++k)
    {
        G[k] = m[k] * gain[k] * rate;
        others[k] = held[k] * m[k] * alone[k][3];
        volume[k] *= held[k];
    }
    for (int k = 0; k < count; ++k, given += givenFields_)
    {
        // what comes is on its way by then: rows that are only written wait for the memory, too
        __builtin_prefetch(given + 32 * givenFields_, 1);
        __builtin_prefetch(alone[k + 32]);
        const Row4 velocity = row(v[k]), change = velocity - *reinterpret_cast<const Row4*>(alone[k]);
        given[0] = G[k];
        *reinterpret_cast<Row4*>(given + 1) = G[k] * velocity + others[k] * change;
        given[4] = volume[k];
        if (alone[k][3] > 0.0) continue;
        // its first gas step: what forces there are now
        for (int a = 0; a < 3; ++a)
            given[1 + a] = G[k] * v[k][a] + held[k] * (dem_.force()[first + k][a] - dem_.gasForce()[first + k][a]);
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
    const double dt = mesh_.time().deltaTValue(), rate = 1.0 / dt;
    const double *radius = dem_.radius() + first, *m = dem_.mass() + first;
    const double(*v)[3] = dem_.velocity() + first;
    double(*alone)[4] = dem_.gasAlone() + first;
    const double* given = &given_[std::size_t(first) * givenFields_];
    Row4 received = {}, dragReceived = {}, exchanged = {}; // the fourth entries mean nothing
    double forces[Mapping::block + 1][3];
    for (int k = 0; k < count; ++k, read += readFields_, given += givenFields_)
    {
        const Row4 velocity = *reinterpret_cast<const Row4*>(read), gradient = *reinterpret_cast<const Row4*>(read + 3);
        const Row4 drag = given[0] * velocity - *reinterpret_cast<const Row4*>(given + 1) + given[4] * gradient;
        const Row4 force = drag - sphereVolume(radius[k]) * gradient;
        __builtin_prefetch(alone[k + 32], 1);        // as above
        *reinterpret_cast<Row4*>(forces[k]) = force; // and into the next one's
        *reinterpret_cast<Row4*>(alone[k]) = row(v[k]) + dt / m[k] * force;
        alone[k][3] = rate;
        received += force;
        dragReceived += drag;
        exchanged += drag > 0.0 ? drag : -drag;
    }
    dem_.setGasForce(first, count, forces);
    impulse_ += dt * vector(received[0], received[1], received[2]);
    dragReceived_ += vector(dragReceived[0], dragReceived[1], dragReceived[2]);
    dragExchanged_ += exchanged[0] + exchanged[1] + exchanged[2];
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
