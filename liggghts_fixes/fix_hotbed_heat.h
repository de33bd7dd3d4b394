#pragma once

#include "fix.h"

namespace LAMMPS_NS
{

/// fix ID group hotbed/heat initial_temperature T0
/// Holds the particle temperature (property/atom Temp, restarted) and Nusselt number (property/atom Nusselt),
/// which the gas changes once a gas step by what the exact solution of m c dT/dt (eq 15, 22) gives.
class FixHotbedHeat : public Fix
{
public:
    FixHotbedHeat(LAMMPS* lmp, int narg, char** arg);

    int setmask() override { return 0; }
    void post_create() override;
    void init() override;
    double compute_scalar() override; ///< thermal energy of all particles, sum m c T [J]

    double* temperature() const;                                     ///< [K], by local particle
    double* nusselt() const;                                         ///< [-], by local particle
    void heatCapacity(int first, int count, double* capacity) const; ///< m c of coarse particles [J/K]

    /// @param first   local particle, the first of `count`
    /// @param change  [count], added to the temperature [K]
    void warm(int first, int count, const double* change);

private:
    class FixPropertyAtom* property(const char* name, const char* initial, bool ghosts);

    double initialTemperature_;
    class FixPropertyAtom* temperature_ = nullptr;
    class FixPropertyAtom* nusselt_ = nullptr;
    class FixPropertyGlobal* capacity_ = nullptr;
};

} // namespace LAMMPS_NS
