#pragma once

#include <cfenv>

// Before a function. HOTBED_VECTORISED: one version of its loops for each generation of processors, chosen when the
// program starts. HOTBED_WIDE and HOTBED_NARROW, where wideRegisters() chooses: for those with registers of eight
// numbers, and for all others. HOTBED_ONE_VERSION: tests of the others, on processors that have them.
#ifdef HOTBED_ONE_VERSION
#define HOTBED_VECTORISED __attribute__((flatten))
#define HOTBED_NARROW __attribute__((flatten))
#else
#define HOTBED_VECTORISED __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4"), flatten))
#define HOTBED_NARROW __attribute__((target_clones("default", "arch=x86-64-v3"), flatten))
#endif
#define HOTBED_WIDE __attribute__((target("arch=x86-64-v4"), flatten))

namespace hotbed
{

/// Whether the processor has registers of eight numbers.
inline bool wideRegisters()
{
#ifdef HOTBED_ONE_VERSION
    return false;
#else
    return __builtin_cpu_supports("x86-64-v4");
#endif
}

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
