#pragma once

#include "gas.hpp"
#include "settings.hpp"

#include "cell_values.hpp"
#include "dem.hpp"
#include "mapping.hpp"
#include "timing.hpp"

#include <algorithm>

namespace hotbed
{

constexpr int gasFields = 8; ///< voidage, U, rho, mu, kappa, cube root of Pr: one cache line a cell

/// A difference over the size of what differs; where that is nothing, the difference itself.
inline double relative(double difference, double size)
{
    return size > 0.0 ? difference / size : difference;
}

/// Joins the particles of the DEM with the gas, both ways, every gas step: what leaves one phase is what reaches the
/// other, cell by cell and particle by particle, to round-off.
class Coupling
{
public:
    Coupling(const CouplingSettings& settings, const Foam::fvMesh& mesh, Dem& dem, Gas& gas, Timing& timing);

    /// What it is timed by.
    static constexpr const char* phases[] = {"weights",  "voidage", "gas at particles",
                                             "closures", "to gas",  "to particles"};

    bool heat() const { return heat_; }
    bool push() const { return push_; } ///< particles answer to the gas

    /// Weights and voidage for where the particles are now, before the first step.
    void map();

    /// Ends the run with an error if particles lie outside the mesh.
    void refuseOutside() const;

    /// Weights, voidage and closures; drag and heat exchange coefficients to the gas.
    /// @param courantRate  Courant number of the gas over the step [1/s]
    void particlesToGas(double courantRate);

    /// Closures are evaluated in the next step, as in that of a run that goes on from a restart.
    void forgetAnswers() { answersStep_ = 0; }

    /// Momentum and heat to the particles from the gas at the end of its step.
    void gasToParticles();

    /// Sum over all particles and ranks of |heat| exchanged in the last step [J].
    double heatExchanged() const { return heatExchanged_; }

    /// Impulse that the particles received in the last step, drag and pressure gradient, over all ranks [N s].
    const Foam::vector& impulse() const { return impulse_; }

    /// Gas steps so far in which closures were evaluated.
    long evaluations() const { return evaluations_; }

    /// What this rank has sent to others for the exchange so far [bytes].
    std::int64_t bytesSent() const { return mapping_.bytesSent(); }

    /// What the gas equations took in the last step less what the particles received, over what was exchanged: the
    /// larger one of drag and heat. Round-off, or the coupling is broken.
    double mismatch() const { return mismatch_; }

private:
    std::unique_ptr<const Cells> makeCells(const CouplingSettings& settings);
    /// So many particles at a time go through the closures: what is known of them then stays in the nearest cache.
    static constexpr int part = Gift::part;
    /// Particles further on are fetched: loops read many arrays, a few lines of each at a time, which the processor
    /// does not see coming.
    static constexpr int ahead = 64;
    struct Seen ///< the gas at these particles, side by side, and what follows from it
    {
        alignas(64) double voidage[part], density[part], viscosity[part], conductivity[part];
        alignas(64) double B[part], conductance[part]; ///< drag coefficient [kg/s], h A [W/K]
    };
    bool keepAnswers(double courantRate);
    void updateWeights(const Gift& gift, double* sums);
    void setVoidage(const double* volumes, int stride);
    void setReference();
    void gasInCells(const Foam::scalarField& Cp);
    ParticlePositions particles() const;
    double* answers(int particle) const { return dem_.carried() + std::size_t(particle) * answerFields_; }
    // blocks of particles; `gas` is what they see of it, [count][gasFields]
    void closures(int first, int count, const double* gas);
    void closuresOf(int first, int count, const double* gas);
    void dragOn(int first, int count, const Seen& seen);
    void heatOn(int first, int count, const Seen& seen);
    void forgetOutside(int first, int count);
    void give(int first, int count, double* given) const;
    void giveVolume(int first, int count, double* given, int stride) const;
    void giveMomentum(int first, int count, double* given) const;
    void giveHeat(int first, int count, double* given) const;
    /// Cells that particles reach, so many at a time that what is known of them stays in the cache from one use to the
    /// next. @param use  called with the first and the end of each block
    template <class Use> void inBlocks(const Use& use) const
    {
        constexpr std::size_t block = 256;
        const Foam::label* cells = reached_.data();
        for (std::size_t first = 0; first < reached_.size(); first += block)
            use(cells + first, cells + std::min(first + block, reached_.size()));
    }
    // blocks of cells, before the step of the gas
    void dragToGas(const Foam::label* cell, const Foam::label* end);
    void heatToGas(const Foam::label* cell, const Foam::label* end);
    // after it: what the particles read, by cell; blocks of particles, `read` is [count][readFields_]; what is left
    // over
    void momentumInCells(const Foam::label* cell, const Foam::label* end);
    void heatInCells(const Foam::label* cell, const Foam::label* end, const Foam::volVectorField* slope,
                     const Foam::scalarMinMax& range);
    void momentumToParticles(int first, int count, const double* read);
    void heatToParticles(int first, int count, const double* read);
    void momentumMismatch();
    void heatMismatch();

    const CouplingSettings settings_;
    const Foam::fvMesh& mesh_;
    Dem& dem_;
    Gas& gas_;
    Timing& timing_;
    const bool heat_;
    const bool push_;
    /// what a particle gives, and what cellSums_ has by cell: G [kg/s], with push_ c [N] (3), V held [m3], see dragOn;
    /// with heat_, from heatAt_ on, G, X, G T, G x (3), see heatOn; at volumeAt_ its volume
    const int heatAt_, volumeAt_;
    const int sumFields_;  ///< values of that
    const int readHeatAt_; ///< where heat begins in what particles read after the gas step; momentum comes first
    const int readFields_; ///< values of that by cell
    /// by particle, its answer to the gas in a step of this length, carried by the DEM: B or, with push_, G, held, see
    /// dragOn; with heat_ gain, early, see heatOn
    const int answerHeatAt_, answerFields_;
    Foam::vectorField halfExtent_; ///< of each cell's bounding box [m]
    Mapping mapping_;
    std::vector<std::size_t> place_; ///< of each cell's values in those that follow
    bool mapped_ = false, warned_ = false;

    std::vector<Foam::label> reached_; ///< cells in which particles weigh; the others' values are not kept up to date
    double widest_ = 0;                ///< largest kernel's half width over all ranks [m]
    double smallestCell_ = 0;          ///< shortest side of any cell's bounding box over all ranks [m]
    double answersStep_ = 0;           ///< gas step that answers are for, 0: none [s]
    long evaluations_ = 0;
    double courantThen_ = 0;            ///< rate of the gas when closures were evaluated [1/s]
    double sinceClosures_ = 0;          ///< Courant number since closures were evaluated
    double fastest_ = 0, stiffest_ = 0; ///< this rank's particles then: largest |v| [m/s], B/m [1/s]
    CellValues cellSums_;               ///< by cell, what particles give, summed with the weights
    CellValues cellValues_;             ///< what is read or summed up just now
    std::vector<double> early_;         ///< by cell: how much of the exchange sees the gas before the step, [0, 1]
    Foam::scalarField temperatureBefore_, specificHeat_; ///< of the gas, before its step
    double heatExchanged_ = 0;
    Foam::vector impulse_ = Foam::Zero, dragReceived_ = Foam::Zero; ///< [N s], [N]
    double dragExchanged_ = 0, heatReceived_ = 0;                   ///< sum of absolute values [N]; sum [J]
    double mismatch_ = 0;
};

} // namespace hotbed
