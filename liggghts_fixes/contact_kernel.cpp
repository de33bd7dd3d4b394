#include "contact_kernel.hpp"

#include "contact_law.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace hotbed
{
namespace
{

using Place = ContactRows::Place;
using Motion = ContactRows::Motion;
using Load = ContactRows::Load;

/// Of a block: few enough that the rows of its particles are no more than what pairs reach over anyway, many batches
constexpr int blockPairs = 4096;

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
inline int find(Batch& batch, ContactPairs& pairs, const ContactStep& step, const ContactRows& rows, int p, int end)
{
    const Place* place = rows.place.data();
    const int* first = pairs.i.data();
    const int* second = pairs.j.data();
    const int mask = pairs.ring - 1;
    int n = 0;
    for (; p < end && n <= width - 4; p += 4)
    {
        Row row[4], x[4];
        for (int k = 0; k < 4; ++k)
            x[k] = row[k] = less(place[first[p + k] & mask].center, place[second[p + k]].center);
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
        batch.i[k] = i & mask;
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

/// Puts a particle into its row.
template <bool friction> inline void enter(ContactRows& rows, int row, const ContactParticles& particles, int i)
{
    const double *x = particles.x[i], *v = particles.v[i], *w = particles.omega[i];
    const double r = particles.radius[i];
    rows.place[row].center = Row{x[0], x[1], x[2], r};
    rows.motion[row].velocity = Row{v[0], v[1], v[2], 1.0 / particles.mass[i]};
    if (friction) rows.motion[row].spin = Row{w[0], w[1], w[2], r};
    rows.load[row] = Load{};
}

/// Gives what a row has got to its particle.
template <bool friction> inline void leave(const Load& load, const ContactParticles& particles, int i, bool add)
{
    double *force = particles.force[i], *torque = particles.torque[i];
    for (int a = 0; a < 3; ++a) force[a] = add ? force[a] + load.force[a] : load.force[a];
    if (!friction && add) return;
    for (int a = 0; a < 3; ++a) torque[a] = add ? torque[a] + load.torque[a] : load.torque[a];
}

template <bool friction>
inline void run(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    for (int i = particles.local; i < particles.all; ++i)
        enter<friction>(rows, pairs.ring + i - particles.local, particles, i);
    rows.place[pairs.ring + particles.all - particles.local].center = Row{1e100, 0.0, 0.0, 0.0};

    Batch batch;
    fill(batch, step.constants[0]);
    const int mask = pairs.ring - 1;
    int p = 0, entered = 0, left = 0;
    for (const PairBlock& block : pairs.blocks)
    {
        for (; entered < block.entered; ++entered) enter<friction>(rows, entered & mask, particles, entered);
        while (p < block.end)
        {
            p = find<friction>(batch, pairs, step, rows, p, block.end);
            gather<friction>(batch, pairs, step, rows.motion.data());
            law<friction>(batch, step.timestep);
            scatter<friction>(batch, rows.load.data());
        }
        for (; left < block.left; ++left) leave<friction>(rows.load[left & mask], particles, left, step.add);
    }
    for (; !step.add && left < particles.local; ++left) leave<friction>(Load{}, particles, left, false); // of no pair
}

inline void forces(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    if (step.friction)
        run<true>(particles, pairs, step, rows);
    else
        run<false>(particles, pairs, step, rows);
}

// all of the above, compiled for each of the two
__attribute__((target("arch=x86-64-v3"), flatten)) void runAvx2(const ContactParticles& particles, ContactPairs& pairs,
                                                                const ContactStep& step, ContactRows& rows)
{
    forces(particles, pairs, step, rows);
}

__attribute__((target("arch=x86-64-v4"), flatten)) void
runAvx512(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    forces(particles, pairs, step, rows);
}

} // namespace

bool canVectorise()
{
    return __builtin_cpu_supports("x86-64-v3");
}

void arrange(ContactPairs& pairs, int local)
{
    const int count = int(pairs.i.size());
    bool ordered = true; // as LIGGGHTS lists them
    for (int p = 0; p < count; ++p)
        ordered =
            ordered && (p == 0 || pairs.i[p - 1] <= pairs.i[p]) && (pairs.j[p] >= local || pairs.j[p] > pairs.i[p]);
    const int length = ordered ? blockPairs : count;
    pairs.blocks.clear();
    pairs.ring = 1;
    int entered = 0, left = 0;
    for (int first = 0; first < count; first += length)
    {
        const int end = std::min(first + length, count);
        for (int p = first; p < end; ++p)
            entered = std::max({entered, pairs.i[p] + 1, pairs.j[p] < local ? pairs.j[p] + 1 : 0});
        while (pairs.ring < entered - left) pairs.ring *= 2;
        left = end < count ? std::min(pairs.i[end], entered) : entered;
        pairs.blocks.push_back({end, entered, left});
    }
    for (int& j : pairs.j) j = j < local ? j & (pairs.ring - 1) : pairs.ring + j - local;
}

void contactForces(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    const std::size_t count = std::size_t(pairs.ring + particles.all - particles.local) + 1;
    rows.place.resize(count);
    rows.motion.resize(count);
    rows.load.resize(count);
    if (__builtin_cpu_supports("x86-64-v4"))
        runAvx512(particles, pairs, step, rows);
    else
        runAvx2(particles, pairs, step, rows);
}

} // namespace hotbed
