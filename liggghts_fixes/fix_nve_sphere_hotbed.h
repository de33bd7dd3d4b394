#pragma once

#include "fix_nve_sphere.h"

#include "motion_kernel.hpp"

namespace LAMMPS_NS
{

/// fix ID group nve/sphere/hotbed [gravity g vector x y z]
/// Integrates spheres as fix nve/sphere does. The second half of a step and the first half of the next are one pass
/// over the particles wherever nobody looks at them in between. With gravity it adds that, too, and the force of fix
/// hotbed/drag.
class FixNVESphereHotbed : public FixNVESphere
{
public:
    FixNVESphereHotbed(LAMMPS* lmp, int narg, char** arg);

    int setmask() override;
    void init() override;
    void setup(int vflag) override;
    void initial_integrate(int vflag) override;
    void final_integrate() override;
    void post_run() override;

    /// Whether the force of a fix hotbed/drag is added here, after the start of a run.
    bool addsForceOf(const Fix& drag) const { return withGravity_ && drag.igroup == igroup; }

    const double* gravity() const { return gravity_; } ///< that is added here [m/s2]

    /// Whether all particles may be moved before the step's final_integrate(), each when it has its force: nothing but
    /// `known` fixes adds to forces after pairs, and nobody looks at the particles.
    bool movesEarly(const std::vector<const Fix*>& known) const;

    /// Both halves of particles [first, end), which are not moved in final_integrate() then.
    /// @param force, torque  of particle `first` and those after it
    void moveEarly(int first, int end, double* force, const double* torque);

    /// For a host that runs LIGGGHTS step by step: it looks at the particles at the end of this time step.
    void stopAfter(bigint step) { stop_ = step; }

private:
    void integrate(hotbed::Half half);
    hotbed::MovingParticles particles(hotbed::Half half) const;
    hotbed::MotionStep motion(hotbed::Half half) const;
    void delayCheck();
    bool seen() const;

    bool withGravity_ = false;
    double gravity_[3] = {};              ///< [m/s2]
    class FixHotbedDrag* drag_ = nullptr; ///< whose force is added here
    bool ahead_ = false;                  ///< the first half of the next step is done
    bigint stop_ = 0;                     ///< 0: no host
    bool moved_ = false;                  ///< before final_integrate(), all of them
    double earlySquared_[3] = {};         ///< of the longest way then [m2]
    bool movesAll_ = false;               ///< nothing else moves particles or the box
    double way_[3] = {}; ///< since neighbour lists were built, along each axis, of the fastest at each step [m]
    int delay_ = 0;      ///< of neigh_modify
};

} // namespace LAMMPS_NS
