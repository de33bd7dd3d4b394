#pragma once

/// The contact constants of the coarse particles by pair of types, for LIGGGHTS' property registry. Read from the
/// original particle's constants that the script gives as property/global ... peratomtypepair; the coarse-graining
/// ratio comes from its one owner, fix hotbed/coarsegrain. Errors name the property and the mend.

#include "contact_kernel.hpp"

#include "property_registry.h"

#include <vector>

namespace hotbed
{

/// kn [N/m], original; l^3 times it is returned
MatrixProperty* normalStiffness(PropertyRegistry& registry, const char* caller, bool sanityChecks);

/// kt [N/m] where given, else from kn, coefficientRestitution and tangentialRestitution; times l^3
MatrixProperty* tangentialStiffnesses(PropertyRegistry& registry, const char* caller, bool sanityChecks);

/// dashpot over the root of the effective mass, from the restitutions [sqrt(kg)/s]; 0 where etan is given
MatrixProperty* normalDashpotPerRootMass(PropertyRegistry& registry, const char* caller, bool sanityChecks);
MatrixProperty* tangentialDashpotPerRootMass(PropertyRegistry& registry, const char* caller, bool sanityChecks);

/// etan, etat [N s/m] times l^3; 0 where they are not given
MatrixProperty* normalDashpots(PropertyRegistry& registry, const char* caller, bool sanityChecks);
MatrixProperty* tangentialDashpots(PropertyRegistry& registry, const char* caller, bool sanityChecks);

/// coefficientFriction [-]
MatrixProperty* friction(PropertyRegistry& registry, const char* caller, bool sanityChecks);

/// The constants of all pairs of types, row by row, of a law that is connected; zero for types that are not in use.
std::vector<ContactConstants> contactTable(LAMMPS_NS::LAMMPS& lmp);

template <class Creator>
void connect(PropertyRegistry& registry, const char* name, Creator creator, double**& data, const char* caller)
{
    registry.registerProperty(name, creator);
    registry.connect(name, data, caller);
}

} // namespace hotbed
