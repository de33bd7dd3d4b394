#include "contact_kernel.hpp"

#include "contact_law.hpp"

#include <algorithm>
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

/// The first of two rows behind those of the particles: of the pairs that fill up
inline int nowhereRow(const ContactPairs& pairs, int local, int all)
{
    return pairs.ring + all - local;
}

/// i less j, but the sum of the fourth
inline Row less(const Row& i, const Row& j)
{
    return i + j * Row{-1.0, -1.0, -1.0, 1.0};
}

/// Bit k: whether lane k is all ones
__attribute__((target("avx2"))) inline unsigned bits(const Index& lanes)
{
    return unsigned(_mm256_movemask_pd(reinterpret_cast<const __m256d&>(lanes)));
}

using Four = int __attribute__((vector_size(16), aligned(4)));

/// Of each set of four bits those that are set, one after the other, and how many they are
struct Selection
{
    int which[16][4] = {};
    unsigned count[16] = {};
};

constexpr Selection selections()
{
    Selection s;
    for (int bits = 0; bits < 16; ++bits)
        for (int k = 0; k < 4; ++k)
            if (bits >> k & 1) s.which[bits][s.count[bits]++] = k;
    return s;
}

constexpr Selection selection = selections();

inline double* spring(const ContactPairs& pairs, const PairBlock& block, int p)
{
    return block.spring + std::ptrdiff_t(p) * pairs.stride;
}

/// Four pairs from `first` on, one of which is not in the state that is known: rare. @param now  bits of those that
/// touch
__attribute__((noinline)) void settle(ContactPairs& pairs, const PairBlock& block, const ContactStep& step,
                                      const Place* place, int first, unsigned now)
{
    unsigned char& contact = pairs.contact[first / 4];
    for (int k = 0; k < 4; ++k)
    {
        const int p = first + k;
        const bool touches = now >> k & 1;
        if ((contact >> k & (TOUCHING | UNSETTLED)) == (touches ? TOUCHING : 0)) continue;
        const Row between = less(place[pairs.i[p]].center, place[pairs.j[p]].center);
        const double square = between[0] * between[0] + between[1] * between[1] + between[2] * between[2];
        if (!touches && !(square < step.parted * between[3] * between[3])) continue;
        contact &= ~((TOUCHING | UNSETTLED) << k);
        if (touches) contact |= TOUCHING << k;
        pairs.changed.push_back({block.flag + p, spring(pairs, block, p), touches});
    }
}

/// Flags and springs of the pairs that were settled. They lie anywhere in the memory, so all are on their way before
/// the first is needed.
void tell(ContactPairs& pairs, int flagBits)
{
    for (const ContactPairs::Change& change : pairs.changed)
    {
        __builtin_prefetch(change.flag, 1);
        __builtin_prefetch(change.spring, 1);
    }
    for (const ContactPairs::Change& change : pairs.changed)
    {
        *change.flag = change.touches ? flagBits : 0; // no other bits: reading them first would wait
        if (!change.touches) std::fill_n(change.spring, 3, 0.0);
    }
    pairs.changed.clear();
}

/// Springs of pairs further on are fetched, so many that they have come when it is their turn.
constexpr int springsAhead = 128;

/// Looks through the pairs from p on until the batch is full. @return the next pair to look at
template <bool friction>
inline int find(Batch& batch, ContactPairs& pairs, const PairBlock& block, const ContactStep& step,
                const ContactRows& rows, int p)
{
    const Place* place = rows.place.data();
    const int* first = pairs.i.data();
    const int* second = pairs.j.data();
    const unsigned char* contact = pairs.contact.data();
    std::size_t n = 0;
    for (; p < block.end && n <= width - 4; p += 4)
    {
        if (friction)
            for (const int k : {0, 2}) __builtin_prefetch(spring(pairs, block, p + springsAhead + k), 1);
        Row x[4];
        for (int k = 0; k < 4; ++k) x[k] = less(place[first[p + k]].center, place[second[p + k]].center);
        transpose(x[0], x[1], x[2], x[3]);
        const unsigned now = bits(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < x[3] * x[3]);
        *reinterpret_cast<Four*>(&batch.pair[n]) = p + *reinterpret_cast<const Four*>(selection.which[now]);
        n += selection.count[now];
        if (now != contact[p / 4]) settle(pairs, block, step, place, p, now);
    }
    // the last four lanes that are used are full ones
    for (std::size_t k = n; k % 4 != 0; ++k) batch.pair[k] = int(pairs.i.size()) - 1;
    batch.n = int(n);
    return p;
}

