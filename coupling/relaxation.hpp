#pragma once

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
    const double gain = -std::expm1(-stiffness);
    // early = (1 - e^-b)/b - e^-b; its series below 0.02 avoids the cancellation, first term left out b^5/144
    if (stiffness < 0.02)
    {
        const double b = stiffness;
        return {gain, b * (1.0 / 2 - b * (1.0 / 3 - b * (1.0 / 8 - b * (1.0 / 30 - b / 144))))};
    }
    return {gain, gain / stiffness - (1.0 - gain)};
}

} // namespace hotbed
