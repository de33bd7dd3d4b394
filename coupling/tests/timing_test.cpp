#include "timing.hpp"

#include <gtest/gtest.h>

namespace
{

double waited = 0.0;

TEST(Timing, WaitingIsNotWork)
{
    hotbed::Timing timing([] { return waited; });
    {
        const auto whole = timing.measure("gas");
        waited += 5.0;
        const auto part = timing.measure("gas: pressure equation");
        waited += 2.0;
    }
    waited += 1.0;
    EXPECT_NEAR(timing.of("gas") - timing.busy("gas"), 7.0, 1e-12);
    EXPECT_NEAR(timing.of("gas: pressure equation") - timing.busy("gas: pressure equation"), 2.0, 1e-12);
}

} // namespace
