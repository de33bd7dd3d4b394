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

/// What particles give to the cells.
struct Gift
{
    static constexpr int part = 256; ///< particles at a time, at most: few enough to stay in the nearest cache
    /// Sets what particles of this rank add to the sums, [count][sums].
    using Give = std::function<void(int first, int count, double* given)>;
    int sums; ///< by cell: 1, 2, 8 or 12
    Give give;
};

/// The one mapping between particles and cells, both ways (eq 4, 8): weights w_ic of particle i and cell c with
/// sum_c w_ic = 1 for every particle, over all ranks and at all walls.
///
/// Particles live on the ranks of the DEM, their home, cells on those of the gas; the two decompositions are
/// independent. A rank holds the weights of its particles on its cells, where they lie. Of a particle whose kernel can
/// reach the cells of another rank that one has a guest, with the kernel masses on its cells; what guests read of the
/// gas goes home, and what their particles give comes to them. So messages are per guest and between the ranks that
/// need them, and nothing has the size of the whole system. The factor that makes weights of a guest's masses stays at
/// home: it is in what is sent, and what is received is multiplied by it.
class Mapping
{
public:
    Mapping(MPI_Comm communicator, std::unique_ptr<const Cells> cells);

    /// Weights for new positions, and, where asked for, what particles give at once. Collective.
    /// @param cellSums  [cells().places()][gift->sums], added to
    void update(const ParticlePositions& particles, const Gift* gift = nullptr, double* cellSums = nullptr);

    /// For each particle of this rank, whether its centre lies in the mesh. Particles that lie outside carry no
    /// weights: nothing is exchanged with them.
    const std::vector<char>& inside() const { return inside_; }

    /// The largest half width of a kernel of this rank's particles [m].
    double widest() const { return widest_; }

    /// What this rank has sent to others so far.
    std::int64_t bytesSent() const { return bytesSent_; }

    const Cells& cells() const { return *cells_; }

    /// Weighted means of cell values to the particles, a block of them at a time: few enough that these need not leave
    /// the (second) cache, enough that the processor sees the arrays that follow each other coming. Collective.
    /// @param fields      values per cell: 1, 2, 8 or 12
    /// @param cellValues  [cells().places()][fields]
    static constexpr int block = 2048;
    using Use = std::function<void(int first, int count, const double* values)>; ///< [count][fields], count <= block
    void interpolate(int fields, const double* cellValues, const Use& use);

    /// The same, and what the particles answer to the cells, block by block. Collective.
    /// @param use       called before its particles give
    /// @param cellSums  [cells().places()][gift.sums], added to
    void answer(int fields, const double* cellValues, const Use& use, const Gift& gift, double* cellSums);

private:
    class Guests;

    void route(const ParticlePositions& particles);
    const double* receiveGuests(const ParticlePositions& particles);
    const double* fromGuests(int fields, const double* guests);
    void give(const Gift& gift, int first, int count, Guests& outgoing, double* sums);
    void giveGuests(const Gift& gift, double* sums, double* cellSums);
    void exchange(int fields, const double* send, const std::vector<int>& sendStart, double* receive,
                  const std::vector<int>& receiveStart);

    MPI_Comm communicator_;
    const int ranks_;
    int rank_ = 0;
    std::unique_ptr<const Cells> cells_;
    /// of this rank's particles, of its guests; on the same cells, so `read` and `sums` of the first serve both
    std::unique_ptr<Weights> weights_, guestWeights_;
    std::vector<Box> bounds_; ///< of each rank's cells

    std::int64_t bytesSent_ = 0;
    int particles_ = 0, guests_ = 0;
    double widest_ = 0;
    std::vector<int> sendParticle_;             ///< particle of each entry sent: rank after rank, ascending for each
    std::vector<int> sendStart_, receiveStart_; ///< by rank
    std::vector<double> sendFactor_;            ///< of each entry sent: that makes weights of its kernel masses
    std::vector<char> inside_;
    std::vector<double> sendBuffer_, receiveBuffer_, partial_, guestPartial_, given_;
};

} // namespace hotbed
