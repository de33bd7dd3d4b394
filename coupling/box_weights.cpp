#include "box_weights.hpp"

#include "deen_kernel.hpp"
#include "vectorised.hpp"

#include <algorithm>
#include <stdexcept>

namespace hotbed
{
namespace
{

constexpr int block = 64; // particles at a time, several in a register, all in the first cache

/// One axis of a block of particles.
struct AxisBlock
{
    alignas(64) double x[block], halfWidth[block];
    int first[block], count[block]; ///< lattice intervals that are reached
    double total[block];            ///< kernel mass in them
    std::vector<double> mass;       ///< [intervals][block]
};

inline void reach(const BoxAxis& axis, AxisBlock& b)
{
    const double front = axis.face.front(), back = axis.face.back(), last = double(axis.face.size()) - 2;
    const auto interval = [&](double x)
    {
        const double i =
            (x - axis.origin) * axis.inverseSpacing; // off by round-off at a face, where nothing is to have
        return int(i > 0 ? (i < last ? i : last) : 0);
    };
#pragma omp simd
    for (int i = 0; i < block; ++i)
    {
        const double low = b.x[i] - b.halfWidth[i], high = b.x[i] + b.halfWidth[i];
        b.first[i] = interval(low);
        b.count[i] = (high > front) & (low < back) ? interval(high) - b.first[i] + 1 : 0;
    }
    if (axis.uniform) return;
    for (int i = 0; i < block; ++i)
    {
        b.first[i] = axis.interval(b.x[i] - b.halfWidth[i]);
        if (b.count[i] > 0) b.count[i] = axis.interval(b.x[i] + b.halfWidth[i]) - b.first[i] + 1;
    }
}

/// Adds masses, as differences of `below`, the kernel mass below a face.
template <class Below> inline void addMasses(const BoxAxis& axis, AxisBlock& b, int most, Below&& below)
{
    const double* face = axis.face.data();
    const int last = int(axis.face.size()) - 1;
    double* mass = b.mass.data();
    alignas(64) double lower[block];
#pragma omp simd
    for (int i = 0; i < block; ++i) lower[i] = below(i, face[b.first[i]]);
    for (int k = 1; k <= most; ++k, mass += block)
#pragma omp simd
        for (int i = 0; i < block; ++i)
        {
            const int next = b.first[i] + k;
            const double upper = below(i, face[next < last ? next : last]);
            mass[i] += upper - lower[i];
            b.total[i] += upper - lower[i];
            lower[i] = upper;
        }
}

inline int axisMasses(const BoxAxis& axis, AxisBlock& b)
{
    reach(axis, b);
    int most = 0, atLowWall = 0, atHighWall = 0;
    alignas(64) double inverse[block];
    for (int i = 0; i < block; ++i)
    {
        inverse[i] = 1.0 / b.halfWidth[i];
        b.total[i] = 0.0;
        most = b.count[i] > most ? b.count[i] : most;
        atLowWall |= b.x[i] - b.halfWidth[i] < axis.wall[0];
        atHighWall |= b.x[i] + b.halfWidth[i] > axis.wall[1];
    }
    b.mass.assign(std::size_t(most) * block, 0.0);
    addMasses(axis, b, most, [&](int i, double face) { return deenMassBelow((face - b.x[i]) * inverse[i]); });
    const auto addMirrored = [&](double wall) // reaches back into the domain
    {
        addMasses(axis, b, most,
                  [&](int i, double face) { return deenMassBelow((face + b.x[i] - 2.0 * wall) * inverse[i]); });
    };
    if (axis.folded && atLowWall) addMirrored(axis.wall[0]);
    if (axis.folded && atHighWall) addMirrored(axis.wall[1]);
    return most;
}

HOTBED_VECTORISED void appendAll(const std::array<BoxAxis, 3>& axis, int count, const double (*particles)[4],
                                 BoxWeights& weights, double (*mass)[2])
{
    const std::size_t before = weights.particle.size();
    weights.particle.resize(before + std::size_t(count));
    AxisBlock along[3];
    std::size_t& end = weights.rowEnd;
    for (int begin = 0; begin < count; begin += block)
    {
        const int n = std::min(block, count - begin);
        std::size_t room = end;
        int most[3];
        for (int a = 0; a < 3; ++a)
        {
            for (int i = 0; i < block; ++i) // the last block is filled up with its last particle
            {
                const double* x = particles[begin + std::min(i, n - 1)];
                along[a].x[i] = x[a];
                along[a].halfWidth[i] = x[3];
            }
            most[a] = axisMasses(axis[a], along[a]);
            room += std::size_t(most[a]) * block;
        }
        if (weights.row.size() < room) weights.row.resize(2 * room);
        double* row = weights.row.data();
        for (int i = 0; i < n; ++i)
        {
            BoxWeights::Particle& p = weights.particle[before + std::size_t(begin + i)];
            p.count = {along[0].count[i], along[1].count[i], along[2].count[i]};
            p.slot = along[0].first[i] + along[1].first[i] * weights.nx + along[2].first[i] * weights.nxy;
            p.row = std::int64_t(end);
            mass[begin + i][0] = along[0].total[i] * along[1].total[i] * along[2].total[i];
            if (p.count[0] == 0 || p.count[1] == 0 || p.count[2] == 0)
            {
                p.count = {0, 0, 0};
                mass[begin + i][0] = 0.0;
            }
            for (int a = 0; a < 3; end += std::size_t(p.count[a++])) // the same number for all, some are overwritten
                for (int k = 0; k < most[a]; ++k) row[end + std::size_t(k)] = along[a].mass[std::size_t(k * block + i)];
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
template <int length, class Visit>
inline void forEachRowOf(const BoxWeights& weights, const BoxWeights::Particle& p, Visit&& visit)
{
    const int n = length ? length : p.count[0];
    const double* x = weights.row.data() + p.row;
    const double* y = x + n;
    const double* z = y + p.count[1];
    for (int k = 0; k < p.count[2]; ++k)
        for (int j = 0; j < p.count[1]; ++j) visit(p.slot + j * weights.nx + k * weights.nxy, n, x, y[j] * z[k]);
}

/// The same, unrolled for the usual lengths.
template <class Visit> inline void forEachRow(const BoxWeights& weights, const BoxWeights::Particle& p, Visit&& visit)
{
    switch (p.count[0])
    {
    case 2:
        return forEachRowOf<2>(weights, p, visit);
    case 3:
        return forEachRowOf<3>(weights, p, visit);
    case 4:
        return forEachRowOf<4>(weights, p, visit);
    default:
        return forEachRowOf<0>(weights, p, visit);
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
        forEachRow(weights, weights.particle[std::size_t(n)],
                   [&](int slot, int length, const double* x, double yz)
                   {
                       Values row = {};
                       for (int i = 0; i < length; ++i)
                       {
                           const int cell = slots.cell(slot + i);
                           if (slots.has(cell)) row += x[i] * reinterpret_cast<const Values*>(cells)[cell];
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
        forEachRow(weights, weights.particle[std::size_t(n)],
                   [&](int slot, int length, const double* x, double yz)
                   {
                       const Values row = yz * value;
                       for (int i = 0; i < length; ++i)
                       {
                           const int cell = slots.cell(slot + i);
                           if (slots.has(cell)) reinterpret_cast<Values*>(cells)[cell] += x[i] * row;
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
    rowEnd = 0;
}

void BoxWeights::append(const std::array<BoxAxis, 3>& axis, int count, const double (*particles)[4], double (*mass)[2])
{
    appendAll(axis, count, particles, *this, mass);
}

double BoxWeights::mass(const Particle& p) const
{
    double sum = 0.0;
    forEachRow(*this, p,
               [&](int slot, int length, const double* x, double yz)
               {
                   for (int i = 0; i < length; ++i)
                       if (!cellOf || cellOf[slot + i] >= 0) sum += x[i] * yz;
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
