#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace hotbed
{

/// One axis of a lattice of boxes.
struct BoxAxis
{
    std::vector<double> face;              ///< ascending
    double origin = 0, inverseSpacing = 0; ///< of the faces, where these are uniform
    bool uniform = false, folded = false;
    std::array<double, 2> wall{{0, 0}}; ///< where folded: kernel mass beyond these is mirrored back

    /// index of the interval that holds x, clamped to the valid ones
    int interval(double x) const;
};

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
    std::size_t rowEnd = 0;

    void clear();

    /// More particles: the kernel mass of each on the lattice.
    /// @param particles  centre and half the full window of each [m]
    /// @param mass       set: kernel mass on the whole lattice, whether its slots have cells or not
    void append(const std::array<BoxAxis, 3>& axis, int count, const double (*particles)[4], double (*mass)[2]);

    /// Mass of a particle on cells that are there.
    double mass(const Particle& p) const;
};

/// Weighted sum of cell values for some of the particles.
/// @param fields  values per cell: 1, 2, 4, 8, 12 or 16
/// @param first   the first of `count` particles
/// @param cells   [cells][fields]
/// @param result  [count][fields], set
void interpolate(int fields, const BoxWeights& weights, int first, int count, const double* cells, double* result);

/// Adds weight times particle value to the cells.
/// @param fields     values per particle: 1, 2, 4, 8, 12 or 16
/// @param first      the first of `count` particles
/// @param particles  [count][fields]
/// @param cells      [cells][fields], added to
void deposit(int fields, const BoxWeights& weights, int first, int count, const double* particles, double* cells);

} // namespace hotbed
