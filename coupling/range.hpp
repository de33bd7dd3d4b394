#pragma once

#include <cfloat>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace hotbed
{

/// What a number of the input may be. Errors say it in the words of the tables in docs.
struct Range
{
    double low;
    bool withLow;          ///< low itself too
    double high = DBL_MAX; ///< itself too

    /// Comparing what is no number would end a solver that traps floating-point errors.
    bool holds(double value) const
    {
        return std::isfinite(value) && (withLow ? value >= low : value > low) && value <= high;
    }

    /// such as "> 0, <= 1"
    std::string text() const
    {
        char words[64];
        int size = std::snprintf(words, sizeof words, "%s %g", withLow ? ">=" : ">", low);
        if (high < DBL_MAX) std::snprintf(words + size, sizeof words - std::size_t(size), ", <= %g", high);
        return words;
    }

    /// @param value  set to the number that a text holds, and nothing else. @return whether it does and is in the range
    bool read(const char* text, double& value) const
    {
        char* end = nullptr;
        value = std::strtod(text, &end);
        return end != text && *end == '\0' && holds(value);
    }
};

} // namespace hotbed
