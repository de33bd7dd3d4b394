#pragma once

/// Closures of the gas-particle exchange and of the linear spring-dashpot contact, as plain functions of plain numbers.
/// All Reynolds numbers are eq 6/17 of the paper: voidage * density * |slip| * d / viscosity, with the ORIGINAL
/// diameter (other codes leave the voidage out).
namespace hotbed
{

/// Drag of a gas on a sphere in a bed, over its Stokes drag. Beetstra, van der Hoef & Kuipers (2007), paper eq 5. For n
/// particles at a time, as the two below.
/// @param voidage   gas holdup, (0, 1]
/// @param reynolds  eq 6, >= 0
/// @param beta      set [-]; the limit for reynolds -> 0 is finite and is what 0 gives
void beetstra(int n, const double* voidage, const double* reynolds, double* beta);

/// The same by Ergun (1952) below a voidage of 0.8 and Wen & Yu (1966) from there on, as joined by Gidaspow (1994); the
/// force on a particle is that of the interphase coefficient K of these laws, K V / (1 - voidage).
/// @param voidage   gas holdup, (0, 1]
/// @param reynolds  eq 6, >= 0
/// @param beta      set [-]
void ergunWenYu(int n, const double* voidage, const double* reynolds, double* beta);

/// A drag law: one of the two above.
using DragLaw = void (*)(int n, const double* voidage, const double* reynolds, double* beta);

/// Nusselt number of a sphere in a bed. Gunn (1978), paper eq 9; fitted for voidage 0.35 to 1 and reynolds up to 1e5.
/// @param voidage   gas holdup, (0, 1]
/// @param reynolds  eq 6, >= 0
/// @param prandtl   viscosity * heat capacity / conductivity, > 0
/// @param nusselt   set: Nusselt number on the original diameter [-]
void gunn(int n, const double* voidage, const double* reynolds, const double* prandtl, double* nusselt);

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
double dragCoefficient(double beta, double viscosity, double voidage, double diameter, double ratio);

/// h A of one coarse particle, eq 21, 22: h_c A_c = l^3 h A with h = Nu k / d and A = pi d^2.
/// @param nusselt       Nusselt number of the original particle [-]
/// @param conductivity  of the gas [W/m/K]
/// @param diameter      ORIGINAL diameter [m]
/// @param ratio         coarse-graining ratio l [-]
/// @return [W/K]
double heatConductance(double nusselt, double conductivity, double diameter, double ratio);

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
