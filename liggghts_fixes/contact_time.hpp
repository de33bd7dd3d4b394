#pragma once

#include "contact_kernel.hpp"

#include <vector>

namespace LAMMPS_NS
{
class LAMMPS;
}

namespace hotbed
{

/// How well the time step resolves the contact of the lightest particles of two types.
struct ContactTime
{
    int first, second; ///< types, from 1
    double steps;      ///< time steps in a contact
    double least;      ///< of them that a packing must have, or it gains energy from nothing; good are twice as many
    double friction;   ///< coefficient
};

/// The pairs of types of which there are particles, over all ranks.
/// @param constants  as contactTable gives them
std::vector<ContactTime> contactTimes(LAMMPS_NS::LAMMPS& lmp, const std::vector<ContactConstants>& constants);

} // namespace hotbed
