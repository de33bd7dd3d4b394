#pragma once

/// Forces of all touching pairs by eq 18 and 19, the same law as normal_model_hotbed.h with tangential_model_hotbed.h,
/// for many pairs at a time. Knows arrays only; vectorised_pair.hpp fills them from LIGGGHTS.

#include <cstddef>
#include <vector>

namespace hotbed
{

using Row = double __attribute__((vector_size(32)));

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

/// Pairs that are looked through in one go
struct PairBlock
{
    int end;     ///< the pair behind its last one
    int entered; ///< the local particle behind all that its pairs, and those before, are of
    int left;    ///< the local particle before which all are done with after it
};

/// The pairs of LIGGGHTS' neighbour list one after the other, from one rebuild to the next. A multiple of four: filled
/// up with pairs of the particle behind the last one.
struct ContactPairs
{
    std::vector<int> i;
    std::vector<int> j;                 ///< its row, from arrange() on
    std::vector<unsigned char> contact; ///< a Contact
    std::vector<unsigned short> types;  ///< which constants
    std::vector<int> start;             ///< of each particle i: its first pair
    std::vector<PairBlock> blocks;
    int ring = 1; ///< rows of local particles, a power of two; those of ghosts follow
};

/// LIGGGHTS' particles: local ones first, then ghosts
struct ContactParticles
{
    int local, all;
    const double (*x)[3];
    const double (*v)[3];
    const double (*omega)[3];
    const double* radius;
    const double* mass;
    double (*force)[3]; ///< of local particles: a ghost's are those of its owner's rank
    double (*torque)[3];
};

struct ContactStep
{
    const ContactConstants* constants;
    bool oneConstants; ///< the same for all pairs
    bool friction;     ///< false: normal forces only
    bool add;          ///< to forces and torques that are there; false: these are set, also those of no pair
    double timestep;
    double parted; ///< squared distance over squared sum of radii up to which a spring ends
    int** flag;    ///< LIGGGHTS' contact flags and history of the pairs of each particle i
    double** history;
    int flagBits; ///< of a touching pair
    int stride;   ///< values of history a pair
    int offset;   ///< of the spring among them
};

/// The particles as the kernel wants them, a row of four numbers at a time. LIGGGHTS sorts particles by their places
/// and lists a pair with the earlier one, so a pass over the pairs needs only the rows of particles that are a layer or
/// two apart: local ones take turns in a ring of rows, which stays in the cache. Kept between steps for its memory
/// only.
struct ContactRows
{
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
    std::vector<Place> place; ///< behind the last one: a particle that is nowhere
    std::vector<Motion> motion;
    std::vector<Load> load;
};

/// A particle that touches a wall at rest
struct WallContact
{
    double from[3]; ///< from the wall to the centre
    double* spring;
    int particle;
    int type; ///< which constants
};

/// Whether the processor has the registers this is written for (AVX2); without them it is slower than one by one.
bool canVectorise();

/// Forces and torques are added to, springs carried on.
/// @param constants  of each type of WallContact
void wallForces(const ContactParticles& particles, const std::vector<WallContact>& contacts,
                const ContactConstants* constants, double timestep);

/// Blocks and rows of pairs whose j are particles yet.
void arrange(ContactPairs& pairs, int local);

void contactForces(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows);

} // namespace hotbed