template <bool friction>
inline void gather(Batch& batch, const ContactPairs& pairs, const PairBlock& block, const ContactStep& step,
                   const ContactRows& rows)
{
    const Place* place = rows.place.data();
    const Motion* motion = rows.motion.data();
    for (int k = 0; k < batch.n; k += 4)
    {
        const Motion* i[4];
        const Motion* j[4];
        Row between[4];
        for (int a = 0; a < 4; ++a)
        {
            const int first = pairs.i[batch.pair[k + a]], second = pairs.j[batch.pair[k + a]];
            between[a] = less(place[first].center, place[second].center);
            i[a] = &motion[first];
            j[a] = &motion[second];
        }
        put(batch.delta, k, between[0], between[1], between[2], between[3]);
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
    {
        const double* stretch = spring(pairs, block, batch.pair[k]);
        for (int a = 0; a < 3; ++a) batch.stretch[a][k] = stretch[a];
    }
}

template <bool friction>
inline void scatter(const Batch& batch, const ContactPairs& pairs, const PairBlock& block, Load* load)
{
    for (int k = 0; k < batch.n; k += 4)
    {
        Row force[4], turn[4];
        take(batch.force, k, force);
        if (friction) take(batch.turn, k, turn);
        for (int a = 0; a < 4; ++a)
        {
            const int pair = batch.pair[k + a];
            Load& i = load[pairs.i[pair]];
            Load& j = load[pairs.j[pair]];
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
    {
        double* stretch = spring(pairs, block, batch.pair[k]);
        for (int a = 0; a < 3; ++a) stretch[a] = batch.stretch[a][k];
    }
}

/// Three numbers of a particle and another. @param last  behind its numbers there are none of a next particle to read
inline Row row(const double (*numbers)[3], int i, double fourth, bool last)
{
    const double* from = numbers[i];
    if (last) return Row{from[0], from[1], from[2], fourth};
    Row r;
    std::memcpy(&r, from, sizeof r);
    return __builtin_shuffle(r, Row{fourth, fourth, fourth, fourth}, Index{0, 1, 2, 4});
}

/// Particles further on are fetched: they come a block at a time, and the processor does not see so many arrays coming.
constexpr int ahead = 64;

/// Puts a particle into its row.
template <bool friction> inline void enter(ContactRows& rows, int at, const ContactParticles& particles, int i)
{
    __builtin_prefetch(particles.x[i + ahead]);
    __builtin_prefetch(particles.v[i + ahead]);
    if (friction) __builtin_prefetch(particles.omega[i + ahead]);
    __builtin_prefetch(particles.radius + i + ahead);
    __builtin_prefetch(particles.mass + i + ahead);
    const bool last = i + 1 == particles.all;
    const double r = particles.radius[i];
    rows.place[at].center = row(particles.x, i, r, last);
    rows.motion[at].velocity = row(particles.v, i, 1.0 / particles.mass[i], last);
    if (friction) rows.motion[at].spin = row(particles.omega, i, r, last);
    rows.load[at] = Load{};
}

/// Gives what a row has got to its particle, one after the other: where forces are set and not added to, the fourth
/// entry goes where the next particle's are set afterwards. @param last  there is no place for a next one
template <bool friction>
inline void leave(const Load& load, const ContactParticles& particles, int i, bool add, bool last)
{
    __builtin_prefetch(particles.force[i + ahead], 1);
    __builtin_prefetch(particles.torque[i + ahead], 1);
    double *force = particles.force[i], *torque = particles.torque[i];
    if (!add && !last)
    {
        std::memcpy(force, &load.force, sizeof load.force);
        std::memcpy(torque, &load.torque, sizeof load.torque);
        return;
    }
    for (int a = 0; a < 3; ++a) force[a] = add ? force[a] + load.force[a] : load.force[a];
    if (!friction && add) return;
    for (int a = 0; a < 3; ++a) torque[a] = add ? torque[a] + load.torque[a] : load.torque[a];
}

template <class Vector, bool friction>
inline void run(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    for (int i = particles.local; i < particles.all; ++i)
        enter<friction>(rows, pairs.ring + i - particles.local, particles, i);
    for (int k = 0; k < 2; ++k) // of the pairs that fill up: apart, at rest
    {
        const int row = nowhereRow(pairs, particles.local, particles.all) + k;
        rows.place[row].center = Row{double(k), 0.0, 0.0, 0.0};
        rows.motion[row] = {Row{0.0, 0.0, 0.0, 1.0}, Row{}};
        rows.load[row] = Load{};
    }

    Batch batch;
    fill(batch, step.constants[0]);
    int p = 0, entered = 0, left = 0, next = 0, first = 0; // the last two: rows
    int told = 0;
    const bool tells = bool(step.complete);
    const auto complete = [&]
    {
        if (!tells || left == told) return;
        step.complete(told, left);
        told = left;
    };
    const auto goes = [&](const Load& load)
    {
        leave<friction>(load, particles, left - told, step.add, !tells && left + 1 == particles.local);
        if (++left - told == completeAtOnce) complete();
    };
    for (const PairBlock& block : pairs.blocks)
    {
        for (; entered < block.entered; ++entered)
        {
            enter<friction>(rows, next, particles, entered);
            if (++next == pairs.ring) next = 0;
        }
        while (p < block.end)
        {
            p = find<friction>(batch, pairs, block, step, rows, p);
            gather<friction>(batch, pairs, block, step, rows);
            law<Vector, friction>(batch, step.timestep);
            scatter<friction>(batch, pairs, block, rows.load.data());
        }
        while (left < block.left)
        {
            goes(rows.load[first]);
            if (++first == pairs.ring) first = 0;
        }
        complete();
    }
    while (!step.add && left < particles.local) goes(Load{}); // of no pair
    complete();
    tell(pairs, step.flagBits);
}

template <class Vector>
inline void forces(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    if (step.friction)
        run<Vector, true>(particles, pairs, step, rows);
    else
        run<Vector, false>(particles, pairs, step, rows);
}

// all of the above, compiled for each of the two
__attribute__((target("arch=x86-64-v3"), flatten)) void runAvx2(const ContactParticles& particles, ContactPairs& pairs,
                                                                const ContactStep& step, ContactRows& rows)
{
    forces<Row>(particles, pairs, step, rows);
}

__attribute__((target("arch=x86-64-v4"), flatten)) void
runAvx512(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    forces<Wide>(particles, pairs, step, rows);
}

} // namespace

bool canVectorise()
{
    return __builtin_cpu_supports("x86-64-v3");
}

void ContactPairs::clear(int springStride)
{
    i.clear();
    j.clear();
    contact.clear();
    types.clear();
    blocks.clear();
    stride = springStride;
}

namespace
{

constexpr int nowhere = -1;

void append(ContactPairs& pairs, int first, int second, unsigned short type)
{
    if (pairs.i.size() % 4 == 0) pairs.contact.push_back(0);
    pairs.i.push_back(first);
    pairs.j.push_back(second);
    pairs.types.push_back(type);
}

void fillUp(ContactPairs& pairs)
{
    while (pairs.i.size() % 4 != 0) append(pairs, nowhere, nowhere, 0);
}

} // namespace

void ContactPairs::add(int first, int second, unsigned short type, unsigned known, int* flag, double* spring)
{
    const auto springOf = [this](std::size_t p) { return blocks.back().spring + std::ptrdiff_t(p) * stride; };
    const std::size_t next = i.size();
    if (blocks.empty() || int(next) - blocks.back().first == blockPairs || flag != blocks.back().flag + next ||
        spring != springOf(next))
    {
        fillUp(*this);
        const std::ptrdiff_t p = std::ptrdiff_t(i.size());
        blocks.push_back({int(p), 0, 0, 0, flag - p, spring - p * stride});
    }
    append(*this, first, second, type);
    contact.back() |= known << (i.size() - 1) % 4;
}

void arrange(ContactPairs& pairs, int local, int all)
{
    append(pairs, nowhere, nowhere, 0);
    fillUp(pairs);
    const int count = int(pairs.i.size()), blocks = int(pairs.blocks.size());
    bool ordered = true; // as LIGGGHTS lists them
    for (int p = 0, before = 0; p < count; ++p)
    {
        if (pairs.i[p] == nowhere) continue;
        ordered = ordered && before <= pairs.i[p] && (pairs.j[p] >= local || pairs.j[p] > pairs.i[p]);
        before = pairs.i[p];
    }
    pairs.ring = 1;
    int entered = ordered ? 0 : local, left = 0;
    for (int b = 0; b < blocks; ++b)
    {
        PairBlock& block = pairs.blocks[b];
        const bool last = b + 1 == blocks;
        block.end = last ? count : pairs.blocks[b + 1].first;
        for (int p = block.first; p < block.end; ++p)
            entered = std::max({entered, pairs.i[p] + 1, pairs.j[p] < local ? pairs.j[p] + 1 : 0});
        pairs.ring = std::max(pairs.ring, entered - left);
        if (last)
            left = entered;
        else if (ordered)
            left = std::min(pairs.i[block.end], entered);
        block.entered = entered;
        block.left = left;
    }
    const int row = nowhereRow(pairs, local, all);
    for (int p = 0; p < count; ++p)
    {
        const bool filled = pairs.i[p] == nowhere;
        pairs.i[p] = filled ? row : pairs.i[p] % pairs.ring;
        pairs.j[p] = filled ? row + 1 : pairs.j[p] < local ? pairs.j[p] % pairs.ring : pairs.ring + pairs.j[p] - local;
    }
}

void contactForces(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows)
{
    const std::size_t count = std::size_t(nowhereRow(pairs, particles.local, particles.all)) + 2;
    rows.place.resize(count);
    rows.motion.resize(count);
    rows.load.resize(count);
    if (__builtin_cpu_supports("x86-64-v4"))
        runAvx512(particles, pairs, step, rows);
    else
        runAvx2(particles, pairs, step, rows);
}

} // namespace hotbed
