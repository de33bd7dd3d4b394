#pragma once

#include "fix.h"

namespace LAMMPS_NS
{

/// fix ID group hotbed/coarsegrain ratio L [diameter d] [density rho] [stiffness kn] [restitution en et]
/// The one owner of the coarse-graining ratio: takes the original particle, gives the coarse one as f_ID[1..7]. Stops a
/// run in which a particle blows up, before LIGGGHTS takes it for one that has left the box.
class FixHotbedCoarsegrain : public Fix
{
public:
    FixHotbedCoarsegrain(LAMMPS* lmp, int narg, char** arg);

    int setmask() override;
    void pre_exchange() override;
    double compute_scalar() override { return ratio_; }
    double compute_vector(int index) override;

    double ratio() const { return ratio_; }

private:
    double given(double value, const char* keyword) const;

    double ratio_ = 0.0;
    double diameter_ = 0.0, density_ = 0.0, stiffness_ = 0.0;
    double normalRestitution_ = 0.0, tangentialRestitution_ = 0.0;
};

} // namespace LAMMPS_NS
