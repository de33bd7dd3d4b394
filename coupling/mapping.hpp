#pragma once

#include "cells.hpp"

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace hotbed
{

/// Particles of one rank as the mapping needs them. Arrays belong to the caller.
struct ParticlePositions
{
    int count = 0;
    const double (*position)[3] = nullptr; ///< [m]
    const double* halfWidth = nullptr;     ///< n of the kernel [m]
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
    /// @return for each particle of this rank whether its centre lies in the mesh. Particles that lie outside carry
    ///         no weights: nothing is exchanged with them.
    std::vector<char> update(const ParticlePositions& particles);

    const Cells& cells() const { return *cells_; }

    int particles() const { return particles_; }          ///< particles of this rank (home)
    int copies() const { return int(start_.size()) - 1; } ///< particles with weights on this rank
    /// Weights of copy k: entries start()[k] to start()[k+1] of cell() and weight().
    const std::vector<std::int64_t>& start() const { return start_; }
    const std::vector<int>& cell() const { return mass_.cell; }
    const std::vector<double>& weight() const { return mass_.mass; }
    const Point& copyPosition(int k) const { return copyPosition_[k]; }

    /// Values of particles to their copies. Collective.
    /// @param fields   values per particle
    /// @param home     [particles()][fields]
    /// @return [copies()][fields]; valid until the next call on this object
    const double* toCopies(int fields, const double* home);

    /// Partial sums of the copies added up at home. Collective.
    /// @param copies   [copies()][fields]
    /// @return [particles()][fields]; valid until the next call on this object
    const double* toHome(int fields, const double* copies);

    /// Weighted mean of cell values at the particles. Collective.
    /// @param cellValues [cells().size()][Fields]
    /// @return [particles()][Fields]; valid until the next call on this object
    template <int Fields> const double* interpolate(const double* cellValues);

    /// Adds weight times particle value to the cells; local.
    /// @param copies     [copies()][Fields]
    /// @param cellSums   [cells().size()][Fields], added to
    template <int Fields> void deposit(const double* copies, double* cellSums) const;

private:
    void route(const ParticlePositions& particles);
    void exchange(int fields, const double* send, const std::vector<int>& sendStart, double* receive,
                  const std::vector<int>& receiveStart);

    MPI_Comm communicator_;
    int rank_ = 0, ranks_ = 1;
    std::unique_ptr<const Cells> cells_;
    std::vector<Box> bounds_; ///< of each rank's cells

    int particles_ = 0;
    bool direct_ = false;                       ///< one rank: copies are the particles themselves, nothing is packed
    std::vector<int> sendParticle_;             ///< particle of each entry sent, rank after rank
    std::vector<int> sendStart_, receiveStart_; ///< by rank
    std::vector<Point> copyPosition_;
    std::vector<std::int64_t> start_{0};
    CellMass mass_;
    std::vector<double> sendBuffer_, receiveBuffer_, result_, partial_;
};

template <int Fields> const double* Mapping::interpolate(const double* cellValues)
{
    const int n = copies();
    partial_.resize(std::size_t(n) * Fields);
    for (int k = 0; k < n; ++k)
    {
        double sum[Fields] = {};
        for (std::int64_t e = start_[k]; e < start_[k + 1]; ++e)
        {
            const double w = mass_.mass[e];
            const double* value = cellValues + std::size_t(mass_.cell[e]) * Fields;
            for (int f = 0; f < Fields; ++f) sum[f] += w * value[f];
        }
        for (int f = 0; f < Fields; ++f) partial_[std::size_t(k) * Fields + f] = sum[f];
    }
    return toHome(Fields, partial_.data());
}

template <int Fields> void Mapping::deposit(const double* copies, double* cellSums) const
{
    const int n = int(start_.size()) - 1;
    for (int k = 0; k < n; ++k)
    {
        const double* value = copies + std::size_t(k) * Fields;
        for (std::int64_t e = start_[k]; e < start_[k + 1]; ++e)
        {
            const double w = mass_.mass[e];
            double* sum = cellSums + std::size_t(mass_.cell[e]) * Fields;
            for (int f = 0; f < Fields; ++f) sum[f] += w * value[f];
        }
    }
}

} // namespace hotbed
