#include "fluidisation.hpp"

#include <cmath>

namespace hotbed
{
namespace
{

/// Force per volume of an original particle that drag and pressure gradient exert together [N/m3]: the drag alone over
/// the voidage.
double lift(DragLaw law, const Suspension& s, double voidage, double superficial)
{
    const double reynolds = s.gasDensity * superficial * s.diameter / s.viscosity;
    double logReynolds, beta;
    logarithms(1, &reynolds, &logReynolds);
    law(1, &voidage, &reynolds, &logReynolds, &beta);
    const double drag = dragCoefficient(beta, s.viscosity, voidage, s.diameter, 1.0) * superficial / voidage;
    return drag / voidage / (M_PI / 6.0 * s.diameter * s.diameter * s.diameter);
}

} // namespace

double carryingVelocity(DragLaw law, const Suspension& s, double voidage, double gravity)
{
    const double weight = (s.density - s.gasDensity) * gravity;
    if (!(weight > 0.0)) return 0.0;
    double low = 0.0, high = 1e-12;
    while (lift(law, s, voidage, high) < weight) low = high, high *= 2.0;
    for (int halved = 0; halved < 60; ++halved)
    {
        const double middle = 0.5 * (low + high);
        (lift(law, s, voidage, middle) < weight ? low : high) = middle;
    }
    return low;
}

double wenYuMinimumFluidisation(const Suspension& s, double gravity)
{
    const double weight = (s.density - s.gasDensity) * gravity;
    if (!(weight > 0.0)) return 0.0;
    const double archimedes = s.gasDensity * weight * std::pow(s.diameter, 3) / (s.viscosity * s.viscosity);
    const double square = 0.0408 * archimedes;
    // sqrt(33.7^2 + square) - 33.7 without cancellation
    const double reynolds = square / (std::sqrt(33.7 * 33.7 + square) + 33.7);
    return reynolds * s.viscosity / (s.gasDensity * s.diameter);
}

double bedPressureGradient(DragLaw law, const Suspension& s, double voidage, double superficial)
{
    return (1.0 - voidage) * lift(law, s, voidage, superficial);
}

} // namespace hotbed
