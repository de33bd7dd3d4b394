#pragma once

#include "fix.h"

namespace LAMMPS_NS
{

/// fix ID group hotbed/balance [every N]
/// Moves the planes at which LIGGGHTS cuts its box, so that the slabs between them hold equal shares of the particles.
class FixHotbedBalance : public Fix
{
public:
    FixHotbedBalance(LAMMPS* lmp, int narg, char** arg);

    int setmask() override;
    void pre_exchange() override;

private:
    void move(int axis, double* planes) const;

    int every_ = 1000; ///< DEM steps
};

} // namespace LAMMPS_NS
