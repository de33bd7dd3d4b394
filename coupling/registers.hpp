#pragma once

#include "vectorised.hpp"

// Values in registers, for loops of one file that are all inlined into one function: compiled for the processor there.

namespace hotbed
{

/// The values of a particle or a cell.
using Values2 = double __attribute__((vector_size(16), aligned(8), may_alias));
using Values4 = Row4;
using Values8 = double __attribute__((vector_size(64), aligned(8), may_alias));

/// values in two or three registers
struct Pair
{
    Values4 low, high;
};

struct Triple
{
    Pair low;
    Values4 high;
};

struct WideTriple
{
    Values8 low;
    Values4 high;
};

template <class Values, class = decltype(Values::low)> inline Values& operator+=(Values& sum, const Values& values)
{
    sum.low += values.low;
    sum.high += values.high;
    return sum;
}

template <class Values, class = decltype(Values::low)> inline Values operator*(double factor, const Values& values)
{
    return {factor * values.low, factor * values.high};
}

/// Processors with registers of four numbers. Those of eight are not just two of them: compilers put what does not fit
/// into memory, after every operation.
struct Narrow
{
    static constexpr int width = 4;
    using Lanes = double __attribute__((vector_size(32), may_alias)); ///< values of particles that lie side by side
    using Counts = int __attribute__((vector_size(16), may_alias));
    using Eight = Pair;
    using Twelve = Triple;
};

/// Processors with registers of eight numbers
struct Wide
{
    static constexpr int width = 8;
    using Lanes = double __attribute__((vector_size(64), may_alias));
    using Counts = int __attribute__((vector_size(32), may_alias));
    using Eight = Values8;
    using Twelve = WideTriple;
};

template <class Work> HOTBED_NARROW void withNarrow(const Work& work)
{
    work(Narrow{});
}

template <class Work> HOTBED_WIDE void withWide(const Work& work)
{
    work(Wide{});
}

/// work(Wide{}) or work(Narrow{}), compiled for the processor
template <class Work> inline void withRegisters(const Work& work)
{
    if (wideRegisters())
        withWide(work);
    else
        withNarrow(work);
}

} // namespace hotbed
