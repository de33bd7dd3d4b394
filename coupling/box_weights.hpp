#pragma once

#include "cell_values.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace hotbed
{

/// Whether a particle is one that exchanges anything.
/// @param mass    kernel mass of a particle on cells
/// @param centre  above 0 where one of these holds its centre
inline bool isInside(double mass, double centre)
{
    return (centre > 0.0) & (mass > 0.0);
}

/// One axis of a lattice of boxes.
struct BoxAxis
{
    std::vector<double> face;                           ///< ascending
    double origin = 0, spacing = 0, inverseSpacing = 0; ///< of the faces, where these are uniform
    bool uniform = false, folded = false;
    std::array<double, 2> wall{{0, 0}}; ///< where folded: kernel mass beyond these is mirrored back

    /// index of the interval that holds x, clamped to the valid ones
    int interval(double x) const;
};

/// Weights of particles on a lattice of boxes as products of one-dimensional ones: three short rows a particle instead
/// of a weight for every cell it reaches, so that the loops over cells read next to nothing but the cells.
struct BoxWeights
{
    static constexpr int group = 64; ///< particles whose rows are made together and as long as each other's
    static constexpr int lanes = 8;  ///< of these, those that lie side by side, for whole registers

    struct Particle
    {
        int slot = 0;                        ///< lattice slot of the first cell
        std::array<int, 3> count{{0, 0, 0}}; ///< cells along each axis; 0 where no cell is reached
    };

    /// Where the masses of a group lie.
    struct Rows
    {
        std::size_t begin;
        int y, z, end; ///< masses along x come before y, those along y before z, those along z before end
    };

    const int* cellOf = nullptr; ///< lattice slot -> cell, -1 for none; null where a slot's number is its cell's place
    int nx = 0, nxy = 0;         ///< slots a row, slots a layer
    int particles = 0;
    std::vector<Particle> particle; ///< room for more than there are
    CellValues row; ///< one-dimensional masses, [group / lanes][along x, y, z][lanes] by group, and room for more
    std::vector<Rows> rows; ///< by group
    std::size_t rowEnd = 0;

    void clear();

    /// Room for more particles, and for the masses of one more group.
    Particle* room(int more);
    double* room(Rows more);

    /// More particles: the kernel mass of each on the lattice. Groups before must be full.
    /// @param halfWidth  half the full window [m]
    /// @param mass       set: kernel mass on the whole lattice, whether its slots have cells or not
    /// @param centre     set: 1 where the centre lies in the lattice or on its surface, else 0
    void append(const std::array<BoxAxis, 3>& axis, int count, const double (*position)[3], const double* halfWidth,
                double* mass, double* centre);

    /// More particles, whose weights sum to one with those that they have elsewhere.
    /// @param mass    kernel mass elsewhere; set to the factor that made the weights of it
    /// @param centre  above 0 where the centre is held elsewhere; this lattice is added
    /// @param inside  set: whether the centre is held at all; particles outside have no weights; null: as `append` does
    void appendShares(const std::array<BoxAxis, 3>& axis, int count, const double (*position)[3],
                      const double* halfWidth, double* mass, double* centre, char* inside);

    /// Multiplies the weights of `count` particles by a factor for each.
    void scale(int first, int count, const double* factor);

    /// Mass of a particle on cells that are there.
    double mass(int particle) const;
};

/// Weighted sum of cell values for some of the particles.
/// @param fields  values per cell: 1, 2, 8 or 12
/// @param first   the first of `count` particles
/// @param cells   [cells][fields]
/// @param result  [count][fields], set
void interpolate(int fields, const BoxWeights& weights, int first, int count, const double* cells, double* result);

/// Adds weight times particle value to the cells.
/// @param fields     values per particle: 1, 2, 8 or 12
/// @param first      the first of `count` particles
/// @param particles  [count][fields]
/// @param cells      [cells][fields], added to
void deposit(int fields, const BoxWeights& weights, int first, int count, const double* particles, double* cells);

} // namespace hotbed
