#pragma once

#include "fix_property_atom.h"

namespace LAMMPS_NS
{

/// Numbers of the program that runs LIGGGHTS, one row a particle: they go with it from rank to rank, not into restart
/// files. Made by hotbed::Dem::carry, not by scripts.
class FixHotbedCarried : public FixPropertyAtom
{
public:
    FixHotbedCarried(LAMMPS* lmp, int narg, char** arg) : FixPropertyAtom(lmp, narg, arg) {}

    void set_arrays(int i) override
    {
        FixPropertyAtom::set_arrays(i);
        newParticles = true;
    }

    bool newParticles = false; ///< on this rank, whose rows are zeros
};

} // namespace LAMMPS_NS
