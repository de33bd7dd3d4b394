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
    if (boxes > 2e8)
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

} // namespace

std::unique_ptr<const Cells> latticeOver(const fvMesh& mesh, int perCell, double reach)
{
    const Lattice lattice = makeLattice(mesh, perCell, reach);
    const scalar whole = lattice.volume();

    // what each box holds of each cell here; of the whole mesh: volume and its first moment
    std::map<label, std::map<label, scalar>> held; // box -> cell -> part of the box
    std::vector<double> content(std::size_t(lattice.count[0]) * lattice.count[1] * lattice.count[2] * 4, 0.0);
    for (label c = 0; c < mesh.nCells(); ++c)
        for (const tetIndices& indices : polyMeshTetDecomposition::cellTetIndices(mesh, c))
        {
            const tetPointRef tet = indices.tet(mesh);
            Slot slot{};
            cut(lattice, 0, slot, tetPoints(tet.a(), tet.b(), tet.c(), tet.d()),
                [&](const Slot& s, const tetPoints& piece)
                {
                    const tetPointRef t = piece.tet();
                    const scalar volume = t.mag() / whole;
                    if (!(volume > 1e-12)) return;
                    const label box = lattice.number(s);
                    held[box][c] += volume;
                    const point centre = t.centre();
                    double* sum = &content[std::size_t(box) * 4];
                    sum[0] += volume;
                    for (int a = 0; a < 3; ++a) sum[1 + a] += volume * centre[a];
                });
        }
    MPI_Allreduce(MPI_IN_PLACE, content.data(), int(content.size()), MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);

    std::vector<LatticeCells::Share> shares;
    const auto share = [&](label box, label from, scalar part)
    {
        const auto cells = held.find(from);
        if (cells == held.end()) return;
        for (const auto& [cell, piece] : cells->second) shares.push_back({box, cell, part * piece});
    };
    const triSurface surface = boundary(mesh);
    const triSurfaceSearch search(surface);
    Slot s;
    for (s[2] = 0; s[2] < lattice.count[2]; ++s[2])
        for (s[1] = 0; s[1] < lattice.count[1]; ++s[1])
            for (s[0] = 0; s[0] < lattice.count[0]; ++s[0])
            {
                const label box = lattice.number(s);
                const double* sum = &content[std::size_t(box) * 4];
                const scalar beyond = 1 - sum[0];
                share(box, box, beyond < 0 ? 1 / sum[0] : 1);
                if (beyond < 1e-9) continue;
                // mirrored at the wall the rest is a box across up to eight others
                point out = (lattice.centre(s) - vector(sum[1], sum[2], sum[3])) / beyond;
                for (int a = 0; a < 3; ++a)
                    out[a] = std::clamp(out[a], lattice.face(a, s[a]), lattice.face(a, s[a] + 1));
                const pointIndexHit wall = search.nearest(out, vector::uniform(2 * reach + cmptMax(lattice.spacing)));
                if (!wall.hit()) continue;
                const point mirrored = 2 * wall.hitPoint() - out;
                Slot low;
                vector upper; // part that is in the higher box along each axis
                for (int a = 0; a < 3; ++a)
                {
                    const scalar at = std::clamp(lattice.boxes(a, mirrored[a]) - 0.5, 0.0, lattice.count[a] - 1.0);
                    low[a] = min(int(at), max(0, lattice.count[a] - 2));
                    upper[a] = at - low[a];
                }
                std::array<label, 8> boxes;
                std::array<scalar, 8> parts;
                scalar found = 0;
                for (int n = 0; n < 8; ++n)
                {
                    Slot t;
                    parts[n] = 1;
                    for (int a = 0; a < 3; ++a)
                    {
                        const int up = n >> a & 1;
                        t[a] = min(low[a] + up, lattice.count[a] - 1);
                        parts[n] *= up ? upper[a] : 1 - upper[a];
                    }
                    boxes[n] = lattice.number(t);
                    found += parts[n] * content[std::size_t(boxes[n]) * 4];
                }
                if (found < 0.05) continue; // no mesh there
                for (int n = 0; n < 8; ++n) share(box, boxes[n], beyond * parts[n] / found);
            }

    // the part of the lattice that has shares here
    Slot first = lattice.count, last{{-1, -1, -1}};
    const auto slotOf = [&](label box)
    {
        return Slot{{box % lattice.count[0], box / lattice.count[0] % lattice.count[1],
                     box / lattice.count[0] / lattice.count[1]}};
    };
    for (const auto& e : shares)
    {
        const Slot at = slotOf(e.box);
        for (int a = 0; a < 3; ++a)
        {
            first[a] = min(first[a], at[a]);
            last[a] = max(last[a], at[a]);
        }
    }
    if (shares.empty()) return std::make_unique<BoxCells>(std::vector<Box>(), Box{});
    std::array<std::vector<double>, 3> face;
    for (int a = 0; a < 3; ++a)
        for (int i = first[a]; i <= last[a] + 1; ++i) face[a].push_back(lattice.face(a, i));
    const auto number = [&](label box)
    {
        const Slot at = slotOf(box);
        return ((at[2] - first[2]) * int(face[1].size() - 1) + at[1] - first[1]) * int(face[0].size() - 1) + at[0] -
               first[0];
    };
    std::vector<char> inside((face[0].size() - 1) * (face[1].size() - 1) * (face[2].size() - 1), 0);
    for (const auto& cells : held) inside[number(cells.first)] = 1;
    for (auto& e : shares) e.box = number(e.box);
    return std::make_unique<LatticeCells>(int(mesh.nCells()), face, std::move(shares), std::move(inside));
}

} // namespace hotbed
