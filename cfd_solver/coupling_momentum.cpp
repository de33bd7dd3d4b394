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

/// What a particle gives: G, c (the fourth entry means nothing), V held.
struct Push
{
    double G;
    Row4 c;
    double volume;
};

/// Particles that the gas can move, from one on.
class Pushed
{
public:
    /// @param answers  of the first one: G, held, and others
    /// @param fields   from there to those of the next one
    Pushed(Dem& dem, const double* answers, int fields, int first)
        : m_(dem.mass() + first), radius_(dem.radius() + first), v_(dem.velocity() + first),
          force_(dem.force() + first), gasForce_(dem.gasForce() + first), alone_(dem.gasAlone() + first),
          answers_(answers), fields_(fields)
    {
    }

    Push operator[](int k) const
    {
        const double *answer = answers_ + k * fields_, *alone = alone_[k];
        const double G = answer[0], held = answer[1];
        const Row4 velocity = row(v_[k]), change = velocity - *reinterpret_cast<const Row4*>(alone);
        Push push = {G, G * velocity + held * m_[k] * alone[3] * change, held * volume(k)};
        if (!(alone[3] > 0.0)) // its first gas step: what forces there are now
            for (int a = 0; a < 3; ++a) push.c[a] = G * v_[k][a] + held * (force_[k][a] - gasForce_[k][a]);
        return push;
    }

    double volume(int k) const { return sphereVolume(radius_[k]); }

    /// Keeps the force of the gas, see FixHotbedDrag::alone.
    void keep(int k, Row4 force, double dt, double rate) const
    {
        *reinterpret_cast<Row4*>(alone_[k]) = row(v_[k]) + dt / m_[k] * force;
        alone_[k][3] = rate;
    }

    void fetch(int k) const
    {
        __builtin_prefetch(answers_ + k * fields_);
        __builtin_prefetch(alone_[k]);
        __builtin_prefetch(v_[k]);
        __builtin_prefetch(m_ + k);
        __builtin_prefetch(radius_ + k);
    }

    /// What setGasForce reads and writes
    void fetchForces(int k) const
    {
        __builtin_prefetch(force_[k], 1);
        __builtin_prefetch(gasForce_[k], 1);
    }

private:
    const double *m_, *radius_;
    const double (*v_)[3], (*force_)[3], (*gasForce_)[3];
    double (*alone_)[4];
    const double* answers_;
    int fields_;
};

} // namespace

/// What a particle does to the gas in a step, F = G u' - c + V held grad p', with the gas velocity u' and the pressure
/// gradient at the end of the step. A particle that the gas can move answers exactly to u' and to a constant
/// acceleration a from all other forces,
///     m dv/dt = B (u' - v) + m a,   b = B dt/m,   F = (m/dt) [gain (u' - v) - held a dt],   held = 1 - gain/b,
/// for any b: G is m/dt at most. `a` is that of the pressure gradient, -V grad p'/m, and of the rest, for which the
/// mean over the last gas step is taken: a particle at rest in a bed then feels all of B u', one that falls reaches its
/// terminal velocity. Both do so whatever `gain` is.
/// Sets answers: G, held; of particles that do not move B.
HOTBED_VECTORISED void Coupling::dragOn(int first, int count, const Seen& seen)
{
    const double* B = seen.B;
    if (!push_)
    {
        for (int k = 0; k < count; ++k) answers(first + k)[0] = B[k];
        return;
    }
    alignas(64) double volume[part], b[part], gain[part], held[part], G[part];
    const double dt = mesh_.time().deltaTValue(), rate = 1.0 / dt;
    const double *m = dem_.mass() + first, *radius = dem_.radius() + first;
    double most = 0.0;
#pragma omp simd reduction(max : most)
    for (int k = 0; k < count; ++k)
    {
        volume[k] = sphereVolume(radius[k]);
        b[k] = B[k] * dt / m[k];
        most = b[k] > most ? b[k] : most;
    }
    stiffest_ = std::max(stiffest_, most * rate);
    dragAnswer(count, seen.voidage, seen.density, m, volume, b, gain, held);
    for (int k = 0; k < count; ++k) G[k] = m[k] * gain[k] * rate;
    double* answer = answers(first);
    for (int k = 0; k < count; ++k, answer += answerFields_)
    {
        // what comes is on its way by then: rows that are only written wait for the memory, too
        __builtin_prefetch(answer + ahead * answerFields_, 1);
        answer[0] = G[k];
        answer[1] = held[k];
    }
}

/// Sets given: G, c (3), V held.
HOTBED_VECTORISED void Coupling::giveMomentum(int first, int count, double* given) const
{
    const Pushed particles(dem_, answers(first), answerFields_, first);
    for (int k = 0; k < count; ++k, given += sumFields_)
    {
        particles.fetch(k + ahead);
        const Push push = particles[k];
        given[0] = push.G;
        *reinterpret_cast<Row4*>(given + 1) = push.c;
        given[4] = push.volume;
    }
}

void Coupling::dragToGas(const label* cell, const label* end)
{
    Exchange& exchange = gas_.exchange();
    for (; cell != end; ++cell)
    {
        const label c = *cell;
        const double* sum = &cellSums_[place_[c] * sumFields_];
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
        double* read = &cellValues_[place_[c] * readFields_];
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
    const Pushed particles(dem_, answers(first), answerFields_, first);
    Row4 received = {}, dragReceived = {}, exchanged = {}; // the fourth entries mean nothing
    double forces[Mapping::block + 1][3];
    for (int k = 0; k < count; ++k, read += readFields_)
    {
        particles.fetch(k + ahead);
        particles.fetchForces(k + ahead);
        const Push push = particles[k];
        const Row4 velocity = *reinterpret_cast<const Row4*>(read), gradient = *reinterpret_cast<const Row4*>(read + 3);
        const Row4 drag = push.G * velocity - push.c + push.volume * gradient;
        const Row4 force = drag - particles.volume(k) * gradient;
        *reinterpret_cast<Row4*>(forces[k]) = force; // and into the next one's
        particles.keep(k, force, dt, rate);
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
