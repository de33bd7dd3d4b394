#pragma once

#include <algorithm>
#include <cmath>

namespace hotbed
{

/// Exact answer over one gas step of a particle quantity that relaxes towards the gas, dT/dt = (T_gas - T) / time,
/// where the gas value goes linearly from `before` to `after`:
///     T_new = decay T + early before + (1 - decay - early) after.
/// Every coefficient is in [0, 1] and they sum to 1, for any stiffness, so the particle never leaves the range of
/// its own and the gas values; with a constant gas it is the exact solution. Second order when the gas varies.
/// Used for heat (eq 15, 22) with stiffness = h A dt / (m c).
struct Relaxation
{
    double gain;  ///< 1 - decay: share of the gas values altogether
    double early; ///< share of the gas value before the step
};

/// @param stiffness step over relaxation time, >= 0 (infinity allowed)
inline Relaxation relaxation(double stiffness)
{
    const double b = stiffness, gain = -std::expm1(-b);
    // early = (1 - e^-b)/b - e^-b; its series below 0.02 avoids the cancellation, first term left out b^5/144
    const double series = b * (1.0 / 2 - b * (1.0 / 3 - b * (1.0 / 8 - b * (1.0 / 30 - b / 144))));
    const double early = gain / b - (1.0 - gain);
    return {gain, b < 0.02 ? series : early};
}

/// Decay of particles of one stiffness from early/gain, or a bit less; of different ones from the mean of early/gain,
/// never more than their mean decay. With L(x) = coth x - 1/x, Langevin's function, early/gain is (1 - L(b/2))/2, the
/// inverse of L is at most y (3 - y^2)/(1 - y^2) (Cohen 1991), and decay is convex in early/gain.
/// @param ratio  early over gain, sums with the same weights, (0, 1/2]
inline double leastDecay(double ratio)
{
    const double y = std::max(1.0 - 2.0 * ratio, 0.0); // below 0 by round-off
    return y < 1.0 ? std::exp(-2.0 * y * (3.0 - y * y) / ((1.0 - y) * (1.0 + y))) : 0.0;
}

/// The same as `relaxation` for n particles at a time.
/// @param gain, early  set
void relaxation(int n, const double* stiffness, double* gain, double* early);

/// What n particles answer to the drag of a gas step. Their gain is made smaller where gas and particles, which take
/// turns, would excite each other. The gas sees in which way particles have closed its path only in the next step;
/// between the two a disturbance grows by 1 - lambda from step to step in a gas that cannot be compressed, lambda being
/// how far a pressure that stops the gas moves the particles. It is kept at 1.5 at most: in dense beds of particles
/// that follow the gas within a step or are as light as it is these then answer in a few steps.
/// @param voidage     gas holdup at the particle, (0, 1]
/// @param gasDensity  [kg/m3]
/// @param mass        of the particle [kg]
/// @param volume      of the particle [m3]
/// @param stiffness   step over relaxation time, >= 0
/// @param gain        set: share of the gas velocity that the particle takes on
/// @param held        set: share of the work of other forces that the drag takes, 1 - gain/stiffness
void dragAnswer(int n, const double* voidage, const double* gasDensity, const double* mass, const double* volume,
                const double* stiffness, double* gain, double* held);

} // namespace hotbed
