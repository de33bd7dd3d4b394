#include "fluidisation.hpp"

#include <gtest/gtest.h>

#include <cmath>

using namespace hotbed;

namespace
{

constexpr double g = 9.81;
// gamma-alumina in nitrogen, Table 2 of the paper; glass beads of 2 mm
const Suspension alumina = {5e-4, 1040, 1.165, 1.8e-5}, glass = {2e-3, 2500, 1.165, 1.8e-5};
const DragLaw beetstra = dragLaws().at("Beetstra"), ergunWenYu = dragLaws().at("ErgunWenYu");
const Suspension dust = {5e-6, 1040, 1.165, 1.8e-5};

} // namespace

TEST(Fluidisation, IsThatOfErgunsQuadraticBelowVoidage08)
{
    for (const Suspension& s : {alumina, glass, dust})
    {
        // Ergun (1952): dp/dz = 150 (1-e)^2/e^3 mu u/d^2 + 1.75 (1-e)/e^3 rho u^2/d = (1-e) (rho_p-rho) g
        const double e = 0.4;
        const double linear = 150 * (1 - e) * s.viscosity / (e * e * e * s.diameter * s.diameter);
        const double square = 1.75 * s.gasDensity / (e * e * e * s.diameter);
        const double weight = (s.density - s.gasDensity) * g;
        const double u = 2 * weight / (linear + std::sqrt(linear * linear + 4 * square * weight));
        EXPECT_NEAR(carryingVelocity(ergunWenYu, s, e, g) / u, 1, 1e-12);
        EXPECT_NEAR(bedPressureGradient(ergunWenYu, s, e, u) / ((1 - e) * weight), 1, 1e-12);
    }
}

TEST(Fluidisation, TerminalVelocityIsThatOfStokes)
{
    const double stokes = (dust.density - dust.gasDensity) * g * dust.diameter * dust.diameter / (18 * dust.viscosity);
    EXPECT_NEAR(carryingVelocity(ergunWenYu, dust, 1, g) / stokes, 1, 5e-3);
    EXPECT_NEAR(carryingVelocity(beetstra, dust, 1, g) / stokes, 1, 3e-2);
}

TEST(Fluidisation, TerminalVelocityIsNearClifts)
{
    // Clift, Grace & Weber (1978), table 5.3, log Re < 2: C_D by iteration with their correlation for 20 < Re < 260
    double u = 1;
    for (int n = 0; n < 200; ++n)
    {
        const double re = alumina.gasDensity * u * alumina.diameter / alumina.viscosity;
        const double drag = 24 / re * (1 + 0.1935 * std::pow(re, 0.6305));
        u = std::sqrt(4 * (alumina.density - alumina.gasDensity) * g * alumina.diameter /
                      (3 * drag * alumina.gasDensity));
    }
    EXPECT_NEAR(carryingVelocity(ergunWenYu, alumina, 1, g) / u, 1, 0.03);
}

TEST(Fluidisation, WenAndYusIsTheirQuadratic)
{
    for (const Suspension& s : {alumina, glass, dust})
    {
        // 1/(phi e^3) = 14 and (1-e)/(phi^2 e^3) = 11 in Ergun's equation: 24.5 Re^2 + 1650 Re = Ar
        const double archimedes =
            s.gasDensity * (s.density - s.gasDensity) * g * std::pow(s.diameter, 3) / std::pow(s.viscosity, 2);
        const double re = wenYuMinimumFluidisation(s, g) * s.gasDensity * s.diameter / s.viscosity;
        EXPECT_NEAR((24.5 * re * re + 1650 * re) / archimedes, 1, 2e-3);
    }
}

TEST(Fluidisation, NothingIsCarriedWithoutWeight)
{
    EXPECT_EQ(carryingVelocity(beetstra, alumina, 0.4, 0), 0);
    EXPECT_EQ(wenYuMinimumFluidisation({1e-3, 1, 1.2, 1.8e-5}, g), 0);
}
