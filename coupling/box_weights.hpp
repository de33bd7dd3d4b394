#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace hotbed
{

/// Weights of particles on a lattice of boxes as products of one-dimensional ones: three short rows a particle instead
/// of a weight for every cell it reaches, so that the loops over cells read next to nothing but the cells.
struct BoxWeights
{
    struct Particle
    {
        int slot = 0;                        ///< lattice slot of the first cell
        std::array<int, 3> count{{0, 0, 0}}; ///< cells along each axis; 0 where no cell is reached
        std::int64_t row = 0;                ///< the rows of x, y and z begin here, one after the other
    };

    const int* cellOf = nullptr; ///< lattice slot -> cell, -1 for none
    int nx = 0, nxy = 0;         ///< slots a row, slots a layer
    std::vector<Particle> particle;
    std::vector<double> row; ///< one-dimensional masses, and room for more

    /// Mass of a particle on cells that are there.
    double mass(const Particle& p) const;
};

/// Weighted sum of cell values for each particle.
/// @param fields  values per cell: 1, 2, 4 or 8
/// @param cells   [cells][fields]
/// @param result  [particles][fields], set
void interpolate(int fields, const BoxWeights& weights, const double* cells, double* result);

/// Adds weight times particle value to the cells.
/// @param fields     values per particle: 1, 2, 4 or 8
/// @param particles  [particles][fields]
/// @param cells      [cells][fields], added to
void deposit(int fields, const BoxWeights& weights, const double* particles, double* cells);

} // namespace hotbed
