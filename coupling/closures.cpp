#include "closures.hpp"

// the C library has versions of these for whole registers; math.h declares them with more relaxed rules of arithmetic
// only
#pragma omp declare simd notinbranch
extern "C" double exp(double) noexcept;
#pragma omp declare simd notinbranch
extern "C" double log(double) noexcept;

#include "vectorised.hpp"

#include <cmath>

namespace hotbed
{

namespace
{

// Powers are exponentials of one logarithm: these are evaluated for every particle in every gas step. No branches, so
// that several particles fit in a register.

/// Beetstra, van der Hoef & Kuipers (2007), paper eq 5.
inline double beetstra(double voidage, double reynolds, double logReynolds)
{
    const double solids = 1.0 - voidage;
    const double inverse = 1.0 / voidage, inverse2 = inverse * inverse; // divisions take as long as an exponential
    const double creeping = 10.0 * solids * inverse2 + voidage * voidage * (1.0 + 1.5 * std::sqrt(solids));
    const double top = reynolds * (inverse + 3.0 * voidage * solids) + 8.4 * std::exp(0.657 * logReynolds);
    const double bottom = 1.0 + std::exp(3.0 * M_LN10 * solids - (0.5 + 2.0 * solids) * logReynolds);
    return creeping + 0.413 / 24.0 * inverse2 * top / bottom;
}

/// Ergun (1952) below a voidage of 0.8 and Wen & Yu (1966) from there on, as joined by Gidaspow (1994); the force on a
/// particle is that of the interphase coefficient K of these laws, K V / (1 - voidage).
inline double ergunWenYu(double voidage, double reynolds, double logReynolds)
{
    const double ergun = (150.0 * (1.0 - voidage) + 1.75 * reynolds) / (18.0 * voidage * voidage);
    const double single = reynolds < 1000.0 ? 1.0 + 0.15 * std::exp(0.687 * logReynolds) : 0.44 / 24.0 * reynolds;
    const double wenYu = single * std::exp(-3.65 * std::log(voidage));
    return voidage < 0.8 ? ergun : wenYu;
}

/// Gunn (1978), paper eq 9; fitted for voidage 0.35 to 1 and reynolds up to 1e5.
inline double gunn(double voidage, double logReynolds, double pr)
{
    const double re = std::exp(0.1 * logReynolds);
    const double re2 = re * re;
    const double re7 = re2 * re2 * re2 * re;
    const double e2 = voidage * voidage;
    return (7.0 - 10.0 * voidage + 5.0 * e2) * (1.0 + 0.7 * re2 * pr) + (1.33 - 2.40 * voidage + 1.20 * e2) * re7 * pr;
}

template <double (*law)(double, double, double)>
HOTBED_VECTORISED void drag(int n, const double* __restrict voidage, const double* __restrict reynolds,
                            const double* __restrict logReynolds, double* __restrict beta)
{
    for (int i = 0; i < n; ++i) beta[i] = law(voidage[i], reynolds[i], logReynolds[i]);
}

template <double (*law)(double, double, double)>
HOTBED_VECTORISED void heat(int n, const double* __restrict voidage, const double* __restrict logReynolds,
                            const double* __restrict prandtlRoot, double* __restrict nusselt)
{
    for (int i = 0; i < n; ++i) nusselt[i] = law(voidage[i], logReynolds[i], prandtlRoot[i]);
}

} // namespace

const std::map<std::string, DragLaw>& dragLaws()
{
    static const std::map<std::string, DragLaw> laws = {{"Beetstra", drag<beetstra>}, {"ErgunWenYu", drag<ergunWenYu>}};
    return laws;
}

const std::map<std::string, HeatLaw>& heatLaws()
{
    static const std::map<std::string, HeatLaw> laws = {{"Gunn", heat<gunn>}};
    return laws;
}

HOTBED_VECTORISED void logarithms(int n, const double* __restrict reynolds, double* __restrict logReynolds)
{
    for (int i = 0; i < n; ++i) logReynolds[i] = std::log(reynolds[i] > 1e-300 ? reynolds[i] : 1e-300);
}

double effectiveConductivity(double voidage)
{
    return 1.0 / (1.0 + std::sqrt(1.0 - voidage));
}

double dashpot(double restitution, double stiffness, double mass)
{
    const double log = std::log(restitution);
    return -2.0 * log * std::sqrt(mass * stiffness) / std::sqrt(M_PI * M_PI + log * log);
}

double tangentialStiffness(double normalStiffness, double normalRestitution, double tangentialRestitution)
{
    const double n = std::log(normalRestitution);
    const double t = std::log(tangentialRestitution);
    return 2.0 / 7.0 * normalStiffness * (M_PI * M_PI + t * t) / (M_PI * M_PI + n * n);
}

} // namespace hotbed
