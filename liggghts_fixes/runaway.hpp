#pragma once

#include <string>

namespace LAMMPS_NS
{
class LAMMPS;
}

namespace hotbed
{

/// A particle in words: id, place, velocity.
std::string describe(const LAMMPS_NS::LAMMPS& lmp, int particle);

/// @return this rank's fastest particle in words, for errors that name none; empty without particles
std::string fastest(const LAMMPS_NS::LAMMPS& lmp);

/// Ends the run where a particle of this rank has a place or velocity that is not finite, or moves by more than its
/// radius in a DEM step while there are contacts, which no contact law can follow; the error names the particle, the
/// likely cause and the mend.
void refuseRunaways(const LAMMPS_NS::LAMMPS& lmp);

} // namespace hotbed
