#pragma once

/// Forces of all touching pairs by eq 18 and 19, the same law as normal_model_hotbed.h with tangential_model_hotbed.h,
/// for many pairs at a time. Knows arrays only; vectorised_pair.hpp fills them from LIGGGHTS.

#include <cstddef>
#include <vector>

namespace hotbed
{

using Row = double __attribute__((vector_size(32)));

struct Place
{
    alignas(32) Row center; ///< and the radius
};

struct Motion
{
    alignas(64) Row velocity; ///< and the inverse of the mass
    Row spin;                 ///< and the radius
};

struct Load
{
    alignas(64) Row force; ///< the fourth entries mean nothing
    Row torque;
};

struct ContactConstants
{
    alignas(64) Row normal; ///< k_n, eta_n, eta_n over the root of the effective mass, mu
    Row tangential;         ///< k_t, eta_t, eta_t over the root of the effective mass, 1/k_t (0 without spring)
};

/// What a pair's contact flag and spring are known to be
enum Contact : unsigned char
{
    OPEN = 0,
    TOUCHING = 1,
    UNSETTLED = 2 ///< as left by a rebuild of the neighbour list: part of the flags set
};

/// The pairs of LIGGGHTS' neighbour list one after the other, from one rebuild to the next. A multiple of four: filled
/// up with pairs that never touch.
struct ContactPairs
{
    std::vector<int> i, j;
    std::vector<unsigned char> contact; ///< a Contact
    std::vector<unsigned short> types;  ///< which constants
    std::vector<int> start;             ///< of each particle i: its first pair
};

struct ContactStep
{
    const Place* place;
    const Motion* motion;
    Load* load; ///< added to
    const ContactConstants* constants;
    bool oneConstants; ///< the same for all pairs
    bool friction;     ///< false: normal forces only
    double timestep;
    double parted; ///< squared distance over squared sum of radii up to which a spring ends
    int** flag;    ///< LIGGGHTS' contact flags and history of the pairs of each particle i
    double** history;
    int flagBits; ///< of a touching pair
    int stride;   ///< values of history a pair
    int offset;   ///< of the spring among them
};

/// Whether the processor has the registers this is written for (AVX2); without them it is slower than one by one.
bool canVectorise();

void contactForces(ContactPairs& pairs, const ContactStep& step);

} // namespace hotbed
