// the C library has a version of this for whole registers; math.h declares it with more relaxed rules of arithmetic
// only
#pragma omp declare simd notinbranch
extern "C" double expm1(double) noexcept;

#include "relaxation.hpp"

#include "vectorised.hpp"

namespace hotbed
{
namespace
{

/// below it the first term that is left out of the series is in the last digit
constexpr double slowest = 3e-3;

} // namespace

HOTBED_VECTORISED void relaxation(int n, const double* __restrict stiffness, double* __restrict gain,
                                  double* __restrict early)
{
    double most = 0.0;
#pragma omp simd reduction(max : most)
    for (int i = 0; i < n; ++i) most = stiffness[i] > most ? stiffness[i] : most;
    if (most < slowest) // particles that the gas hardly heats within a step, as in most beds: the series
    {
        for (int i = 0; i < n; ++i)
        {
            const double b = stiffness[i];
            gain[i] = b * (1.0 - b * (1.0 / 2 - b * (1.0 / 6 - b * (1.0 / 24 - b / 120))));
            early[i] = b * (1.0 / 2 - b * (1.0 / 3 - b * (1.0 / 8 - b * (1.0 / 30 - b / 144))));
        }
        return;
    }
    for (int i = 0; i < n; ++i)
    {
        const Relaxation r = relaxation(stiffness[i]);
        gain[i] = r.gain;
        early[i] = r.early;
    }
}

// lambda as a quotient: divisions are what takes time here
HOTBED_VECTORISED void dragAnswer(int n, const double* __restrict voidage, const double* __restrict gasDensity,
                                  const double* __restrict mass, const double* __restrict volume,
                                  const double* __restrict stiffness, double* __restrict gain, double* __restrict held)
{
    for (int i = 0; i < n; ++i)
    {
        const double b = stiffness[i], g = -std::expm1(-b), mean = b > 0.0 ? g / b : 1.0;
        const double eps = voidage[i], m = mass[i];
        const double gas = eps * gasDensity[i] * volume[i], solids = g * (1.0 - eps) * m; // where the particle is
        const double together = gas + solids;
        const double gasPushed = (eps + (1.0 - mean) * (1.0 - eps)) * m;
        const double above = ((1.0 - eps) * together + eps * solids) * (g * gasPushed + mean * together);
        const double below = eps * together * gasPushed;
        const double share = above > 1.5 * below ? 1.5 * below / above : 1.0;
        gain[i] = share * g;
        held[i] = b > 0.0 ? 1.0 - share * mean : 0.0;
    }
}

} // namespace hotbed
