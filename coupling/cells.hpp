#pragma once

#include "box_weights.hpp"

#include <array>
#include <memory>
#include <vector>

namespace hotbed
{

using Point = std::array<double, 3>;

/// Axis-aligned box; empty when low > high.
struct Box
{
    Point low{{1, 1, 1}};
    Point high{{-1, -1, -1}};
};

/// Weights of many particles on the cells of one rank, in the layout that suits the kind of cell.
class Weights
{
public:
    virtual ~Weights() = default;

    /// Forgets all particles.
    virtual void clear() = 0;

    /// Takes more particles, whose weights are the kernel mass in each cell of this rank.
    /// @param position   centre [m]
    /// @param halfWidth  n, half the full window [m]
    /// @param mass       set for each: kernel mass on all cells of this rank (what lies outside every rank's cells is
    ///                   missing from 1)
    /// @param centre     set for each: 1 where a cell of this rank holds the centre, else 0
    virtual void append(int count, const double (*position)[3], const double* halfWidth, double* mass,
                        double* centre) = 0;

    /// Takes more particles, whose weights sum to one with those that they have on other ranks.
    /// @param mass    kernel mass on cells of other ranks; set to the factor that made the weights of it
    /// @param centre  how many cells of other ranks hold the centre; those of this rank are added
    /// @param inside  set for each: whether its centre lies in a cell; particles outside have no weights
    virtual void appendShares(int count, const double (*position)[3], const double* halfWidth, double* mass,
                              double* centre, char* inside);

    /// Multiplies each particle's weights by a factor of its own.
    virtual void scale(int first, int count, const double* factor) = 0;

    /// See box_weights.hpp: [places][fields] -> [count][fields] and back; 1, 2, 8 or 12 fields. What they read is
    /// what `read` makes of the cells' values; what they add to is what `sums` gives, and `passOn` brings it to the
    /// cells.
    virtual void interpolate(int fields, int first, int count, const double* read, double* particles) const = 0;
    virtual void deposit(int fields, int first, int count, const double* particles, double* sums) const = 0;
    virtual const double* read(int, const double* cells) { return cells; }
    virtual double* sums(int, double* cells) { return cells; }
    virtual void passOn(int, double*) {}

    /// Number of particles.
    virtual int size() const = 0;
};

/// The cells of one rank as the mapping sees them.
class Cells
{
public:
    virtual ~Cells() = default;

    /// Number of cells of this rank.
    virtual int size() const = 0;

    /// Number of places for values of cells, in what is read and summed up with the weights, and the one of a cell.
    virtual int places() const { return size(); }
    virtual int place(int cell) const { return cell; }

    /// Smallest box around the cells of this rank; empty without cells.
    virtual Box bounds() const = 0;

    /// Whether a point lies in, or on the surface of, a cell of this rank.
    virtual bool contains(const Point& x) const = 0;

    /// Weights on these cells, still without particles. The cells must outlive them.
    virtual std::unique_ptr<Weights> weights() const = 0;
};

/// Cells that are axis-aligned boxes, in any arrangement (uniform, graded, several blocks): kernel masses are exact,
/// products of one-dimensional integrals on the lattice of all cell faces.
class BoxCells : public Cells
{
public:
    /// @param boxes   one box a cell, in cell order
    /// @param domain  the whole domain over all ranks where it is one full box: kernel mass beyond it is then folded
    ///                back, so that an even packing has an even voidage up to the walls; an empty box otherwise
    BoxCells(const std::vector<Box>& boxes, const Box& domain);

    int size() const override { return nCells_; }
    int places() const override { return nCells_ > 0 ? place(nCells_ - 1) + 1 : 0; }
    /// Rows of cells along x are not 4 KiB apart: what a particle reaches would fall on few lines of the nearest cache.
    int place(int cell) const override { return ordered_ ? cell / nSlots_[0] * row_ + cell % nSlots_[0] : cell; }
    Box bounds() const override;
    bool contains(const Point& x) const override;
    std::unique_ptr<Weights> weights() const override;

private:
    class Products;

    int slot(int i, int j, int k) const { return (k * nSlots_[1] + j) * nSlots_[0] + i; }

    int nCells_;
    std::array<BoxAxis, 3> axis_;
    std::array<int, 3> nSlots_{{0, 0, 0}};
    int row_ = 0;             ///< places from one row along x to the next
    std::vector<int> cellOf_; ///< lattice slot -> cell, -1 for a slot of another rank or a hole
    bool full_ = false;       ///< every slot has a cell
    bool ordered_ = false;    ///< and its number
};

/// Cells of any shape, through a lattice of equal boxes laid over them: kernel masses are exact on the boxes, and each
/// box hands its mass on to cells in fixed shares. The finer the lattice, the nearer to the masses on the cells.
class LatticeCells : public Cells
{
public:
    /// The part of a box's mass that a cell takes.
    struct Share
    {
        int box, cell;
        double part;
    };

    /// @param size    cells of this rank
    /// @param face    ascending coordinates of the lattice planes, by axis; box (i, j, k) is number (k ny + j) nx + i
    /// @param shares  of the cells of this rank; over all ranks the parts of a box add up to one, or less where mass
    ///                beyond the walls is to be left out
    /// @param inside  by box: whether it holds a piece of a cell of this rank
    LatticeCells(int size, const std::array<std::vector<double>, 3>& face, std::vector<Share> shares,
                 std::vector<char> inside);

    int size() const override { return size_; }
    Box bounds() const override { return boxes_.bounds(); }

    /// Whether a point lies in a box that holds a piece of a cell: beside a wall it may be up to a box beyond it, which
    /// is where a particle on a wall that is drawn more finely than the cells' has a right to be.
    bool contains(const Point& x) const override;
    std::unique_ptr<Weights> weights() const override;

private:
    class Spread;

    int size_;
    std::array<std::vector<double>, 3> face_;
    BoxCells boxes_;
    std::vector<char> inside_;
    std::vector<Share> shares_;   ///< with the place of the box for its number
    std::vector<double> covered_; ///< by place of a box: the part of its mass that cells of this rank take
};

} // namespace hotbed
