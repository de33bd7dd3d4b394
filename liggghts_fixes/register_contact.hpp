#pragma once

namespace hotbed
{

/// Makes the contact law `hotbed` known to LIGGGHTS; a second call does nothing.
void registerContact();

} // namespace hotbed
