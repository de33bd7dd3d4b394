#pragma once

#include <cstdint>

namespace hotbed
{

/// Makes the contact law `hotbed` known to LIGGGHTS; a second call does nothing.
void registerContact();

/// LIGGGHTS' code of the contact law `hotbed` (PairGran::hashcode).
std::int64_t contactCode();

} // namespace hotbed
