#include "contact_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace hotbed
{
namespace
{

using Place = ContactRows::Place;
using Motion = ContactRows::Motion;
using Load = ContactRows::Load;

/// Pairs of a batch: its arrays stay in the nearest cache.
constexpr int width = 128;

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

/// i less j, but the sum of the fourth
inline Row less(const Row& i, const Row& j)
{
    return i + j * Row{-1.0, -1.0, -1.0, 1.0};
}

/// A pair whose state is not what it was: rare.
__attribute__((noinline)) void settle(ContactPairs& pairs, const ContactStep& step, int p, const Row& between)
{
    const int i = pairs.i[p], k = p - pairs.start[i];
    const double square = between[0] * between[0] + between[1] * between[1] + between[2] * between[2];
    const double reach = between[3] * between[3];
    if (square < reach)
    {
        step.flag[i][k] = step.flagBits; // no other bits: reading them first would wait for the memory
        pairs.contact[p] = TOUCHING;
    }
    else if (square < step.parted * reach)
    {
        step.flag[i][k] = 0;
        for (int a = 0; a < 3; ++a) step.history[i][std::size_t(step.stride) * k + step.offset + a] = 0.0;
        pairs.contact[p] = OPEN;
    }
}

/// Looks through the pairs from p on until the batch is full. @return the next pair to look at
template <bool friction>
inline int find(Batch& batch, ContactPairs& pairs, const ContactStep& step, const ContactRows& rows, int p)
{
    const Place* place = rows.place.data();
    const int* first = pairs.i.data();
    const int* second = pairs.j.data();
    const int count = int(pairs.i.size());
    int n = 0;
    for (; p < count && n <= width - 4; p += 4)
    {
        Row row[4], x[4];
        for (int k = 0; k < 4; ++k) x[k] = row[k] = less(place[first[p + k]].center, place[second[p + k]].center);
        transpose(x[0], x[1], x[2], x[3]);
        const Index touches = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < x[3] * x[3];
        // a byte for each pair, as in pairs.contact
        const Index bytes = touches & Index{1, 1 << 8, 1 << 16, 1 << 24};
        const Index folded = bytes | __builtin_shuffle(bytes, Index{2, 3, 0, 1});
        const auto now = std::uint32_t(folded[0] | folded[1]);
        for (int k = 0; k < 4; ++k)
        {
            batch.between[n] = row[k];
            batch.pair[n] = p + k;
            n += now >> (8 * k) & 1;
        }
        std::uint32_t before;
        std::memcpy(&before, &pairs.contact[p], 4);
        if (now == before) continue;
        for (int k = 0; k < 4; ++k)
            if ((now >> (8 * k) & 1) != pairs.contact[p + k]) settle(pairs, step, p + k, row[k]);
    }
    for (int k = 0; k < n; ++k)
    {
        const int pair = batch.pair[k], i = first[pair];
        batch.i[k] = i;
        batch.j[k] = second[pair];
        __builtin_prefetch(&rows.motion[batch.j[k]]);
        __builtin_prefetch(&rows.load[batch.j[k]], 1);
        if (!friction) continue;
        batch.spring[k] = step.history[i] + std::size_t(step.stride) * (pair - pairs.start[i]) + step.offset;
        __builtin_prefetch(batch.spring[k], 1);
    }
    // the last four lanes that are used are full ones
    for (int k = n; k % 4 != 0; ++k)
    {
        batch.between[k] = batch.between[n - 1];
        batch.pair[k] = batch.pair[n - 1];
        batch.i[k] = batch.i[n - 1];
        batch.j[k] = batch.j[n - 1];
    }
    batch.n = n;
    return p;
}

template <bool friction>
inline void gather(Batch& batch, const ContactPairs& pairs, const ContactStep& step, const Motion* motion)
{
    for (int k = 0; k < batch.n; k += 4)
    {
        const Row* between = &batch.between[k];
        put(batch.delta, k, between[0], between[1], between[2], between[3]);
        const Motion* i[4];
        const Motion* j[4];
        for (int a = 0; a < 4; ++a)
        {
            i[a] = &motion[batch.i[k + a]];
            j[a] = &motion[batch.j[k + a]];
        }
        put(batch.velocity, k, less(i[0]->velocity, j[0]->velocity), less(i[1]->velocity, j[1]->velocity),
            less(i[2]->velocity, j[2]->velocity), less(i[3]->velocity, j[3]->velocity));
        if (friction)
        {
            put(batch.spin_i, k, i[0]->spin, i[1]->spin, i[2]->spin, i[3]->spin);
            put(batch.spin_j, k, j[0]->spin, j[1]->spin, j[2]->spin, j[3]->spin);
        }
        if (!step.oneConstants)
        {
            const ContactConstants* c[4];
            for (int a = 0; a < 4; ++a) c[a] = &step.constants[pairs.types[batch.pair[k + a]]];
            put(batch.normal, k, c[0]->normal, c[1]->normal, c[2]->normal, c[3]->normal);
            put(batch.tangential, k, c[0]->tangential, c[1]->tangential, c[2]->tangential, c[3]->tangential);
        }
    }
    if (!friction) return;
    for (int k = 0; k < batch.n; ++k)
        for (int a = 0; a < 3; ++a) batch.stretch[a][k] = batch.spring[k][a];
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

template <bool friction> inline void scatter(const Batch& batch, Load* load)
{
    for (int k = 0; k < batch.n; k += 4)
    {
        Row force[4], turn[4];
        take(batch.force, k, force);
        if (friction) take(batch.turn, k, turn);
        const int lanes = batch.n - k < 4 ? batch.n - k : 4;
        for (int a = 0; a < lanes; ++a)
        {
            Load& i = load[batch.i[k + a]];
            Load& j = load[batch.j[k + a]];
            i.force += force[a];
            j.force -= force[a];
            if (friction)
            {
                i.torque -= force[a][3] * turn[a];
                j.torque -= turn[a][3] * turn[a];
            }
        }
    }
    if (!friction) return;
    for (int k = 0; k < batch.n; ++k)
        for (int a = 0; a < 3; ++a) batch.spring[k][a] = batch.stretch[a][k];
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

template <bool friction> inline void addLoads(ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    Batch batch;
    fill(batch, step.constants[0]);
    for (int p = 0; p < int(pairs.i.size());)
    {
        p = find<friction>(batch, pairs, step, rows, p);
        gather<friction>(batch, pairs, step, rows.motion.data());
        law<friction>(batch, step.timestep);
        scatter<friction>(batch, rows.load.data());
    }
}

inline void run(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    Place* place = rows.place.data();
    Motion* motion = rows.motion.data();
    Load* load = rows.load.data();
    for (int i = 0; i < particles.all; ++i)
    {
        const double *x = particles.x[i], *v = particles.v[i], *w = particles.omega[i];
        const double r = particles.radius[i];
        place[i].center = Row{x[0], x[1], x[2], r};
        motion[i].velocity = Row{v[0], v[1], v[2], 1.0 / particles.mass[i]};
        if (step.friction) motion[i].spin = Row{w[0], w[1], w[2], r};
    }
    place[particles.all].center = Row{1e100, 0.0, 0.0, 0.0};

    if (step.friction)
        addLoads<true>(pairs, step, rows);
    else
        addLoads<false>(pairs, step, rows);

    for (int i = 0; i < particles.local; ++i)
    {
        for (int a = 0; a < 3; ++a) particles.force[i][a] += load[i].force[a];
        if (step.friction)
            for (int a = 0; a < 3; ++a) particles.torque[i][a] += load[i].torque[a];
        load[i] = Load{};
    }
    std::fill(load + particles.local, load + particles.all, Load{});
}

inline void runWall(const ContactParticles& particles, const std::vector<WallContact>& contacts,
                    const ContactConstants* constants, double timestep)
{
    Batch batch;
    fill(batch, constants[0]);
    const int count = int(contacts.size());
    for (int start = 0; start < count; start += width)
    {
        const WallContact* contact = &contacts[start];
        const int n = count - start < width ? count - start : width;
        for (int k = 0; k < n; ++k)
        {
            const int i = contact[k].particle;
            const ContactConstants& c = constants[contact[k].type];
            for (int a = 0; a < 3; ++a)
            {
                batch.delta[a][k] = contact[k].from[a];
                batch.velocity[a][k] = particles.v[i][a];
                batch.spin_i[a][k] = particles.omega[i][a];
                batch.stretch[a][k] = contact[k].spring[a];
            }
            batch.delta[3][k] = batch.spin_i[3][k] = particles.radius[i];
            batch.velocity[3][k] = 1.0 / particles.mass[i];
            for (int a = 0; a < 4; ++a)
            {
                batch.normal[a][k] = c.normal[a];
                batch.tangential[a][k] = c.tangential[a];
            }
        }
        law<true>(batch, timestep);
        for (int k = 0; k < n; ++k)
        {
            const int i = contact[k].particle;
            for (int a = 0; a < 3; ++a)
            {
                particles.force[i][a] += batch.force[a][k];
                particles.torque[i][a] -= batch.force[3][k] * batch.turn[a][k];
                contact[k].spring[a] = batch.stretch[a][k];
            }
        }
    }
}

// all of the above, compiled for each of the two
__attribute__((target("arch=x86-64-v3"), flatten)) void runAvx2(const ContactParticles& particles, ContactPairs& pairs,
                                                                const ContactStep& step, ContactRows& rows)
{
    run(particles, pairs, step, rows);
}

__attribute__((target("arch=x86-64-v4"), flatten)) void
runAvx512(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    run(particles, pairs, step, rows);
}

__attribute__((target("arch=x86-64-v3"), flatten)) void wallAvx2(const ContactParticles& particles,
                                                                 const std::vector<WallContact>& contacts,
                                                                 const ContactConstants* constants, double timestep)
{
    runWall(particles, contacts, constants, timestep);
}

__attribute__((target("arch=x86-64-v4"), flatten)) void wallAvx512(const ContactParticles& particles,
                                                                   const std::vector<WallContact>& contacts,
                                                                   const ContactConstants* constants, double timestep)
{
    runWall(particles, contacts, constants, timestep);
}

} // namespace

bool canVectorise()
{
    return __builtin_cpu_supports("x86-64-v3");
}

void wallForces(const ContactParticles& particles, const std::vector<WallContact>& contacts,
                const ContactConstants* constants, double timestep)
{
    (__builtin_cpu_supports("x86-64-v4") ? wallAvx512 : wallAvx2)(particles, contacts, constants, timestep);
}

void contactForces(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    const std::size_t count = std::size_t(particles.all) + 1;
    rows.place.resize(count);
    rows.motion.resize(count);
    rows.load.resize(count, Load{});
    if (__builtin_cpu_supports("x86-64-v4"))
        runAvx512(particles, pairs, step, rows);
    else
        runAvx2(particles, pairs, step, rows);
}

} // namespace hotbed
