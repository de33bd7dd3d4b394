#include "box_weights.hpp"

#include "deen_kernel.hpp"
#include "vectorised.hpp"

#include <algorithm>
#include <stdexcept>

namespace hotbed
{
namespace
{

constexpr int group = BoxWeights::group, lanes = BoxWeights::lanes;

/// values of `lanes` particles, in registers
using Lanes = double __attribute__((vector_size(lanes * sizeof(double)), may_alias));
using Counts = int __attribute__((vector_size(lanes * sizeof(int)), may_alias));

/// A group of particles along one axis.
struct AxisGroup
{
    alignas(64) double x[group];
    alignas(64) int first[group], count[group]; ///< lattice intervals that are reached
    alignas(64) double total[group];            ///< kernel mass in them
};

/// Sets `first` and `count`. @return the most of any particle
inline int reach(const BoxAxis& axis, const double* halfWidth, AxisGroup& g)
{
    const double front = axis.face.front(), back = axis.face.back(), last = double(axis.face.size()) - 2;
    const auto interval = [&](double x)
    {
        const double i =
            (x - axis.origin) * axis.inverseSpacing; // off by round-off at a face, where nothing is to have
        return int(i > 0 ? (i < last ? i : last) : 0);
    };
    int most = 0;
#pragma omp simd reduction(max : most)
    for (int i = 0; i < group; ++i)
    {
        const double low = g.x[i] - halfWidth[i], high = g.x[i] + halfWidth[i];
        g.first[i] = interval(low);
        g.count[i] = (high > front) & (low < back) ? interval(high) - g.first[i] + 1 : 0;
        most = g.count[i] > most ? g.count[i] : most;
    }
    if (axis.uniform) return most;
    for (int i = 0; i < group; ++i)
    {
        g.first[i] = axis.interval(g.x[i] - halfWidth[i]);
        if (g.count[i] > 0) g.count[i] = axis.interval(g.x[i] + halfWidth[i]) - g.first[i] + 1;
    }
    return *std::max_element(g.count, g.count + group);
}

/// Faces of a lattice axis, the last one for any number beyond it.
inline Lanes faces(const BoxAxis& axis, Counts number)
{
    const Counts last = Counts{} + int(axis.face.size() - 1);
    number = number < last ? number : last;
    if (axis.uniform) return axis.origin + axis.spacing * __builtin_convertvector(number, Lanes);
    Lanes x;
    for (int i = 0; i < lanes; ++i) x[i] = axis.face[std::size_t(number[i])];
    return x;
}

/// Sets masses, or adds to them, as differences of `below`, the kernel mass below a face.
/// @param mass  [most][lanes]
/// @return their sums
template <bool add, class Below>
inline Lanes putMasses(const BoxAxis& axis, Counts first, int most, Lanes* mass, Below&& below)
{
    const Lanes begin = below(faces(axis, first));
    Lanes lower = begin;
    for (int k = 0; k < most; ++k)
    {
        const Lanes upper = below(faces(axis, first + (k + 1)));
        mass[k] = add ? mass[k] + (upper - lower) : upper - lower;
        lower = upper;
    }
    return lower - begin;
}

/// Masses along one axis.
/// @param mass    of the first particles in the first interval
/// @param stride  from their masses to those of the next in a register
inline void putAllMasses(const BoxAxis& axis, const double* halfWidth, int most, AxisGroup& g, double* mass, int stride)
{
    for (int r = 0; r < group; r += lanes, mass += stride)
    {
        const Lanes x = *reinterpret_cast<const Lanes*>(g.x + r), n = *reinterpret_cast<const Lanes*>(halfWidth + r);
        const Counts first = *reinterpret_cast<const Counts*>(g.first + r);
        const Lanes inverse = 1.0 / n;
        auto* to = reinterpret_cast<Lanes*>(mass);
        Lanes total =
            putMasses<false>(axis, first, most, to, [&](Lanes face) { return deenMassBelow((face - x) * inverse); });
        for (int side = 0; axis.folded && side < 2; ++side)
        {
            const double wall = axis.wall[std::size_t(side)];
            bool reached = false;
            for (int i = 0; i < lanes; ++i) reached |= side ? x[i] + n[i] > wall : x[i] - n[i] < wall;
            if (reached) // and back into the domain
                total += putMasses<true>(axis, first, most, to,
                                         [&](Lanes face) { return deenMassBelow((face + x - 2.0 * wall) * inverse); });
        }
        *reinterpret_cast<Lanes*>(g.total + r) = total;
    }
}

HOTBED_VECTORISED void appendAll(const std::array<BoxAxis, 3>& axis, int count, const double (*position)[3],
                                 const double* halfWidth, BoxWeights& weights, double* mass, double* centre)
{
    const std::size_t before = weights.particle.size();
    if (before % group != 0) throw std::logic_error("box weights: more particles after a group that is not full");
    weights.particle.resize(before + std::size_t(count));
    AxisGroup along[3];
    alignas(64) double n[group], within[group];
    for (int begin = 0; begin < count; begin += group)
    {
        const int some = std::min(group, count - begin);
        for (int i = 0; i < some; ++i)
        {
            for (int a = 0; a < 3; ++a) along[a].x[i] = position[begin + i][a];
            n[i] = halfWidth[begin + i];
        }
        for (int i = some; i < group; ++i) // the last group is filled up with its last particle
        {
            for (int a = 0; a < 3; ++a) along[a].x[i] = along[a].x[some - 1];
            n[i] = n[some - 1];
        }
        int most[3];
        std::fill_n(within, group, 1.0);
        for (int a = 0; a < 3; ++a)
        {
            most[a] = reach(axis[a], n, along[a]);
            const double front = axis[a].face.front(), back = axis[a].face.back();
            for (int i = 0; i < group; ++i)
                within[i] = (along[a].x[i] >= front) & (along[a].x[i] <= back) ? within[i] : 0.0;
        }
        const int y = most[0], z = y + most[1], end = z + most[2], begins[3] = {0, y, z};
        double* to = weights.room({0, y, z, end});
        for (int a = 0; a < 3; ++a) putAllMasses(axis[a], n, most[a], along[a], to + begins[a] * lanes, end * lanes);
        BoxWeights::Particle* __restrict p = &weights.particle[before + std::size_t(begin)];
        const int row = weights.nx, layer = weights.nxy;
#pragma omp simd
        for (int i = 0; i < some; ++i)
        {
            const int nx = along[0].count[i], ny = along[1].count[i], nz = along[2].count[i];
            const int reached = (nx > 0) & (ny > 0) & (nz > 0);
            p[i].slot = along[0].first[i] + along[1].first[i] * row + along[2].first[i] * layer;
            p[i].count[0] = reached ? nx : 0;
            p[i].count[1] = reached ? ny : 0;
            p[i].count[2] = reached ? nz : 0;
            centre[begin + i] = within[i];
            mass[begin + i] = reached ? along[0].total[i] * along[1].total[i] * along[2].total[i] : 0.0;
        }
    }
}

/// where each slot's number is its cell's
struct AllSlots
{
    int cell(int slot) const { return slot; }
    static constexpr bool has(int) { return true; }
};

/// where cells have other numbers, or some slots none
struct SomeSlots
{
    const int* cellOf;
    int cell(int slot) const { return cellOf[slot]; }
    static bool has(int cell) { return cell >= 0; }
};

/// visit(first slot, number of slots, their weights along x, weight of the row) for every row that a particle reaches.
/// @tparam length  of the rows, 0 where it is only known now
template <int length, class Visit> inline void forEachRowOf(const BoxWeights& weights, int particle, Visit&& visit)
{
    const BoxWeights::Particle& p = weights.particle[std::size_t(particle)];
    const BoxWeights::Rows& rows = weights.rows[std::size_t(particle) / group];
    const double* x = weights.row.data() + rows.begin + particle % group / lanes * lanes * rows.end + particle % lanes;
    const double *y = x + rows.y * lanes, *z = x + rows.z * lanes;
    if constexpr (length > 0)
    {
        double along[length]; // what is added to cells could be these, for all that the compiler knows
        for (int i = 0; i < length; ++i) along[i] = x[i * lanes];
        for (int k = 0; k < p.count[2]; ++k)
            for (int j = 0; j < p.count[1]; ++j)
                visit(
                    p.slot + j * weights.nx + k * weights.nxy, length, [&](int i) { return along[i]; },
                    y[j * lanes] * z[k * lanes]);
    }
    else
        for (int k = 0; k < p.count[2]; ++k)
            for (int j = 0; j < p.count[1]; ++j)
                visit(
                    p.slot + j * weights.nx + k * weights.nxy, p.count[0], [&](int i) { return x[i * lanes]; },
                    y[j * lanes] * z[k * lanes]);
}

/// The same, unrolled for the usual lengths.
template <class Visit> inline void forEachRow(const BoxWeights& weights, int particle, Visit&& visit)
{
    switch (weights.particle[std::size_t(particle)].count[0])
    {
    case 2:
        return forEachRowOf<2>(weights, particle, visit);
    case 3:
        return forEachRowOf<3>(weights, particle, visit);
    case 4:
        return forEachRowOf<4>(weights, particle, visit);
    default:
        return forEachRowOf<0>(weights, particle, visit);
    }
}

/// the values of a particle or a cell, as one register where the processor has such
using Values1 = double;
using Values2 = double __attribute__((vector_size(16), aligned(8), may_alias));
using Values4 = double __attribute__((vector_size(32), aligned(8), may_alias));
using Values8 = double __attribute__((vector_size(64), aligned(8), may_alias));

/// two registers
struct Values12
{
    Values8 low;
    Values4 high;
};

struct Values16
{
    Values8 low, high;
};

template <class Values, class = decltype(Values::low)> inline Values& operator+=(Values& sum, const Values& values)
{
    sum.low += values.low;
    sum.high += values.high;
    return sum;
}

template <class Values, class = decltype(Values::low)> inline Values operator*(double factor, const Values& values)
{
    return {factor * values.low, factor * values.high};
}

template <class Values, class Slots>
inline void interpolateFields(const BoxWeights& weights, Slots slots, int first, int count, const double* cells,
                              double* result)
{
    for (int n = first; n < first + count; ++n)
    {
        Values sum = {};
        forEachRow(weights, n,
                   [&](int slot, int length, auto x, double yz)
                   {
                       Values row = {};
                       for (int i = 0; i < length; ++i)
                       {
                           const int cell = slots.cell(slot + i);
                           if (slots.has(cell)) row += x(i) * reinterpret_cast<const Values*>(cells)[cell];
                       }
                       sum += yz * row;
                   });
        *reinterpret_cast<Values*>(result) = sum;
        result += sizeof(Values) / sizeof(double);
    }
}

template <class Values, class Slots>
inline void depositFields(const BoxWeights& weights, Slots slots, int first, int count, const double* particles,
                          double* cells)
{
    for (int n = first; n < first + count; ++n)
    {
        const Values value = *reinterpret_cast<const Values*>(particles);
        forEachRow(weights, n,
                   [&](int slot, int length, auto x, double yz)
                   {
                       const Values row = yz * value;
                       for (int i = 0; i < length; ++i)
                       {
                           const int cell = slots.cell(slot + i);
                           if (slots.has(cell)) reinterpret_cast<Values*>(cells)[cell] += x(i) * row;
                       }
                   });
        particles += sizeof(Values) / sizeof(double);
    }
}

} // namespace

int BoxAxis::interval(double x) const
{
    const int last = int(face.size()) - 2;
    if (uniform)
    {
        int i = int(std::clamp((x - origin) * inverseSpacing, 0.0, double(last)));
        // the quotient is rounded; the faces decide
        if (i > 0 && x < face[i]) --i;
        if (i < last && x >= face[i + 1]) ++i;
        return i;
    }
    const int above = int(std::upper_bound(face.begin(), face.end(), x) - face.begin());
    return std::clamp(above - 1, 0, last);
}

void BoxWeights::clear()
{
    particle.clear();
    rows.clear();
    rowEnd = 0;
}

void BoxWeights::append(const std::array<BoxAxis, 3>& axis, int count, const double (*position)[3],
                        const double* halfWidth, double* mass, double* centre)
{
    appendAll(axis, count, position, halfWidth, *this, mass, centre);
}

double* BoxWeights::room(Rows more)
{
    more.begin = rowEnd;
    rows.push_back(more);
    rowEnd += std::size_t(more.end) * group;
    if (row.size() < rowEnd) row.resize(2 * rowEnd);
    return row.data() + more.begin;
}

HOTBED_VECTORISED void BoxWeights::scale(int first, int count, const double* factor)
{
    while (count > 0)
    {
        const Rows& r = rows[std::size_t(first) / group];
        double* x = row.data() + r.begin + first % group / lanes * lanes * r.end;
        const int lane = first % lanes, some = std::min(lanes - lane, count);
        for (int k = 0; k < r.y; ++k)
            for (int i = 0; i < some; ++i) x[k * lanes + lane + i] *= factor[i];
        first += some;
        factor += some;
        count -= some;
    }
}

double BoxWeights::mass(int particle) const
{
    double sum = 0.0;
    forEachRow(*this, particle,
               [&](int slot, int length, auto x, double yz)
               {
                   for (int i = 0; i < length; ++i)
                       if (!cellOf || cellOf[slot + i] >= 0) sum += x(i) * yz;
               });
    return sum;
}

namespace
{

/// work(values, slots), their types chosen by the number of fields and by whether slots and cells have the same numbers
template <class Work> inline void choose(int fields, const BoxWeights& weights, Work&& work)
{
    const auto withSlots = [&](auto values)
    {
        if (weights.cellOf)
            work(values, SomeSlots{weights.cellOf});
        else
            work(values, AllSlots{});
    };
    if (fields == 1) return withSlots(Values1{});
    if (fields == 2) return withSlots(Values2{});
    if (fields == 4) return withSlots(Values4{});
    if (fields == 8) return withSlots(Values8{});
    if (fields == 12) return withSlots(Values12{});
    if (fields == 16) return withSlots(Values16{});
    throw std::invalid_argument("interpolate, deposit: 1, 2, 4, 8, 12 or 16 fields at a time");
}

} // namespace

HOTBED_VECTORISED void interpolate(int fields, const BoxWeights& weights, int first, int count, const double* cells,
                                   double* result)
{
    choose(fields, weights,
           [&](auto values, auto slots)
           { interpolateFields<decltype(values)>(weights, slots, first, count, cells, result); });
}

HOTBED_VECTORISED void deposit(int fields, const BoxWeights& weights, int first, int count, const double* particles,
                               double* cells)
{
    choose(fields, weights,
           [&](auto values, auto slots)
           { depositFields<decltype(values)>(weights, slots, first, count, particles, cells); });
}

} // namespace hotbed
