#pragma once

#include "contact_time.hpp"

#include <mpi.h>

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace hotbed
{

/// A LIGGGHTS simulation inside another program: runs an input script once, then advances step by step while its
/// host reads the particles and gives them heat. Knows nothing of the gas. Input errors found by LIGGGHTS end the
/// process with LIGGGHTS' own message on stderr; those found here are thrown as std::runtime_error.
class __attribute__((visibility("default"))) Dem
{
public:
    /// LIGGGHTS without particles. Two in a process are more than LIGGGHTS is made for.
    /// @param log  path of the log file LIGGGHTS writes
    Dem(MPI_Comm communicator, const std::string& log);
    ~Dem();

    std::string version() const; ///< in LIGGGHTS' own words

    /// Before the script: into how many pieces its box is cut along x, y, z for the ranks, one each. The command
    /// `processors` in the script overrides it.
    /// @param pieces  their product is the number of ranks; 0: LIGGGHTS chooses
    void divide(const std::array<int, 3>& pieces);

    /// Runs the script, once.
    /// @param script     path of the input script
    /// @param variables  index variables set before the script (LIGGGHTS' -var name value)
    void read(const std::string& script, const std::vector<std::pair<std::string, std::string>>& variables);

    /// How well the DEM step resolves the contacts, before the set-up of a run refuses it; empty without particles and
    /// without pair_style gran model hotbed.
    std::vector<ContactTime> contacts();

    /// Whether a pair style is in use, and whether that is another one than pair_style gran model hotbed, which alone
    /// takes the constants of the original particle.
    bool hasContacts() const;
    bool otherContacts() const;

    /// Set-up of the run (lists, ghosts, first forces); after it particles can be read.
    /// @param resumed  the script read what writeRestart wrote: forces go on from there
    void setup(bool resumed);

    /// LIGGGHTS' restart file with everything of the particles. @param take gets its bytes piece by piece, on the first
    /// rank, from another thread; must not throw
    void writeRestart(const std::function<void(const char* bytes, std::size_t size)>& take);

    int size() const;                    ///< particles of this rank
    const double (*position() const)[3]; ///< [m]
    const double (*velocity() const)[3]; ///< [m/s]
    const double* radius() const;        ///< of the coarse particle [m]
    double largestRadius() const;        ///< on any rank, also of particles that are still to be inserted [m]
    const double* mass() const;          ///< of the coarse particle [kg]
    const int* tag() const;              ///< LIGGGHTS' particle ids

    double ratio() const;                  ///< coarse-graining ratio of fix hotbed/coarsegrain, 1 without one
    double timestep() const;               ///< [s]
    long step() const;                     ///< LIGGGHTS' step number
    std::array<double, 3> gravity() const; ///< that the script gives the particles, after setup [m/s2]
    bool moving() const;                   ///< whether anything in the script moves or adds particles
    bool heat() const;                     ///< whether the script has a fix hotbed/heat

    bool drag() const;                                                ///< whether the script has a fix hotbed/drag
    const double (*gasForce() const)[3];                              ///< force of the gas on each particle [N]
    void setGasForce(int first, int count, const double (*force)[3]); ///< from the next DEM step on [N]
    double (*gasAlone() const)[4];                                    ///< see FixHotbedDrag::alone
    const double (*force() const)[3]; ///< all forces at the end of the last DEM step [N]

    /// So many numbers of the host's go with each particle from now on, from rank to rank, not into restart files; 0
    /// for a new particle.
    void carry(int values);
    double* carried() const; ///< [size()][values]
    bool newParticles();     ///< whether there are such on this rank since it was asked last

    /// Largest overlap of this rank's particles with each other and with primitive walls at the end of the last DEM
    /// step, over the diameter of the smaller particle; 0 where nothing touches or there is no pair_style gran.
    /// @param particle  one of the two, where something touches
    double largestOverlap(int* particle = nullptr) const;

    std::string describe(int particle) const; ///< id, place and velocity in words
    std::string fastest() const;              ///< this rank's fastest particle, in words; empty without particles

    double* temperature() const;                                     ///< [K]
    double* nusselt() const;                                         ///< [-]
    void heatCapacity(int first, int count, double* capacity) const; ///< m c [J/K] by particle, from the first on
    double thermalEnergy() const;                                    ///< sum of m c T over all ranks [J]; collective
    void warm(int first, int count, const double* change);           ///< [K] by particle, from the first of `count` on

    /// Runs `steps` DEM steps, with the script's output. Where nothing moves only the output happens. A particle that
    /// blows up ends the process with LIGGGHTS' kind of message.
    void advance(int steps);

    /// Seconds that `advance` has spent so far on contacts, neighbour lists, walls, ..., on this rank.
    std::vector<std::pair<std::string, double>> times() const;

    /// Closes the run as LIGGGHTS does at the end of `run`.
    void finish();

private:
    struct Instance;
    std::unique_ptr<Instance> instance_;
};

} // namespace hotbed
