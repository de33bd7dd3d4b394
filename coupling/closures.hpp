#pragma once

#include <cmath>
#include <map>
#include <string>

/// Closures of the gas-particle exchange and of the linear spring-dashpot contact, as plain functions of plain numbers.
/// All Reynolds numbers are eq 6/17 of the paper: voidage * density * |slip| * d / viscosity, with the ORIGINAL
/// diameter (other codes leave the voidage out).
namespace hotbed
{

/// A drag law for n particles at a time: drag of a gas on a sphere in a bed, over its Stokes drag, as `dragCoefficient`
/// takes it.
/// @param voidage      gas holdup, (0, 1]
/// @param reynolds     eq 6, >= 0
/// @param logReynolds  `logarithms` of them, which all laws take powers by
/// @param beta         set [-]; the limit for reynolds -> 0 is finite and is what 0 gives
using DragLaw = void (*)(int n, const double* voidage, const double* reynolds, const double* logReynolds, double* beta);

/// A heat law for n particles at a time: Nusselt number of a sphere in a bed.
/// @param voidage      gas holdup, (0, 1]
/// @param logReynolds  as above
/// @param prandtlRoot  cube root of viscosity * heat capacity / conductivity, > 0; it hardly varies, so it is taken by
///                     cell and not by particle
/// @param nusselt      set: Nusselt number on the original diameter [-]
using HeatLaw = void (*)(int n, const double* voidage, const double* logReynolds, const double* prandtlRoot,
                         double* nusselt);

/// Natural logarithms of n Reynolds numbers, finite for 0: any power by them is then 0, or infinite, to the last digit.
void logarithms(int n, const double* reynolds, double* logReynolds);

/// All laws, by their names in couplingProperties. A host that traps floating-point errors calls them within NoTraps
/// (vectorised.hpp). The formulas and where they come from are in closures.cpp.
const std::map<std::string, DragLaw>& dragLaws();
const std::map<std::string, HeatLaw>& heatLaws();

/// Conductivity of the gas in a bed over that of the gas alone. Syamlal & Gidaspow (1985), paper eq 12.
/// @param voidage gas holdup, (0, 1]
/// @return (1 - sqrt(1 - voidage)) / voidage [-], without cancellation for small voidage
double effectiveConductivity(double voidage);

/// Drag coefficient of one coarse particle, eq 16 with beta_c = l^2 beta: force = dragCoefficient * (u_gas - v).
/// @param beta          Stokes-normalised drag of the original particle [-]
/// @param viscosity     dynamic viscosity of the gas [Pa s]
/// @param voidage       gas holdup at the particle [-]
/// @param diameter      ORIGINAL diameter [m]
/// @param ratio         coarse-graining ratio l [-]
/// @return [kg/s]
inline double dragCoefficient(double beta, double viscosity, double voidage, double diameter, double ratio)
{
    return 3.0 * M_PI * viscosity * voidage * (ratio * diameter) * (ratio * ratio * beta);
}

/// h A of one coarse particle, eq 21, 22: h_c A_c = l^3 h A with h = Nu k / d and A = pi d^2.
/// @param nusselt       Nusselt number of the original particle [-]
/// @param conductivity  of the gas [W/m/K]
/// @param diameter      ORIGINAL diameter [m]
/// @param ratio         coarse-graining ratio l [-]
/// @return [W/K]
inline double heatConductance(double nusselt, double conductivity, double diameter, double ratio)
{
    return ratio * ratio * ratio * M_PI * nusselt * conductivity * diameter;
}

/// Dashpot that gives a restitution in a head-on impact of the linear spring-dashpot (Deen et al. 2007):
/// eta = -2 ln(e) sqrt(mass k) / sqrt(pi^2 + ln(e)^2).
/// @param restitution   e, (0, 1]
/// @param stiffness     k [N/m], > 0
/// @param mass          effective mass: m/2 for the normal, 2/7 of that for the tangential direction of two equals [kg]
/// @return [N s/m]
double dashpot(double restitution, double stiffness, double mass);

/// Tangential stiffness for which normal and tangential contact last equally long (Deen et al. 2007):
/// k_t = 2/7 k_n (pi^2 + ln(e_t)^2) / (pi^2 + ln(e_n)^2).
/// @return [N/m]
double tangentialStiffness(double normalStiffness, double normalRestitution, double tangentialRestitution);

} // namespace hotbed
