#pragma once

namespace LAMMPS_NS
{
class LAMMPS;
}

namespace hotbed
{

/// Has the places and velocities of particles at the borders of a rank sent to both neighbours along an axis at once.
/// LIGGGHTS sends to one side, then to the other: of two ranks each waits while the other one packs.
void sendToBothSides(LAMMPS_NS::LAMMPS& lmp);

} // namespace hotbed
