#include "coupling.hpp"

#include "relaxation.hpp"

#include <cmath>

using namespace Foam;

namespace hotbed
{
namespace
{

constexpr int pushFields = 8; // U, grad p

} // namespace

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

} // namespace hotbed
