#pragma once

/// The law for a batch of contacts, in vector registers. Part of contact_kernel.cpp and wall_kernel.cpp, each of which
/// compiles it for the processors it knows: hence functions of their own.

#include "contact_kernel.hpp"

#include <cmath>

namespace hotbed
{
namespace
{

/// Pairs of a batch: its arrays stay in the nearest cache.
constexpr int width = 64;

using Lanes = double[width];
using Index = long long __attribute__((vector_size(32)));

struct Batch
{
    int n = 0;
    int pair[width + 4], i[width + 4], j[width + 4];
    double* spring[width];
    alignas(64) Row between[width + 4];
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

constexpr double nearlyNothing = 1e-300;

inline double larger(double a, double b)
{
    return a > b ? a : b;
}

/// All lanes, also those that are not used: a fixed number is what the compiler does best. OpenFOAM stops at a division
/// by zero, so unused lanes hold a contact, too.
template <bool friction> inline void law(Batch& b, double timestep)
{
    for (int k = 0; k < width; ++k)
    {
        const double dx = b.delta[0][k], dy = b.delta[1][k], dz = b.delta[2][k];
        const double vx = b.velocity[0][k], vy = b.velocity[1][k], vz = b.velocity[2][k];
        const double r = std::sqrt(dx * dx + dy * dy + dz * dz);
        const double inverse = 1.0 / r;
        const double ex = dx * inverse, ey = dy * inverse, ez = dz * inverse;
        const double overlap = b.delta[3][k] - r;
        const double root = 1.0 / std::sqrt(b.velocity[3][k]); // of the effective mass
        const double vn = vx * ex + vy * ey + vz * ez;
        const double fn = b.normal[0][k] * overlap - (b.normal[1][k] + b.normal[2][k] * root) * vn;
        if (!friction)
        {
            b.force[0][k] = fn * ex;
            b.force[1][k] = fn * ey;
            b.force[2][k] = fn * ez;
            continue;
        }
        const double ai = b.spin_i[3][k] - 0.5 * overlap, aj = b.spin_j[3][k] - 0.5 * overlap;
        const double wx = ai * b.spin_i[0][k] + aj * b.spin_j[0][k];
        const double wy = ai * b.spin_i[1][k] + aj * b.spin_j[1][k];
        const double wz = ai * b.spin_i[2][k] + aj * b.spin_j[2][k];
        const double ux = vx - vn * ex - (ez * wy - ey * wz);
        const double uy = vy - vn * ey - (ex * wz - ez * wx);
        const double uz = vz - vn * ez - (ey * wx - ex * wy);

        // the spring, turned with the contact plane, keeping its length
        double sx = b.stretch[0][k], sy = b.stretch[1][k], sz = b.stretch[2][k];
        const double before = sx * sx + sy * sy + sz * sz;
        const double out = sx * ex + sy * ey + sz * ez;
        sx -= out * ex;
        sy -= out * ey;
        sz -= out * ez;
        const double after = sx * sx + sy * sy + sz * sz;
        const double scale = std::sqrt(before / larger(after, nearlyNothing));
        sx = scale * sx + ux * timestep;
        sy = scale * sy + uy * timestep;
        sz = scale * sz + uz * timestep;

        const double kt = b.tangential[0][k], invKt = b.tangential[3][k];
        const double damping = b.tangential[1][k] + b.tangential[2][k] * root;
        double tx = -kt * sx - damping * ux, ty = -kt * sy - damping * uy, tz = -kt * sz - damping * uz;
        const double square = tx * tx + ty * ty + tz * tz;
        const double limit = b.normal[3][k] * std::fabs(fn);
        const double ratio = limit / std::sqrt(larger(square, larger(limit * limit, nearlyNothing)));
        tx *= ratio;
        ty *= ratio;
        tz *= ratio;
        const bool shortened = (square > limit * limit) & (invKt > 0.0);
        const double cx = -(tx + damping * ux) * invKt, cy = -(ty + damping * uy) * invKt,
                     cz = -(tz + damping * uz) * invKt;
        b.stretch[0][k] = shortened ? cx : sx;
        b.stretch[1][k] = shortened ? cy : sy;
        b.stretch[2][k] = shortened ? cz : sz;

        b.force[0][k] = fn * ex + tx;
        b.force[1][k] = fn * ey + ty;
        b.force[2][k] = fn * ez + tz;
        b.force[3][k] = ai;
        b.turn[0][k] = ey * tz - ez * ty;
        b.turn[1][k] = ez * tx - ex * tz;
        b.turn[2][k] = ex * ty - ey * tx;
        b.turn[3][k] = aj;
    }
}

} // namespace
} // namespace hotbed
