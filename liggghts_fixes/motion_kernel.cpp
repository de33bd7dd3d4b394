#include "motion_kernel.hpp"

#include <algorithm>
#include <cstring>

namespace hotbed
{
namespace
{

/// Particles further on are fetched, so many that they have come when it is their turn: the processor does not see so
/// many arrays coming.
constexpr int ahead = 64;

template <class Vector> constexpr int lanes = int(sizeof(Vector) / sizeof(double));

template <class Vector> inline Vector load(const double* from)
{
    Vector v;
    std::memcpy(&v, from, sizeof v);
    return v;
}

template <class Vector> inline void store(double* to, const Vector& v)
{
    std::memcpy(to, &v, sizeof v);
}

/// What a particle has one of, for each of its three components
template <class Vector> inline void spread(const Vector& each, Vector* components)
{
    for (int k = 0; k < 3; ++k)
    {
        decltype(each > each) which;
        for (int lane = 0; lane < lanes<Vector>; ++lane) which[lane] = (k * lanes<Vector> + lane) / 3;
        components[k] = __builtin_shuffle(each, which);
    }
}

/// As many particles from `start` on as there are lanes; their components are three vectors of each array.
/// @param peaks  longest way [m] of any particle, its square, in each lane
template <bool second, bool first, class Vector>
inline void move(const MovingParticles& p, const MotionStep& step, const Vector* gravity, int start, Vector* peaks)
{
    __builtin_prefetch(p.mass + start + ahead);
    __builtin_prefetch(p.radius + start + ahead);
    __builtin_prefetch(p.mask + start + ahead);
    const Vector mass = load<Vector>(p.mass + start), radius = load<Vector>(p.radius + start);
    Vector in;
    for (int lane = 0; lane < lanes<Vector>; ++lane) in[lane] = p.mask[start + lane] & step.groupbit ? 1.0 : 0.0;
    Vector kick[3], turn[3], weight[3];
    spread<Vector>(in * (step.kick / mass), kick);
    spread<Vector>(in * (step.turn / (radius * radius * mass)), turn);
    spread<Vector>(mass, weight);
    for (int k = 0; k < 3; ++k)
    {
        const int at = 3 * start + lanes<Vector> * k, later = at + 3 * ahead;
        __builtin_prefetch(p.x + later, 1);
        __builtin_prefetch(p.v + later, 1);
        __builtin_prefetch(p.force + later);
        __builtin_prefetch(p.omega + later, 1);
        __builtin_prefetch(p.torque + later);
        weight[k] *= gravity[k];
        if (p.gas)
        {
            __builtin_prefetch(p.gas + later);
            weight[k] += load<Vector>(p.gas + at);
        }
        const Vector before = load<Vector>(p.force + at), force = before + weight[k];
        const Vector place = load<Vector>(p.x + at);
        const Vector push = kick[k] * force, spin = turn[k] * load<Vector>(p.torque + at);
        Vector velocity = load<Vector>(p.v + at) + push, rotation = load<Vector>(p.omega + at) + spin;
        if (second && first)
        {
            velocity += push;
            rotation += spin;
        }
        store(p.v + at, velocity);
        store(p.omega + at, rotation);
        const auto moves = kick[k] > 0.0;
        if (first)
        {
            const Vector way = (moves ? Vector{} + step.drift : Vector{}) * velocity, square = way * way;
            store<Vector>(p.x + at, place + way);
            peaks[k] = square > peaks[k] ? square : peaks[k];
        }
        else
            store<Vector>(p.force + at, moves ? force : before);
    }
}

/// All particles from `start` on of which there are enough. @return those left
template <bool second, bool first, class Vector>
inline int moveFrom(int start, const MovingParticles& p, const MotionStep& step, double* way)
{
    Vector gravity[3] = {}, longest[3] = {};
    for (int k = 0; step.gravity && k < 3 * lanes<Vector>; ++k)
        gravity[k / lanes<Vector>][k % lanes<Vector>] = step.gravity[k % 3];
    for (; start + lanes<Vector> <= p.number; start += lanes<Vector>)
        move<second, first, Vector>(p, step, gravity, start, longest);
    for (int k = 0; k < 3 * lanes<Vector>; ++k)
        way[k % 3] = std::max(way[k % 3], longest[k / lanes<Vector>][k % lanes<Vector>]);
    return start;
}

using One = double __attribute__((vector_size(8)));
using Two = double __attribute__((vector_size(16)));
using Four = double __attribute__((vector_size(32)));
using Eight = double __attribute__((vector_size(64)));

template <class Vector> inline void moveAll(Half half, const MovingParticles& p, const MotionStep& step, double* way)
{
    switch (half)
    {
    case FIRST:
        moveFrom<false, true, One>(moveFrom<false, true, Vector>(0, p, step, way), p, step, way);
        break;
    case SECOND:
        moveFrom<true, false, One>(moveFrom<true, false, Vector>(0, p, step, way), p, step, way);
        break;
    case SECOND_AND_FIRST:
        moveFrom<true, true, One>(moveFrom<true, true, Vector>(0, p, step, way), p, step, way);
    }
}

void moveAny(Half half, const MovingParticles& p, const MotionStep& step, double* way)
{
    moveAll<Two>(half, p, step, way);
}

__attribute__((target("arch=x86-64-v3"), flatten)) void moveAvx2(Half half, const MovingParticles& p,
                                                                 const MotionStep& step, double* way)
{
    moveAll<Four>(half, p, step, way);
}

__attribute__((target("arch=x86-64-v4"), flatten)) void moveAvx512(Half half, const MovingParticles& p,
                                                                   const MotionStep& step, double* way)
{
    moveAll<Eight>(half, p, step, way);
}

} // namespace

void move(Half half, const MovingParticles& particles, const MotionStep& step, double* way)
{
    (__builtin_cpu_supports("x86-64-v4")   ? moveAvx512
     : __builtin_cpu_supports("x86-64-v3") ? moveAvx2
                                           : moveAny)(half, particles, step, way);
}

} // namespace hotbed
