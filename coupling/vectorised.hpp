#pragma once

#include <cfenv>

/// Before a function: one version of its loops for each generation of processors, chosen when the program starts.
#ifndef HOTBED_VECTORISED // as in tests of a single version
#define HOTBED_VECTORISED __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4"), flatten))
#endif

namespace hotbed
{

/// Numbers that follow each other in memory, as one register where the processor has such.
using Row4 = double __attribute__((vector_size(32), aligned(8), may_alias));

/// While it lives, floating-point errors are not trapped: in whole registers both sides of a choice are evaluated, also
/// log(0). For the host that calls closures and relaxation, around all of them, since it takes as long as some
/// particles.
class NoTraps
{
public:
    NoTraps() { std::feholdexcept(&before_); }
    ~NoTraps() { std::fesetenv(&before_); }
    NoTraps(const NoTraps&) = delete;
    NoTraps& operator=(const NoTraps&) = delete;

private:
    std::fenv_t before_;
};

} // namespace hotbed
