#pragma once

/// The law for a batch of contacts, in vector registers. Part of contact_kernel.cpp and wall_kernel.cpp, each of which
/// compiles it for the processors it knows: hence functions of their own.

#include "contact_kernel.hpp"

#include <cmath>
#include <immintrin.h>

namespace hotbed
{
namespace
{

/// Pairs of a batch: its arrays stay in the nearest cache.
constexpr int width = 64;

using Lanes = double[width];
using Wide = double __attribute__((vector_size(64)));
using Index = long long __attribute__((vector_size(32)));

struct Batch
{
    int n = 0;
    int pair[width + 4];
    // x, y, z and a fourth quantity of each pair
    alignas(64) Lanes delta[4] = {};    // sum of radii
    alignas(64) Lanes velocity[4] = {}; // sum of inverse masses
    alignas(64) Lanes spin_i[4] = {};   // radius
    alignas(64) Lanes spin_j[4] = {};
    alignas(64) Lanes normal[4] = {}; // ContactConstants
    alignas(64) Lanes tangential[4] = {};
    alignas(64) Lanes stretch[3] = {};
    alignas(64) Lanes force[4] = {}; // on i; arm of i
    alignas(64) Lanes turn[4] = {};  // force moment an arm; arm of j
};

inline void transpose(Row& a, Row& b, Row& c, Row& d)
{
    const Row ab = __builtin_shuffle(a, b, Index{0, 4, 2, 6}), AB = __builtin_shuffle(a, b, Index{1, 5, 3, 7});
    const Row cd = __builtin_shuffle(c, d, Index{0, 4, 2, 6}), CD = __builtin_shuffle(c, d, Index{1, 5, 3, 7});
    a = __builtin_shuffle(ab, cd, Index{0, 1, 4, 5});
    b = __builtin_shuffle(AB, CD, Index{0, 1, 4, 5});
    c = __builtin_shuffle(ab, cd, Index{2, 3, 6, 7});
    d = __builtin_shuffle(AB, CD, Index{2, 3, 6, 7});
}

/// Four rows into lanes k .. k + 3
inline void put(Lanes* lanes, int k, Row a, Row b, Row c, Row d)
{
    transpose(a, b, c, d);
    *reinterpret_cast<Row*>(&lanes[0][k]) = a;
    *reinterpret_cast<Row*>(&lanes[1][k]) = b;
    *reinterpret_cast<Row*>(&lanes[2][k]) = c;
    *reinterpret_cast<Row*>(&lanes[3][k]) = d;
}

inline void take(const Lanes* lanes, int k, Row* row)
{
    for (int a = 0; a < 4; ++a) row[a] = *reinterpret_cast<const Row*>(&lanes[a][k]);
    transpose(row[0], row[1], row[2], row[3]);
}

/// Some contact in each lane
inline void fill(Batch& batch, const ContactConstants& c)
{
    for (int k = 0; k < width; k += 4)
    {
        const Row contact{1.0, 0.0, 0.0, 1.0};
        put(batch.delta, k, contact, contact, contact, contact);
        put(batch.velocity, k, contact, contact, contact, contact);
        put(batch.normal, k, c.normal, c.normal, c.normal, c.normal);
        put(batch.tangential, k, c.tangential, c.tangential, c.tangential, c.tangential);
    }
}

template <class Vector> inline const Vector& lanes(const Lanes& from, int k)
{
    return *reinterpret_cast<const Vector*>(&from[k]);
}

template <class Vector> inline void put(Lanes& to, int k, const Vector& values)
{
    *reinterpret_cast<Vector*>(&to[k]) = values;
}

template <class Vector> inline Vector larger(const Vector& a, const Vector& b)
{
    return a > b ? a : b;
}

inline void inverseRoot(const Row& x, Row& y)
{
    for (int k = 0; k < 4; ++k) y[k] = 1.0 / std::sqrt(x[k]);
}

/// From the processor's estimate of 14 bits by an iteration of fourth order, to the last digit or the one before: roots
/// and divisions of eight numbers take several times as long.
__attribute__((target("arch=x86-64-v4"))) inline void inverseRoot(const Wide& x, Wide& y)
{
    const Wide estimate = _mm512_maskz_rsqrt14_pd(0xff, x);
    const Wide e = 1.0 - x * estimate * estimate;
    y = estimate + estimate * e * (0.5 + e * (0.375 + 0.3125 * e));
}

/// All lanes, also those that are not used: a fixed number is what the compiler does best. OpenFOAM stops at a division
/// by zero, so unused lanes hold a contact, too.
/// @tparam Vector  as many lanes as the processor takes at a time
template <class Vector, bool friction> inline void law(Batch& b, double timestep)
{
    const Vector nearlyNothing = Vector{} + 1e-300, never = Vector{} + 1e300;
    for (int k = 0; k < width; k += sizeof(Vector) / sizeof(double))
    {
        const auto at = [k](const Lanes& from) { return lanes<Vector>(from, k); };
        const Vector dx = at(b.delta[0]), dy = at(b.delta[1]), dz = at(b.delta[2]);
        const Vector vx = at(b.velocity[0]), vy = at(b.velocity[1]), vz = at(b.velocity[2]);
        const Vector distance2 = dx * dx + dy * dy + dz * dz;
        Vector inverse, root; // of the distance, of the effective mass
        inverseRoot(distance2, inverse);
        inverseRoot(at(b.velocity[3]), root);
        const Vector ex = dx * inverse, ey = dy * inverse, ez = dz * inverse;
        const Vector overlap = at(b.delta[3]) - distance2 * inverse;
        const Vector vn = vx * ex + vy * ey + vz * ez;
        const Vector fn = at(b.normal[0]) * overlap - (at(b.normal[1]) + at(b.normal[2]) * root) * vn;
        if (!friction)
        {
            put<Vector>(b.force[0], k, fn * ex);
            put<Vector>(b.force[1], k, fn * ey);
            put<Vector>(b.force[2], k, fn * ez);
            continue;
        }
        const Vector ai = at(b.spin_i[3]) - 0.5 * overlap, aj = at(b.spin_j[3]) - 0.5 * overlap;
        const Vector wx = ai * at(b.spin_i[0]) + aj * at(b.spin_j[0]);
        const Vector wy = ai * at(b.spin_i[1]) + aj * at(b.spin_j[1]);
        const Vector wz = ai * at(b.spin_i[2]) + aj * at(b.spin_j[2]);
        const Vector ux = vx - vn * ex - (ez * wy - ey * wz);
        const Vector uy = vy - vn * ey - (ex * wz - ez * wx);
        const Vector uz = vz - vn * ez - (ey * wx - ex * wy);

        // the spring, turned with the contact plane, keeping its length
        Vector sx = at(b.stretch[0]), sy = at(b.stretch[1]), sz = at(b.stretch[2]);
        const Vector before = sx * sx + sy * sy + sz * sz;
        const Vector out = sx * ex + sy * ey + sz * ez;
        sx -= out * ex;
        sy -= out * ey;
        sz -= out * ez;
        const Vector after = sx * sx + sy * sy + sz * sz;
        Vector scale;
        inverseRoot(larger<Vector>(before * after, nearlyNothing), scale);
        scale *= before;
        sx = scale * sx + ux * timestep;
        sy = scale * sy + uy * timestep;
        sz = scale * sz + uz * timestep;

        const Vector kt = at(b.tangential[0]), invKt = at(b.tangential[3]);
        const Vector damping = at(b.tangential[1]) + at(b.tangential[2]) * root;
        Vector tx = -kt * sx - damping * ux, ty = -kt * sy - damping * uy, tz = -kt * sz - damping * uz;
        const Vector square = tx * tx + ty * ty + tz * tz;
        const Vector limit = at(b.normal[3]) * larger<Vector>(fn, -fn), limit2 = limit * limit;
        Vector ratio;
        inverseRoot(larger<Vector>(square, larger<Vector>(limit2, nearlyNothing)), ratio);
        ratio *= limit;
        tx *= ratio;
        ty *= ratio;
        tz *= ratio;
        // a spring that friction shortens to what it holds, where there is one
        const Vector least = invKt > 0.0 ? limit2 : never;
        put<Vector>(b.stretch[0], k, square > least ? -(tx + damping * ux) * invKt : sx);
        put<Vector>(b.stretch[1], k, square > least ? -(ty + damping * uy) * invKt : sy);
        put<Vector>(b.stretch[2], k, square > least ? -(tz + damping * uz) * invKt : sz);

        put<Vector>(b.force[0], k, fn * ex + tx);
        put<Vector>(b.force[1], k, fn * ey + ty);
        put<Vector>(b.force[2], k, fn * ez + tz);
        put<Vector>(b.force[3], k, ai);
        put<Vector>(b.turn[0], k, ey * tz - ez * ty);
        put<Vector>(b.turn[1], k, ez * tx - ex * tz);
        put<Vector>(b.turn[2], k, ex * ty - ey * tx);
        put<Vector>(b.turn[3], k, aj);
    }
}

} // namespace
} // namespace hotbed
