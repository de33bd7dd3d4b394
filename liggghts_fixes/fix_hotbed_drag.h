#pragma once

#include "fix.h"

namespace LAMMPS_NS
{

/// fix ID group hotbed/drag
/// Applies the force that the gas exerts on each particle, constant over a gas step, and keeps what the next gas step
/// must know of the last one. Both go with the particle from rank to rank and into restart files.
class FixHotbedDrag : public Fix
{
public:
    FixHotbedDrag(LAMMPS* lmp, int narg, char** arg);

    int setmask() override;
    void post_create() override;
    void init() override;
    void setup(int) override { add(); }
    void post_force(int vflag) override;

    double** force() const; ///< drag plus pressure gradient [N], by local particle

    /// New forces, also in the sum that the next half step of the integration starts from: the particle then receives
    /// exactly force times the gas step. @param force  [count][3]
    void set(int first, int count, const double (*force)[3]);

    /// Velocity at the end of the last gas step had there been the gas alone (3), one over the length of the step
    /// [1/s]; zeros before the first one.
    double** alone() const;

    /// Keeps all forces and torques of the particles, or puts them back: LIGGGHTS evaluates them anew when a run
    /// starts, at velocities half a step further on than a run that goes on.
    void keepForces();
    void restoreForces();

private:
    void add();
    class FixPropertyAtom* property(const char* name, int values);

    bool left_ = false; ///< to the integration, which adds the force in its own pass
    class FixPropertyAtom* force_ = nullptr;
    class FixPropertyAtom* alone_ = nullptr;
    class FixPropertyAtom* kept_ = nullptr;
};

} // namespace LAMMPS_NS
