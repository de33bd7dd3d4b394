#pragma once

#include "coupling.hpp"

namespace hotbed
{

/// `hotbedFoam -check SECONDS`, for check.py: what decides stability and cost of the case, as lines `fact <name>
/// <values>` of the log (SI units). Then the run itself for so many seconds of processor time (at least ten gas steps,
/// at most to its end), and what the second half of that took.
class Check
{
public:
    explicit Check(const Foam::argList& args);

    static void addOption();

    /// Of the DEM script alone, before anything of it is refused.
    void particles(Dem& dem) const;

    /// Of gas and coupling, with the voidage set.
    void gas(const CouplingSettings& settings, const Foam::fvMesh& mesh, const Dem& dem, Gas& gas) const;

    /// Whether enough steps are measured; the same on all ranks. Called between gas steps.
    bool enough(double dem, double courantRate, long demSteps, Foam::scalar time);

    /// What the steps took.
    void cost() const;

private:
    struct Step
    {
        double cpu, wall, dem, courantRate; ///< seconds since the start, largest of all ranks; [1/s]
        long demSteps;                      ///< since the start
        Foam::scalar time;                  ///< simulated [s]
    };

    bool on_ = false;
    double seconds_ = 0;
    std::vector<Step> steps_;
    double setUp_ = 0; ///< wall time of the process to the end of its first step, largest of all ranks [s]
};

} // namespace hotbed
