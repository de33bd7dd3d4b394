// the C library has a version of this for whole registers; math.h declares it with more relaxed rules of arithmetic
// only
#pragma omp declare simd notinbranch
extern "C" double expm1(double) noexcept;

#include "relaxation.hpp"

#include "vectorised.hpp"

namespace hotbed
{

HOTBED_VECTORISED void relaxation(int n, const double* __restrict stiffness, double* __restrict gain,
                                  double* __restrict early)
{
    for (int i = 0; i < n; ++i)
    {
        const Relaxation r = relaxation(stiffness[i]);
        gain[i] = r.gain;
        early[i] = r.early;
    }
}

HOTBED_VECTORISED void boundGain(int n, const double* __restrict voidage, const double* __restrict gasDensity,
                                 const double* __restrict particleDensity, const double* __restrict stiffness,
                                 double* __restrict gain)
{
    for (int i = 0; i < n; ++i)
    {
        const double g = gain[i], eps = voidage[i], mean = g / stiffness[i];
        const double gas = eps * gasDensity[i], solids = (1.0 - eps) * particleDensity[i]; // in a volume of the bed
        const double follows = g * solids / (gas + g * solids); // what the gas takes on of the particles' velocity
        const double gasPushed = eps + (1.0 - mean) * (1.0 - eps);
        const double lambda =
            ((1.0 - eps) / eps + follows) * (g + mean * (gas + g * solids) / (particleDensity[i] * gasPushed));
        gain[i] = lambda > 1.5 ? g * (1.5 / lambda) : g;
    }
}

} // namespace hotbed
