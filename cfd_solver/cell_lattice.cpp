#include "cell_lattice.hpp"

#include "polyMeshTetDecomposition.H"
#include "processorPolyPatch.H"
#include "tetPoints.H"
#include "triSurface.H"
#include "triSurfaceSearch.H"
#include "volFields.H"

#include <mpi.h>

#include <map>

using namespace Foam;

namespace hotbed
{
namespace
{

using Slot = std::array<int, 3>; // of a box, along the axes

/// Equal boxes over the whole mesh and some way beyond it, the same on every rank.
struct Lattice
{
    vector origin, spacing;
    Slot count;

    scalar face(int a, int i) const { return origin[a] + i * spacing[a]; }
    scalar volume() const { return cmptProduct(spacing); }
    label number(const Slot& s) const { return (s[2] * count[1] + s[1]) * count[0] + s[0]; }
    Slot slot(label number) const
    {
        return {{number % count[0], number / count[0] % count[1], number / count[0] / count[1]}};
    }
    point centre(const Slot& s) const
    {
        return origin + cmptMultiply(spacing, vector(s[0] + 0.5, s[1] + 0.5, s[2] + 0.5));
    }
    /// distance from the lattice's corner, in boxes
    scalar boxes(int a, scalar x) const { return (x - origin[a]) / spacing[a]; }
};

/// As many boxes in the mesh as cells times perCell^3; the ends of the mesh are on planes of the lattice.
Lattice makeLattice(const fvMesh& mesh, int perCell, scalar reach)
{
    vector extent = Zero; // of a mean cell
    for (label c = 0; c < mesh.nCells(); ++c) extent += boundBox(mesh.points(), mesh.cellPoints()[c], false).span();
    reduce(extent, sumOp<vector>());
    const scalar cells = returnReduce(mesh.nCells(), sumOp<label>()), volume = gSum(mesh.V());
    extent *= std::cbrt(volume / cells / cmptProduct(extent)) / perCell;

    const boundBox& whole = mesh.bounds(); // over all ranks
    Lattice lattice;
    scalar boxes = 1;
    for (int a = 0; a < 3; ++a)
    {
        const int inside = max(1, int(std::lround(whole.span()[a] / extent[a])));
        lattice.spacing[a] = whole.span()[a] / inside;
        const int beyond = int(std::ceil(reach / lattice.spacing[a]));
        lattice.origin[a] = whole.min()[a] - beyond * lattice.spacing[a];
        lattice.count[a] = inside + 2 * beyond;
        boxes *= lattice.count[a];
    }
    if (boxes > 5e7)
        FatalErrorInFunction << "the lattice of the mapping has " << boxes
                             << " boxes: too many for memory; set kernelSamples "
                             << "in constant/couplingProperties to less than " << perCell
                             << ", or use particles or a window that are small against the mesh" << exit(FatalError);
    return lattice;
}

/// visit(slot, tet) for each piece of a tetrahedron in a box, cut along one axis after the other
template <class Visit> void cut(const Lattice& lattice, int axis, Slot& slot, const tetPoints& tet, Visit&& visit)
{
    if (axis == 3)
    {
        visit(slot, tet);
        return;
    }
    struct Pieces
    {
        std::vector<tetPoints> tets;
        void operator()(const tetPoints& t) { tets.push_back(t); }
    };
    scalar low = GREAT, high = -GREAT;
    for (const point& p : tet)
    {
        low = min(low, lattice.boxes(axis, p[axis]));
        high = max(high, lattice.boxes(axis, p[axis]));
    }
    const int first = std::clamp(int(low + 1e-9), 0, lattice.count[axis] - 1);
    const int last = std::clamp(int(std::ceil(high - 1e-9)) - 1, first, lattice.count[axis] - 1);
    vector normal = Zero;
    normal[axis] = 1;
    Pieces rest;
    rest.tets = {tet};
    for (slot[axis] = first; slot[axis] < last; ++slot[axis])
    {
        point on = Zero;
        on[axis] = lattice.face(axis, slot[axis] + 1);
        const plane next(on, normal, false);
        Pieces below, above;
        for (const tetPoints& t : rest.tets) t.tet().sliceWithPlane(next, above, below);
        const Slot here = slot;
        for (const tetPoints& t : below.tets) cut(lattice, axis + 1, slot, t, visit);
        slot = here;
        rest = std::move(above);
    }
    const Slot here = slot;
    for (const tetPoints& t : rest.tets)
    {
        slot = here;
        cut(lattice, axis + 1, slot, t, visit);
    }
}

/// The boundary of the whole mesh, on every rank.
triSurface boundary(const fvMesh& mesh)
{
    DynamicList<point> corners; // three a triangle
    for (const polyPatch& patch : mesh.boundaryMesh())
    {
        if (isA<processorPolyPatch>(patch)) continue;
        for (const face& f : patch.localFaces())
            for (label n = 1; n + 1 < f.size(); ++n)
                for (const label p : {f[0], f[n], f[n + 1]}) corners.append(patch.localPoints()[p]);
    }
    List<pointField> byRank(Pstream::nProcs());
    byRank[Pstream::myProcNo()] = pointField(corners);
    Pstream::gatherList(byRank);
    Pstream::scatterList(byRank);
    pointField all;
    for (const pointField& mine : byRank) all.append(mine);
    List<labelledTri> triangles(all.size() / 3);
    forAll(triangles, t) triangles[t] = labelledTri(3 * t, 3 * t + 1, 3 * t + 2, 0);
    return triSurface(triangles, all);
}

/// What the boxes of a lattice hold.
struct Contents
{
    std::map<label, std::map<label, scalar>> cells; ///< box -> cell of this rank -> part of the box
    std::vector<std::array<double, 4>> whole;       ///< by box, of all ranks: part that is mesh, its first moment
};

Contents cutCells(const fvMesh& mesh, const Lattice& lattice)
{
    Contents held;
    held.whole.assign(std::size_t(lattice.count[0]) * lattice.count[1] * lattice.count[2], {{0, 0, 0, 0}});
    for (label c = 0; c < mesh.nCells(); ++c)
        for (const tetIndices& indices : polyMeshTetDecomposition::cellTetIndices(mesh, c))
        {
            const tetPointRef tet = indices.tet(mesh);
            Slot slot{};
            cut(lattice, 0, slot, tetPoints(tet.a(), tet.b(), tet.c(), tet.d()),
                [&](const Slot& s, const tetPoints& piece)
                {
                    const tetPointRef t = piece.tet();
                    const scalar part = t.mag() / lattice.volume();
                    if (!(part > 1e-12)) return;
                    const label box = lattice.number(s);
                    held.cells[box][c] += part;
                    const point centre = t.centre();
                    held.whole[box][0] += part;
                    for (int a = 0; a < 3; ++a) held.whole[box][1 + a] += part * centre[a];
                });
        }
    MPI_Allreduce(MPI_IN_PLACE, held.whole.data(), int(4 * held.whole.size()), MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    return held;
}

/// The boxes over which a box about a point is spread, each with its part of that box; parts of mesh add up to one, or
/// there is none.
std::vector<std::pair<label, scalar>> boxesAbout(const point& x, const Lattice& lattice, const Contents& held)
{
    Slot low;
    vector upper; // part that is in the higher box along each axis
    for (int a = 0; a < 3; ++a)
    {
        const scalar at = std::clamp(lattice.boxes(a, x[a]) - 0.5, 0.0, lattice.count[a] - 1.0);
        low[a] = min(int(at), max(0, lattice.count[a] - 2));
        upper[a] = at - low[a];
    }
    std::vector<std::pair<label, scalar>> boxes;
    scalar found = 0;
    for (int n = 0; n < 8; ++n)
    {
        Slot s;
        scalar part = 1;
        for (int a = 0; a < 3; ++a)
        {
            const int up = n >> a & 1;
            s[a] = min(low[a] + up, lattice.count[a] - 1);
            part *= up ? upper[a] : 1 - upper[a];
        }
        boxes.emplace_back(lattice.number(s), part);
        found += part * held.whole[boxes.back().first][0];
    }
    if (found < 0.05) return {}; // no mesh there
    for (auto& box : boxes) box.second /= found;
    return boxes;
}

/// What the cells of this rank take of each box's mass: what they hold of it, and what is mirrored to them.
std::vector<LatticeCells::Share> sharesOf(const fvMesh& mesh, const Lattice& lattice, const Contents& held,
                                          scalar reach)
{
    std::vector<LatticeCells::Share> shares;
    const auto share = [&](label box, label from, scalar part)
    {
        const auto cells = held.cells.find(from);
        if (cells == held.cells.end()) return;
        for (const auto& [cell, piece] : cells->second) shares.push_back({box, cell, part * piece});
    };
    const triSurface surface = boundary(mesh);
    const triSurfaceSearch search(surface);
    const vector span = vector::uniform(2 * reach + cmptMax(lattice.spacing));
    for (label box = 0; box < label(held.whole.size()); ++box)
    {
        const auto& [part, x, y, z] = held.whole[box];
        const scalar beyond = 1 - part;
        share(box, box, beyond < 0 ? 1 / part : 1);
        if (beyond < 1e-9) continue;
        const Slot s = lattice.slot(box);
        point out = (lattice.centre(s) - vector(x, y, z)) / beyond; // centre of what is not mesh
        for (int a = 0; a < 3; ++a) out[a] = std::clamp(out[a], lattice.face(a, s[a]), lattice.face(a, s[a] + 1));
        const pointIndexHit wall = search.nearest(out, span);
        if (!wall.hit()) continue;
        for (const auto& [other, piece] : boxesAbout(2 * wall.hitPoint() - out, lattice, held))
            share(box, other, beyond * piece);
    }
    return shares;
}

} // namespace

std::unique_ptr<const Cells> latticeOver(const fvMesh& mesh, int perCell, double reach)
{
    const Lattice lattice = makeLattice(mesh, perCell, reach);
    const Contents held = cutCells(mesh, lattice);
    std::vector<LatticeCells::Share> shares = sharesOf(mesh, lattice, held, reach);
    if (shares.empty()) return std::make_unique<BoxCells>(std::vector<Box>(), Box{});

    // the part of the lattice that has shares here
    Slot first = lattice.count, last{{-1, -1, -1}};
    for (const auto& e : shares)
        for (int a = 0; a < 3; ++a)
        {
            first[a] = min(first[a], lattice.slot(e.box)[a]);
            last[a] = max(last[a], lattice.slot(e.box)[a]);
        }
    std::array<std::vector<double>, 3> face;
    Slot count;
    for (int a = 0; a < 3; ++a)
    {
        count[a] = last[a] - first[a] + 1;
        for (int i = first[a]; i <= last[a] + 1; ++i) face[a].push_back(lattice.face(a, i));
    }
    const auto number = [&](label box)
    {
        const Slot s = lattice.slot(box);
        return ((s[2] - first[2]) * count[1] + s[1] - first[1]) * count[0] + s[0] - first[0];
    };
    std::vector<char> inside(std::size_t(count[0]) * count[1] * count[2], 0);
    for (const auto& cells : held.cells) inside[number(cells.first)] = 1;
    for (auto& e : shares) e.box = number(e.box);
    return std::make_unique<LatticeCells>(int(mesh.nCells()), face, std::move(shares), std::move(inside));
}

} // namespace hotbed
