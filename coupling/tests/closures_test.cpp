#include "closures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

using namespace hotbed;

namespace
{

/// A law by its name, or another function.
double evaluate(const std::string& function, double a, double b, double c)
{
    double value, log;
    logarithms(1, &b, &log);
    if (const auto drag = dragLaws().find(function); drag != dragLaws().end())
        return drag->second(1, &a, &b, &log, &value), value;
    const double root = std::cbrt(c);
    if (const auto heat = heatLaws().find(function); heat != heatLaws().end())
        return heat->second(1, &a, &log, &root, &value), value;
    if (function == "effectiveConductivity") return effectiveConductivity(a);
    if (function == "dashpot") return dashpot(a, b, c);
    if (function == "tangentialStiffness") return tangentialStiffness(a, b, c);
    ADD_FAILURE() << "unknown function " << function;
    return 0.0;
}

} // namespace

TEST(Closures, AgreeWithFiftyDigitArithmetic)
{
    std::ifstream table(CLOSURES_REFERENCE);
    std::map<std::string, int> rows;
    for (std::string line; std::getline(table, line);)
    {
        std::istringstream row(line);
        std::string function, a, b, c, value;
        std::getline(row, function, ',');
        std::getline(row, a, ',');
        std::getline(row, b, ',');
        std::getline(row, c, ',');
        std::getline(row, value);
        const double expected = std::stod(value);
        EXPECT_NEAR(evaluate(function, std::stod(a), std::stod(b), std::stod(c)), expected, 1e-13 * std::abs(expected))
            << line;
        ++rows[function];
    }
    for (const auto& law : dragLaws()) EXPECT_GE(rows[law.first], 48) << law.first;
    for (const auto& law : heatLaws()) EXPECT_GE(rows[law.first], 48) << law.first;
    for (const char* other : {"effectiveConductivity", "dashpot", "tangentialStiffness"})
        EXPECT_GE(rows[other], 7) << other;
}

TEST(Closures, TableTwoOfThePaper)
{
    const double mass = 1040.0 * M_PI / 6.0 * std::pow(5e-4, 3);
    const double kt = tangentialStiffness(500.0, 0.74, 0.1);
    EXPECT_NEAR(mass, 6.807e-8, 0.0005e-8);
    EXPECT_NEAR(kt, 217.60, 0.005);
    EXPECT_NEAR(dashpot(0.74, 500.0, mass / 2), 7.87e-4, 0.005e-4);
    EXPECT_NEAR(dashpot(0.1, kt, mass / 7), 1.72e-3, 0.005e-3);
}

TEST(Closures, BeetstraIsFiniteAndContinuousTowardsRest)
{
    const double rest = evaluate("Beetstra", 0.4, 0.0, 0);
    EXPECT_TRUE(std::isfinite(rest));
    for (double re = 1e-300; re < 1e-6; re *= 1e3)
        EXPECT_NEAR(evaluate("Beetstra", 0.4, re, 0), rest, 1e-12 * rest) << re;
}

TEST(Closures, EveryDragHasAPositiveLimitAtRest)
{
    for (const auto& law : dragLaws())
    {
        for (const double voidage : {0.2, 0.4, 0.9, 1.0})
        {
            const double rest = evaluate(law.first, voidage, 0.0, 0);
            EXPECT_GT(rest, 0.0) << law.first;
            EXPECT_NEAR(evaluate(law.first, voidage, 1e-30, 0), rest, 1e-12 * rest) << law.first;
        }
    }
}

TEST(Closures, ManyAtATimeGiveWhatOneDoes)
{
    std::vector<double> voidage, reynolds, prandtl, prandtlRoot;
    for (int i = 0; i < 1003; ++i)
    {
        voidage.push_back(0.2 + 0.8 * i / 1002);
        reynolds.push_back(i % 7 ? std::pow(10.0, -14 + i % 20) : 0.0);
        prandtl.push_back(0.01 * (1 + i));
        prandtlRoot.push_back(std::cbrt(prandtl.back()));
    }
    const int n = int(voidage.size());
    std::vector<double> many(n), logReynolds(n);
    logarithms(n, reynolds.data(), logReynolds.data());
    const auto compare = [&](const std::string& law)
    {
        for (int i = 0; i < n; ++i)
            EXPECT_NEAR(many[i], evaluate(law, voidage[i], reynolds[i], prandtl[i]), 2e-14 * many[i])
                << law << ' ' << i;
    };
    for (const auto& law : dragLaws())
    {
        law.second(n, voidage.data(), reynolds.data(), logReynolds.data(), many.data());
        compare(law.first);
    }
    for (const auto& law : heatLaws())
    {
        law.second(n, voidage.data(), logReynolds.data(), prandtlRoot.data(), many.data());
        compare(law.first);
    }
}

TEST(Closures, CoarseDragAndHeatStandForLCubedOriginals)
{
    const double d = 5e-4;
    for (const double l : {1.0, 1.5, 2.5, 7.0})
    {
        EXPECT_NEAR(dragCoefficient(3.0, 1.8e-5, 0.4, d, l), l * l * l * dragCoefficient(3.0, 1.8e-5, 0.4, d, 1.0),
                    1e-18);
        // h_c A_c with h_c = Nu k / d_c l^2 and A_c = pi d_c^2 (eq 21)
        const double hc = 7.0 * 0.025 / (l * d) * l * l;
        EXPECT_NEAR(heatConductance(7.0, 0.025, d, l), hc * M_PI * (l * d) * (l * d), 1e-16);
    }
}
