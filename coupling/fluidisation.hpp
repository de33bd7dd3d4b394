#pragma once

#include "closures.hpp"

namespace hotbed
{

/// A gas and particles of one size in it.
struct Suspension
{
    double diameter;   ///< of the ORIGINAL particle [m]
    double density;    ///< of the particle [kg/m3]
    double gasDensity; ///< [kg/m3]
    double viscosity;  ///< dynamic [Pa s]
};

/// Superficial velocity of the gas whose drag and pressure gradient carry an even bed: the minimum fluidisation
/// velocity where the voidage is that of the packed bed, the terminal velocity of a single particle where it is 1.
/// @param law      drag law of closures.hpp
/// @param voidage  gas holdup, (0, 1]
/// @param gravity  acceleration [m/s2]
/// @return [m/s]; 0 without gravity or where the particle is not heavier than the gas
double carryingVelocity(DragLaw law, const Suspension& suspension, double voidage, double gravity);

/// Minimum fluidisation velocity by Wen & Yu (1966), AIChE J. 12, 610: Re = sqrt(33.7^2 + 0.0408 Ar) - 33.7, without a
/// voidage.
/// @return [m/s]; 0 as above
double wenYuMinimumFluidisation(const Suspension& suspension, double gravity);

/// Pressure gradient of an even bed through which gas flows.
/// @param superficial  velocity of the gas [m/s]
/// @return [Pa/m]
double bedPressureGradient(DragLaw law, const Suspension& suspension, double voidage, double superficial);

} // namespace hotbed
