#include "closures.hpp"

#include <cmath>

namespace hotbed
{

double beetstra(double voidage, double reynolds)
{
    const double solids = 1.0 - voidage;
    const double creeping = 10.0 * solids / (voidage * voidage) + voidage * voidage * (1.0 + 1.5 * std::sqrt(solids));
    // below this the rest is lost in the last digit, and the powers would overflow
    if (!(reynolds > 1e-12)) return creeping;

    // powers as exponentials of one logarithm: this is evaluated for every particle in every gas step
    const double log = std::log(reynolds);
    const double top = reynolds * (1.0 / voidage + 3.0 * voidage * solids) + 8.4 * std::exp(0.657 * log);
    const double bottom = 1.0 + std::exp(3.0 * M_LN10 * solids - (0.5 + 2.0 * solids) * log);
    return creeping + 0.413 / (24.0 * voidage * voidage) * top / bottom;
}

double ergunWenYu(double voidage, double reynolds)
{
    if (voidage < 0.8) return (150.0 * (1.0 - voidage) + 1.75 * reynolds) / (18.0 * voidage * voidage);
    const double single = reynolds < 1000.0 ? 1.0 + 0.15 * std::pow(reynolds, 0.687) : 0.44 / 24.0 * reynolds;
    return single * std::pow(voidage, -3.65);
}

double gunn(double voidage, double reynolds, double prandtl)
{
    const double pr = std::cbrt(prandtl);
    const double re = reynolds > 0.0 ? std::exp(0.1 * std::log(reynolds)) : 0.0;
    const double re2 = re * re;
    const double re7 = re2 * re2 * re2 * re;
    const double e2 = voidage * voidage;
    return (7.0 - 10.0 * voidage + 5.0 * e2) * (1.0 + 0.7 * re2 * pr) + (1.33 - 2.40 * voidage + 1.20 * e2) * re7 * pr;
}

double effectiveConductivity(double voidage)
{
    return 1.0 / (1.0 + std::sqrt(1.0 - voidage));
}

double dragCoefficient(double beta, double viscosity, double voidage, double diameter, double ratio)
{
    return 3.0 * M_PI * viscosity * voidage * (ratio * diameter) * (ratio * ratio * beta);
}

double heatConductance(double nusselt, double conductivity, double diameter, double ratio)
{
    return ratio * ratio * ratio * M_PI * nusselt * conductivity * diameter;
}

double dashpot(double restitution, double stiffness, double mass)
{
    const double log = std::log(restitution);
    return -2.0 * log * std::sqrt(mass * stiffness) / std::sqrt(M_PI * M_PI + log * log);
}

double tangentialStiffness(double normalStiffness, double normalRestitution, double tangentialRestitution)
{
    const double n = std::log(normalRestitution);
    const double t = std::log(tangentialRestitution);
    return 2.0 / 7.0 * normalStiffness * (M_PI * M_PI + t * t) / (M_PI * M_PI + n * n);
}

} // namespace hotbed
