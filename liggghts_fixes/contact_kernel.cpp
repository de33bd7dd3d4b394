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

/// Four pairs from `first` on, one of which is not in the state that is known: rare. @param now  bits of those that
/// touch
__attribute__((noinline)) void settle(ContactPairs& pairs, const ContactStep& step, const Place* place, int first,
                                      unsigned now)
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
        pairs.changed.push_back(p);
    }
}

/// Flags and springs of the pairs that were settled. They lie anywhere in the memory, so all are on their way before
/// the first is needed.
void tell(ContactPairs& pairs, int flagBits)
{
    for (const int p : pairs.changed)
    {
        __builtin_prefetch(&pairs.flag[p]);
        __builtin_prefetch(&pairs.spring[p]);
    }
    for (const int p : pairs.changed)
    {
        __builtin_prefetch(pairs.flag[p], 1);
        __builtin_prefetch(pairs.spring[p], 1);
    }
    for (const int p : pairs.changed)
    {
        const bool touches = pairs.contact[p / 4] >> p % 4 & TOUCHING;
        *pairs.flag[p] = touches ? flagBits : 0; // no other bits: reading them first would wait
        if (!touches) std::fill_n(pairs.spring[p], 3, 0.0);
    }
    pairs.changed.clear();
}

/// Looks through the pairs from p on until the batch is full. @return the next pair to look at
template <bool friction>
inline int find(Batch& batch, ContactPairs& pairs, const ContactStep& step, const ContactRows& rows, int p, int end)
{
    const Place* place = rows.place.data();
    const int* first = pairs.i.data();
    const int* second = pairs.j.data();
    const unsigned char* contact = pairs.contact.data();
    std::size_t n = 0;
    for (; p < end && n <= width - 4; p += 4)
    {
        Row x[4];
        for (int k = 0; k < 4; ++k) x[k] = less(place[first[p + k]].center, place[second[p + k]].center);
        transpose(x[0], x[1], x[2], x[3]);
        const unsigned now = bits(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < x[3] * x[3]);
        *reinterpret_cast<Four*>(&batch.pair[n]) = p + *reinterpret_cast<const Four*>(selection.which[now]);
        n += selection.count[now];
        if (now != contact[p / 4]) settle(pairs, step, place, p, now);
    }
    if (friction)
        for (std::size_t k = 0; k < n; ++k) __builtin_prefetch(pairs.spring[batch.pair[k]], 1);
    // the last four lanes that are used are full ones
    for (std::size_t k = n; k % 4 != 0; ++k) batch.pair[k] = int(pairs.i.size()) - 1;
    batch.n = int(n);
    return p;
}

template <bool friction>
inline void gather(Batch& batch, const ContactPairs& pairs, const ContactStep& step, const ContactRows& rows)
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
        const double* spring = pairs.spring[batch.pair[k]];
        for (int a = 0; a < 3; ++a) batch.stretch[a][k] = spring[a];
    }
}

template <bool friction> inline void scatter(const Batch& batch, const ContactPairs& pairs, Load* load)
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
        double* spring = pairs.spring[batch.pair[k]];
        for (int a = 0; a < 3; ++a) spring[a] = batch.stretch[a][k];
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
/// entry goes where the next particle's are set afterwards.
template <bool friction> inline void leave(const Load& load, const ContactParticles& particles, int i, bool add)
{
    __builtin_prefetch(particles.force[i + ahead], 1);
    __builtin_prefetch(particles.torque[i + ahead], 1);
    double *force = particles.force[i], *torque = particles.torque[i];
    if (!add && i + 1 < particles.local)
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
    for (const PairBlock& block : pairs.blocks)
    {
        for (; entered < block.entered; ++entered)
        {
            enter<friction>(rows, next, particles, entered);
            if (++next == pairs.ring) next = 0;
        }
        while (p < block.end)
        {
            p = find<friction>(batch, pairs, step, rows, p, block.end);
            gather<friction>(batch, pairs, step, rows);
            law<Vector, friction>(batch, step.timestep);
            scatter<friction>(batch, pairs, rows.load.data());
        }
        for (; left < block.left; ++left)
        {
            leave<friction>(rows.load[first], particles, left, step.add);
            if (++first == pairs.ring) first = 0;
        }
    }
    for (; !step.add && left < particles.local; ++left) leave<friction>(Load{}, particles, left, false); // of no pair
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

void ContactPairs::resize(int count)
{
    const std::size_t filled = (std::size_t(count) / 4 + 1) * 4; // one at least fills up
    i.resize(filled);
    j.resize(filled);
    types.assign(filled, 0);
    contact.assign(filled / 4, 0);
    flag.resize(filled);
    spring.assign(filled, nowhere);
}

void arrange(ContactPairs& pairs, int count, int local, int all)
{
    bool ordered = true; // as LIGGGHTS lists them
    for (int p = 0; p < count; ++p)
        ordered =
            ordered && (p == 0 || pairs.i[p - 1] <= pairs.i[p]) && (pairs.j[p] >= local || pairs.j[p] > pairs.i[p]);
    const int length = ordered ? blockPairs : std::max(count, 1);
    pairs.blocks.clear();
    pairs.ring = 1;
    int entered = 0, left = 0;
    for (int first = 0; first < count; first += length)
    {
        const int end = std::min(first + length, count);
        for (int p = first; p < end; ++p)
            entered = std::max({entered, pairs.i[p] + 1, pairs.j[p] < local ? pairs.j[p] + 1 : 0});
        pairs.ring = std::max(pairs.ring, entered - left);
        left = end < count ? std::min(pairs.i[end], entered) : entered;
        pairs.blocks.push_back({(end + 3) / 4 * 4, entered, left});
    }
    for (int p = 0; p < count; ++p)
    {
        pairs.i[p] %= pairs.ring;
        pairs.j[p] = pairs.j[p] < local ? pairs.j[p] % pairs.ring : pairs.ring + pairs.j[p] - local;
    }
    std::fill(pairs.i.begin() + count, pairs.i.end(), nowhereRow(pairs, local, all));
    std::fill(pairs.j.begin() + count, pairs.j.end(), nowhereRow(pairs, local, all) + 1);
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
