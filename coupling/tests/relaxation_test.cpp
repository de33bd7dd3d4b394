#include "relaxation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <vector>

using hotbed::relaxation;

TEST(Relaxation, CoefficientsAreConvexForAnyStiffness)
{
    for (double b = 1e-12; b < 1e12; b *= 1.7)
    {
        const auto r = relaxation(b);
        EXPECT_GE(r.gain, 0.0) << b;
        EXPECT_LE(r.gain, 1.0) << b;
        EXPECT_GE(r.early, 0.0) << b;
        EXPECT_LE(r.early, r.gain) << b;
    }
}

TEST(Relaxation, LimitsAreExact)
{
    EXPECT_EQ(relaxation(0.0).gain, 0.0);
    EXPECT_EQ(relaxation(0.0).early, 0.0);
    const auto stiff = relaxation(std::numeric_limits<double>::infinity());
    EXPECT_EQ(stiff.gain, 1.0);
    EXPECT_EQ(stiff.early, 0.0);
}

TEST(Relaxation, ConstantGasIsTheExponential)
{
    for (const double b : {1e-8, 1e-3, 0.5, 3.0, 40.0}) EXPECT_NEAR(relaxation(b).gain, -std::expm1(-b), 1e-16);
}

// against the exact solution in long double, on both sides of the switch between series and closed form
TEST(Relaxation, LinearGasIsExact)
{
    for (const long double b : {1e-6L, 1e-3L, 0.019L, 0.0199999L, 0.0200001L, 0.1L, 1.0L, 10.0L})
    {
        const long double exact = -std::expm1(-b) / b - std::exp(-b);
        const long double small = b * (1.0L / 2 - b / 3 + b * b / 8 - b * b * b / 30 + b * b * b * b / 144);
        const long double expected = b < 0.01L ? small : exact;
        EXPECT_NEAR(double(relaxation(double(b)).early / expected), 1.0, 1e-11) << double(b);
    }
}

// by how much less is Cohen's error of the inverse of Langevin's function
TEST(Relaxation, LeastDecayIsThatOfOneStiffness)
{
    EXPECT_EQ(hotbed::leastDecay(0.5), 1.0);
    EXPECT_EQ(hotbed::leastDecay(1e-300), 0.0);
    for (double b = 1e-9; b < 600; b *= 1.3)
    {
        const auto r = relaxation(b);
        const double decay = std::exp(-b), least = hotbed::leastDecay(r.early / r.gain);
        EXPECT_LE(least, decay * (1 + 1e-12)) << b;
        EXPECT_GE(least, decay * (1 - 0.015 * std::min(1.0, b)) * (b < 2 ? 1 : 0.3)) << b;
    }
}

TEST(Relaxation, LeastDecayOfDifferentOnesIsNotAboveTheirMean)
{
    for (double slow = 1e-4; slow < 100; slow *= 3)
        for (double fast = slow; fast < 1000; fast *= 2)
            for (const double part : {0.01, 0.3, 0.9})
            {
                const auto s = relaxation(slow), f = relaxation(fast);
                const double gain = part * s.gain + (1 - part) * f.gain;
                const double early = part * s.early + (1 - part) * f.early;
                const double decay = (part * s.gain * (1 - s.gain) + (1 - part) * f.gain * (1 - f.gain)) / gain;
                EXPECT_LE(hotbed::leastDecay(early / gain), decay + 1e-15) << slow << ' ' << fast << ' ' << part;
            }
}

TEST(Relaxation, ManyAtATimeAreAsOne)
{
    std::vector<double> all = {0.0, std::numeric_limits<double>::infinity()}, slow = {0.0}; // slow ones have a series
    for (double x = 1e-12; x < 1e12; x *= 1.7) (x < 2.9e-3 ? slow : all).push_back(x);
    for (const std::vector<double>& b : {all, slow})
    {
        std::vector<double> gain(b.size()), early(b.size());
        relaxation(int(b.size()), b.data(), gain.data(), early.data());
        for (std::size_t i = 0; i < b.size(); ++i)
        {
            EXPECT_NEAR(gain[i], relaxation(b[i]).gain, 1e-15 * relaxation(b[i]).gain) << b[i];
            EXPECT_NEAR(early[i], relaxation(b[i]).early, 1e-12 * relaxation(b[i]).gain) << b[i];
        }
    }
}

// lambda of docs/theory.md, Exchange: where particles follow the gas at once (gain 1, b -> infinity) and are far
// heavier, it is (1 - eps)/eps + 1 with all of it in the first term; where they are as light as the gas, from its own
// formula
TEST(Relaxation, DragAnswersAreBoundedInDenseBedsOnly)
{
    const std::vector<double> voidage = {0.4, 0.8, 0.4, 0.4, 0.4, 0.5, 0.45}, gas = {1, 1, 1, 1, 1, 1, 1.2};
    const std::vector<double> mass = {1e9, 1e9, 1e9, 1e9, 3, 2, 2080}, volume = {1, 1, 1, 1, 1, 1, 2};
    const std::vector<double> b = {1e9, 1e9, 1e-3, 0, 0.7, 1e-12, 0.53};
    std::vector<double> gain(b.size()), held(b.size());
    hotbed::dragAnswer(int(b.size()), voidage.data(), gas.data(), mass.data(), volume.data(), b.data(), gain.data(),
                       held.data());
    EXPECT_NEAR(gain[0], 1.5 / (0.6 / 0.4 + 1), 1e-6); // lambda 2.5
    EXPECT_EQ(gain[1], 1.0);                           // lambda 1.25
    EXPECT_EQ(gain[3], 0.0);
    EXPECT_EQ(held[3], 0.0);
    for (std::size_t i = 0; i < b.size(); ++i)
    {
        if (b[i] == 0.0) continue;
        const double eps = voidage[i], g = -std::expm1(-b[i]), mean = g / b[i], rho = mass[i] / volume[i];
        const double solids = g * (1.0 - eps) * rho, both = eps * gas[i] + solids;
        const double P = eps + (1.0 - mean) * (1.0 - eps);
        const double lambda = ((1.0 - eps) / eps + solids / both) * (g + mean * both / (rho * P));
        EXPECT_NEAR(gain[i], lambda > 1.5 ? g * 1.5 / lambda : g, 1e-14) << i;
        EXPECT_NEAR(held[i], 1.0 - gain[i] / b[i], 1e-14 * (1.0 + gain[i] / b[i])) << i;
    }
}
