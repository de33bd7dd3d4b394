#include "box_weights.hpp"

#include "deen_kernel.hpp"
#include "registers.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace hotbed
{
namespace
{

constexpr int group = BoxWeights::group, lanes = BoxWeights::lanes;

/// A group of particles along one axis.
struct AxisGroup
{
    alignas(64) double x[group];
    alignas(64) int first[group], count[group]; ///< lattice intervals that are reached
    alignas(64) unsigned char beyond[group];    ///< where folded: whether a wall is reached, 1 the low one, 2 the high
    alignas(64) double total[group];            ///< kernel mass in the intervals
};

/// Sets `first`, `count` and `beyond`. @return the most intervals of any particle
inline int reach(const BoxAxis& axis, const double* halfWidth, AxisGroup& g)
{
    const double front = axis.face.front(), back = axis.face.back(), last = double(axis.face.size()) - 2;
    const double lowWall = axis.wall[0], highWall = axis.wall[1];
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
    for (int i = 0; axis.folded && i < group; ++i)
        g.beyond[i] = (unsigned char)((g.x[i] - halfWidth[i] < lowWall) + 2 * (g.x[i] + halfWidth[i] > highWall));
    if (axis.uniform) return most;
    for (int i = 0; i < group; ++i)
    {
        g.first[i] = axis.interval(g.x[i] - halfWidth[i]);
        if (g.count[i] > 0) g.count[i] = axis.interval(g.x[i] + halfWidth[i]) - g.first[i] + 1;
    }
    return *std::max_element(g.count, g.count + group);
}

/// The faces of intervals from some on, as particles see them: (face + shift) * scale. Those behind the last one are
/// where that is, so that no mass lies between them.
template <class Registers> class Faces
{
    using Lanes = typename Registers::Lanes;
    using Counts = typename Registers::Counts;

public:
    Faces(const BoxAxis& axis, Counts first, Lanes shift, Lanes scale)
        : axis_(axis), first_(first), shift_(shift), scale_(scale)
    {
        begin_ = (axis.origin + axis.spacing * __builtin_convertvector(first, Lanes) + shift) * scale;
        step_ = axis.spacing * scale;
        end_ = (axis.face.back() + shift) * scale;
    }

    Lanes operator[](int k) const
    {
        if (axis_.uniform)
        {
            const Lanes x = begin_ + double(k) * step_;
            return x < end_ ? x : end_;
        }
        Lanes x;
        for (int i = 0; i < Registers::width; ++i)
            x[i] = axis_.face[std::min(std::size_t(first_[i] + k), axis_.face.size() - 1)];
        return (x + shift_) * scale_;
    }

private:
    const BoxAxis& axis_;
    Counts first_;
    Lanes shift_, scale_, begin_, step_, end_;
};

/// Sets the masses between faces, or adds to them.
/// @param mass  [most][lanes], of the first particle
/// @param next  from there to where those of the next group are likely to be put
/// @return their sums
template <bool add, class Registers>
inline typename Registers::Lanes putMasses(const Faces<Registers>& face, int most, double* mass, int next)
{
    using Lanes = typename Registers::Lanes;
    const Lanes begin = deenMassBelow(face[0]);
    Lanes lower = begin;
    for (int k = 0; k < most; ++k, mass += lanes)
    {
        const Lanes upper = deenMassBelow(face[k + 1]);
        if (!add) __builtin_prefetch(mass + next, 1); // rows that are only written wait for the memory, too
        auto& to = *reinterpret_cast<Lanes*>(mass);
        to = add ? to + (upper - lower) : upper - lower;
        lower = upper;
    }
    return lower - begin;
}

/// Masses along one axis.
/// @param inverse  of the half widths
/// @param mass     of the first particles in the first interval
/// @param stride   from their masses to those of the next `lanes` ones
template <class Registers>
inline void putAllMasses(const BoxAxis& axis, const double* inverse, int most, AxisGroup& g, double* mass, int stride)
{
    using Lanes = typename Registers::Lanes;
    constexpr int width = Registers::width;
    for (int r = 0; r < group; r += width)
    {
        const Lanes x = *reinterpret_cast<const Lanes*>(g.x + r), scale = *reinterpret_cast<const Lanes*>(inverse + r);
        const auto first = *reinterpret_cast<const typename Registers::Counts*>(g.first + r);
        double* to = mass + r / lanes * stride + r % lanes;
        Lanes total = putMasses<false>(Faces<Registers>(axis, first, -x, scale), most, to, stride * (group / lanes));
        std::uint64_t beyond = 0;
        if (axis.folded) std::memcpy(&beyond, g.beyond + r, width);
        for (int side = 0; beyond && side < 2; ++side)
            if (beyond & (0x0101010101010101u << side)) // and back into the domain
                total += putMasses<true>(Faces<Registers>(axis, first, x - 2.0 * axis.wall[std::size_t(side)], scale),
                                         most, to, 0);
        *reinterpret_cast<Lanes*>(g.total + r) = total;
    }
}

/// Numbers of a group, where there may be less of them: compilers make slow string instructions of a plain copy.
template <class Registers> inline void copy(const double* from, int count, double* to)
{
    using Eight = typename Registers::Eight;
    int i = 0;
    for (; i + 8 <= count; i += 8) *reinterpret_cast<Eight*>(to + i) = *reinterpret_cast<const Eight*>(from + i);
    for (; i < count; ++i) to[i] = from[i];
}

/// @param inside  null: `append`; else `appendShares`, with what is elsewhere in `mass` and `centre`
template <class Registers>
inline void appendAll(const std::array<BoxAxis, 3>& axis, int count, const double (*position)[3],
                      const double* halfWidth, BoxWeights& weights, double* mass, double* centre, char* inside)
{
    using Lanes = typename Registers::Lanes;
    constexpr int width = Registers::width;
    if (weights.particles % group != 0)
        throw std::logic_error("box weights: more particles after a group that is not full");
    BoxWeights::Particle* p = weights.room(count);
    AxisGroup along[3];
    alignas(64) double n[group], inverse[group], within[group], masses[group];
    for (int begin = 0; begin < count; begin += group, p += group)
    {
        const int some = std::min(group, count - begin);
        for (int i = 0; i < some; ++i)
        {
            __builtin_prefetch(position[begin + i + group]); // of the next group, in time
            for (int a = 0; a < 3; ++a) along[a].x[i] = position[begin + i][a];
        }
        copy<Registers>(halfWidth + begin, some, n);
        for (int i = some; i < group; ++i) // the last group is filled up with its last particle
        {
            for (int a = 0; a < 3; ++a) along[a].x[i] = along[a].x[some - 1];
            n[i] = n[some - 1];
        }
        for (int i = 0; i < group; ++i) inverse[i] = 1.0 / n[i];
        int most[3];
        std::fill_n(within, group, 1.0);
        std::fill_n(masses, group, 1.0);
        for (int a = 0; a < 3; ++a)
        {
            most[a] = reach(axis[a], n, along[a]);
            const double front = axis[a].face.front(), back = axis[a].face.back();
            for (int i = 0; i < group; ++i)
                within[i] = (along[a].x[i] >= front) & (along[a].x[i] <= back) ? within[i] : 0.0;
        }
        const int y = most[0], z = y + most[1], end = z + most[2], begins[3] = {0, y, z};
        double* to = weights.room({0, y, z, end});
        for (int a = 0; a < 3; ++a)
            putAllMasses<Registers>(axis[a], inverse, most[a], along[a], to + begins[a] * lanes, end * lanes);
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
            masses[i] = reached ? along[0].total[i] * along[1].total[i] * along[2].total[i] : 0.0;
        }
        if (inside)
        {
            // two loops: in one, compilers divide by both sides of a choice, also by zero, and OpenFOAM traps that
            for (int i = 0; i < some; ++i)
            {
                const double total = masses[i] + mass[begin + i];
                const bool in = isInside(total, centre[begin + i] += within[i]);
                inside[begin + i] = in;
                within[i] = in ? 1.0 : 0.0;
                masses[i] = in ? total : 1.0;
            }
            for (int i = 0; i < group; ++i) masses[i] = within[i] / masses[i];
            copy<Registers>(masses, some, mass + begin);
            for (int r = 0; r < group; r += width)
                for (int k = 0; k < most[0]; ++k)
                    *reinterpret_cast<Lanes*>(to + (r / lanes * end + k) * lanes + r % lanes) *=
                        *reinterpret_cast<const Lanes*>(masses + r);
            continue;
        }
        copy<Registers>(masses, some, mass + begin);
        copy<Registers>(within, some, centre + begin);
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

/// A particle's weights: of its cell (i, j, k) x[i lanes] y[j lanes] z[k lanes].
struct Product
{
    const double *x, *y, *z;
};

/// Weights along an axis: in registers where their number is a constant.
template <class Number> class Few
{
public:
    Few(const double* weights, Number) : weights_(weights) {}
    double operator[](int i) const { return weights_[i * lanes]; }

private:
    const double* weights_;
};

template <int n> class Few<std::integral_constant<int, n>>
{
public:
    Few(const double* weights, std::integral_constant<int, n>)
    {
        for (int i = 0; i < n; ++i) weights_[i] = weights[i * lanes];
    }
    double operator[](int i) const { return weights_[i]; }

private:
    double weights_[n];
};

/// visit(particle, its weights) for `count` particles from the first one on
template <class Visit> inline void forEach(const BoxWeights& weights, int first, int count, Visit&& visit)
{
    for (const int end = first + count; first < end;)
    {
        const BoxWeights::Rows& rows = weights.rows[std::size_t(first) / group];
        const double* x = weights.row.data() + rows.begin + first % group / lanes * lanes * rows.end;
        int lane = first % lanes;
        for (int k = 0; k < rows.end; ++k) __builtin_prefetch(x + (4 * rows.end + k) * lanes); // of those to come
        for (const int stop = std::min(lanes, lane + end - first); lane < stop; ++lane, ++first)
            visit(weights.particle[std::size_t(first)],
                  Product{x + lane, x + lane + rows.y * lanes, x + lane + rows.z * lanes});
    }
}

/// Calls work(cells along x, cells along y) with the numbers of a particle, as constants where these are usual ones, so
/// that loops over them are written out: else what there is to be done apart from the sums takes most of the time.
template <class Slots, class Work> inline void withCounts(const BoxWeights::Particle& p, Work&& work)
{
    const auto withY = [&](auto nx)
    {
        if (p.count[1] == 2) return work(nx, std::integral_constant<int, 2>{});
        if (p.count[1] == 3) return work(nx, std::integral_constant<int, 3>{});
        work(nx, std::integral_constant<int, 4>{});
    };
    if constexpr (std::is_same_v<Slots, AllSlots>)
        if (p.count[1] >= 2 && p.count[1] <= 4)
        {
            if (p.count[0] == 2) return withY(std::integral_constant<int, 2>{});
            if (p.count[0] == 3) return withY(std::integral_constant<int, 3>{});
            if (p.count[0] == 4) return withY(std::integral_constant<int, 4>{});
        }
    work(p.count[0], p.count[1]);
}

template <class Value, class Slots>
inline void interpolateFields(const BoxWeights& weights, Slots slots, int first, int count, const double* cells,
                              double* result)
{
    const auto* values = reinterpret_cast<const Value*>(cells);
    const int row = weights.nx, layer = weights.nxy;
    const auto of = [&](const BoxWeights::Particle& p, const Product& w)
    {
        withCounts<Slots>(p,
                          [&](auto nx, auto ny)
                          {
                              const Few x(w.x, nx), y(w.y, ny);
                              Value sum = {};
                              for (int k = 0, slot = p.slot; k < p.count[2]; ++k, slot += layer)
                              {
                                  Value plane = {};
                                  for (int j = 0; j < ny; ++j)
                                  {
                                      Value line = {};
                                      for (int i = 0; i < nx; ++i)
                                      {
                                          const int cell = slots.cell(slot + j * row + i);
                                          if (slots.has(cell)) line += x[i] * values[cell];
                                      }
                                      plane += y[j] * line;
                                  }
                                  sum += w.z[k * lanes] * plane;
                              }
                              *reinterpret_cast<Value*>(result) = sum;
                          });
        result += sizeof(Value) / sizeof(double);
    };
    forEach(weights, first, count, of);
}

template <class Value, class Slots>
inline void depositFields(const BoxWeights& weights, Slots slots, int first, int count, const double* particles,
                          double* cells)
{
    auto* sums = reinterpret_cast<Value*>(cells);
    const int row = weights.nx, layer = weights.nxy;
    const auto of = [&](const BoxWeights::Particle& p, const Product& w)
    {
        const Value value = *reinterpret_cast<const Value*>(particles);
        withCounts<Slots>(p,
                          [&](auto nx, auto ny)
                          {
                              const Few x(w.x, nx), y(w.y, ny);
                              for (int k = 0, slot = p.slot; k < p.count[2]; ++k, slot += layer)
                              {
                                  const Value plane = w.z[k * lanes] * value;
                                  for (int j = 0; j < ny; ++j)
                                  {
                                      const Value line = y[j] * plane;
                                      for (int i = 0; i < nx; ++i)
                                      {
                                          const int cell = slots.cell(slot + j * row + i);
                                          if (slots.has(cell)) sums[cell] += x[i] * line;
                                      }
                                  }
                              }
                          });
        particles += sizeof(Value) / sizeof(double);
    };
    forEach(weights, first, count, of);
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
    particles = 0;
    rows.clear();
    rowEnd = 0;
}

void BoxWeights::append(const std::array<BoxAxis, 3>& axis, int count, const double (*position)[3],
                        const double* halfWidth, double* mass, double* centre)
{
    appendShares(axis, count, position, halfWidth, mass, centre, nullptr);
}

void BoxWeights::appendShares(const std::array<BoxAxis, 3>& axis, int count, const double (*position)[3],
                              const double* halfWidth, double* mass, double* centre, char* inside)
{
    withRegisters([&](auto registers)
                  { appendAll<decltype(registers)>(axis, count, position, halfWidth, *this, mass, centre, inside); });
}

BoxWeights::Particle* BoxWeights::room(int more)
{
    const int first = particles;
    particles += more;
    if (int(particle.size()) < particles) particle.resize(std::size_t(particles));
    return particle.data() + first;
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

double BoxWeights::mass(int which) const
{
    double sum = 0.0;
    forEach(*this, which, 1,
            [&](const Particle& p, const Product& w)
            {
                for (int k = 0; k < p.count[2]; ++k)
                    for (int j = 0; j < p.count[1]; ++j)
                        for (int i = 0; i < p.count[0]; ++i)
                            if (!cellOf || cellOf[p.slot + i + j * nx + k * nxy] >= 0)
                                sum += w.x[i * lanes] * w.y[j * lanes] * w.z[k * lanes];
            });
    return sum;
}

namespace
{

/// work(value, slots), their types chosen by the number of fields, by whether slots and cells have the same numbers,
/// and by the processor
template <class Work> inline void choose(int fields, const BoxWeights& weights, const Work& work)
{
    const auto withSlots = [&](auto value)
    {
        if (weights.cellOf)
            work(value, SomeSlots{weights.cellOf});
        else
            work(value, AllSlots{});
    };
    withRegisters(
        [&](auto registers)
        {
            using Registers = decltype(registers);
            if (fields == 1) return withSlots(double{});
            if (fields == 2) return withSlots(Values2{});
            if (fields == 8) return withSlots(typename Registers::Eight{});
            if (fields == 12) return withSlots(typename Registers::Twelve{});
            throw std::invalid_argument("interpolate, deposit: 1, 2, 8 or 12 fields at a time");
        });
}

} // namespace

void interpolate(int fields, const BoxWeights& weights, int first, int count, const double* cells, double* result)
{
    choose(fields, weights,
           [&](auto value, auto slots)
           { interpolateFields<decltype(value)>(weights, slots, first, count, cells, result); });
}

void deposit(int fields, const BoxWeights& weights, int first, int count, const double* particles, double* cells)
{
    choose(fields, weights,
           [&](auto value, auto slots)
           { depositFields<decltype(value)>(weights, slots, first, count, particles, cells); });
}

} // namespace hotbed
