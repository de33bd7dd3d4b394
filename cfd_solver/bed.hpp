#pragma once

#include "coupling.hpp"

#include <fstream>

namespace hotbed
{

/// The mesh as a column that stands against gravity (constant/g; along z where it is zero).
struct Column
{
    explicit Column(const Foam::fvMesh& mesh);

    Foam::scalar gravity; ///< [m/s2]
    Foam::vector up;
    Foam::scalar low, height; ///< lowest point and extent along `up` [m]
    Foam::scalar section;     ///< volume over height [m2]
};

/// Bed quantities and the energy budget in time, as postProcessing/hotbed/<start>/bed.csv and at the end of the log.
class Bed
{
public:
    /// @param interval  gas steps between lines
    Bed(const Foam::fvMesh& mesh, const Coupling& coupling, const Dem& dem, const Gas& gas, int interval);

    /// The budget so far, for a run that goes on from a restart.
    Foam::dictionary state() const;
    void resume(const Foam::dictionary& state);

    /// Around what lets particles come and go, DEM steps and the new lists of a restart: what the particles' energy
    /// changes by between the two was carried by particles.
    void particlesWillMove();
    void particlesHaveMoved();

    /// After a step: the budget goes on; a line where it is time for one, or the run ends.
    void record(bool last);

    /// The closing budget, and the line of the last step where it is not there yet.
    void finish(Foam::Ostream& out);

private:
    double momentumError() const; ///< not accounted for, of the impulse given to the particles
    void line();
    double largestOverlap() const; ///< of all ranks; one that is too large ends the run with the particle's name
    void heights(double& mean, double& height) const;
    double weight() const; ///< of the particles, over the cross-section [Pa]

    const Foam::Time& runTime_;
    const Coupling& coupling_;
    const Dem& dem_;
    const Gas& gas_;
    const int interval_;
    const Column column_;
    Foam::label particles_ = 0; ///< at the last line
    bool warned_ = false;       ///< of particles that are gone
    bool recorded_ = true;      ///< the last step has its line
    Foam::fileName csvPath_;
    std::ofstream csv_;

    double gasEnergyAtStart_ = 0, particleEnergyAtStart_ = 0;
    double gasEnergy_ = 0, particleEnergy_ = 0, inflow_ = 0, exchanged_ = 0; ///< [J]
    /// [J] of the particles before the DEM steps; carried in by new ones less out by leaving ones
    double energyBeforeMove_ = 0, carried_ = 0;
    /// [N s]: momentum of the gas at the start and now; what came in and what the particles received since; the
    /// latter's absolute values
    Foam::vector gasMomentumAtStart_ = Foam::Zero, gasMomentum_ = Foam::Zero, impulseIn_ = Foam::Zero,
                 impulse_ = Foam::Zero;
    double impulseExchanged_ = 0;
    double mismatch_ = 0; ///< largest of all steps
};

} // namespace hotbed
