#pragma once

#include "cells.hpp"

#include <mpi.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace hotbed
{

/// @param radius  [m]
/// @return [m3]
inline double sphereVolume(double radius)
{
    return 4.0 / 3.0 * M_PI * radius * radius * radius;
}

/// Half the full window of a particle's kernel, n = perRadius * radius + length.
struct KernelWidth
{
    double perRadius = 0; ///< [-]
    double length = 0;    ///< [m]

    double half(double radius) const { return perRadius * radius + length; }
};

/// Particles of one rank as the mapping needs them. Arrays belong to the caller.
struct ParticlePositions
{
    int count = 0;
    const double (*position)[3] = nullptr; ///< [m]
    const double* radius = nullptr;        ///< [m]
    KernelWidth kernel;
};

/// The one mapping between particles and cells, both ways (eq 4, 8): weights w_ic of particle i and cell c with
/// sum_c w_ic = 1 for every particle, over all ranks and at all walls.
///
/// Particles live on the ranks of the DEM, cells on those of the gas; the two decompositions are independent. Each
/// particle is copied to every rank whose cells its kernel can reach; that rank holds the weights of its own cells.
/// The particle's DEM rank is its home: partial sums go there. Messages are per particle and between the ranks that
/// need them; nothing has the size of the whole system.
class Mapping
{
public:
    Mapping(MPI_Comm communicator, std::unique_ptr<const Cells> cells);

    /// Weights for new positions. Collective.
    /// @param volumes  [cells().size()], the particles' volumes are added to [m3], where given
    /// @return for each particle of this rank whether its centre lies in the mesh. Particles that lie outside carry
    ///         no weights: nothing is exchanged with them.
    const std::vector<char>& update(const ParticlePositions& particles, double* volumes = nullptr);

    /// The largest half width of a kernel of this rank's particles [m].
    double widest() const { return widest_; }

    /// What this rank has sent to others so far.
    std::int64_t bytesSent() const { return bytesSent_; }

    const Cells& cells() const { return *cells_; }

    int particles() const { return particles_; }                               ///< particles of this rank (home)
    int copies() const { return direct_ ? particles_ : receiveStart_.back(); } ///< with weights on this rank

    /// Values of particles to their copies. Collective.
    /// @param fields   values per particle
    /// @param home     [particles()][fields]
    /// @return [copies()][fields]; valid until the next call on this object
    const double* toCopies(int fields, const double* home);

    /// Values of particles that `update` sent already: their positions.
    const double (*copyPositions(const double (*home)[3]) const)[3]
    {
        return direct_ ? home : reinterpret_cast<const double(*)[3]>(copyPosition_.data());
    }

    /// Partial sums of the copies added up at home. Collective.
    /// @param copies   [copies()][fields]
    /// @return [particles()][fields]; valid until the next call on this object
    const double* toHome(int fields, const double* copies);

    /// Weighted mean of cell values at the particles. Collective.
    /// @param fields      values per cell: 1, 2, 8 or 12
    /// @param cellValues  [cells().size()][fields]
    /// @return [particles()][fields]; valid until the next call on this object
    const double* interpolate(int fields, const double* cellValues);

    /// Adds weight times particle value to the cells; local.
    /// @param fields    values per particle: 1, 2, 8 or 12
    /// @param copies    [copies()][fields]
    /// @param cellSums  [cells().size()][fields], added to
    void deposit(int fields, const double* copies, double* cellSums) { weights_->deposit(fields, copies, cellSums); }

    /// Weighted means to the particles, a block of them at a time: few enough that these need not leave the (second)
    /// cache, enough that the processor sees the arrays that follow each other coming. Collective.
    static constexpr int block = 2048;
    using Use = std::function<void(int first, int count, const double* values)>; ///< [count][fields], count <= block
    void interpolate(int fields, const double* cellValues, const Use& use);

    /// The same, and what the particles answer to the cells; on one rank block by block. Collective.
    /// @param use     sets what its particles give
    /// @param given   [particles()][givenFields]
    /// @param fill    what is summed up, from what `count` copies give: [count][givenFields] -> [count][sumFields]
    /// @param sums    [cells().size()][sumFields], added to
    using Fill = std::function<void(int first, int count, const double* given, double* values)>;
    void answer(int fields, const double* cellValues, const Use& use, int givenFields, const double* given,
                const Fill& fill, int sumFields, double* sums);

private:
    void route(const ParticlePositions& particles);
    void weighCopies(const ParticlePositions& particles);
    void weigh(const ParticlePositions& particles, int first, int count);
    void exchange(int fields, const double* send, const std::vector<int>& sendStart, double* receive,
                  const std::vector<int>& receiveStart);

    MPI_Comm communicator_;
    const int ranks_;
    int rank_ = 0;
    std::unique_ptr<const Cells> cells_;
    std::unique_ptr<Weights> weights_;
    std::vector<Box> bounds_; ///< of each rank's cells

    std::int64_t bytesSent_ = 0;
    int particles_ = 0;
    double widest_ = 0;
    const bool direct_;                         ///< one rank: copies are the particles themselves, nothing is packed
    std::vector<int> sendParticle_;             ///< particle of each entry sent, rank after rank
    std::vector<int> sendStart_, receiveStart_; ///< by rank
    std::vector<Point> copyPosition_;           ///< on several ranks
    std::vector<double> copyRadius_;
    std::vector<char> inside_;
    std::vector<double> sendBuffer_, receiveBuffer_, result_, partial_, filled_;
};

} // namespace hotbed
