#include "relaxation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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
