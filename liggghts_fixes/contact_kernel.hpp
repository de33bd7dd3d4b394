#pragma once

/// Forces of all touching pairs by eq 18 and 19, the same law as normal_model_hotbed.h with tangential_model_hotbed.h,
/// for many pairs at a time. Knows arrays only; vectorised_pair.hpp fills them from LIGGGHTS.

#include <cstddef>
#include <functional>
#include <vector>

namespace hotbed
{

using Row = double __attribute__((vector_size(32)));

struct ContactConstants
{
    alignas(64) Row normal; ///< k_n, eta_n, eta_n over the root of the effective mass, mu
    Row tangential;         ///< k_t, eta_t, eta_t over the root of the effective mass, 1/k_t (0 without spring)
};

/// What a pair's contact flag and spring are known to be: bits of the first of four pairs in ContactPairs::contact,
/// those of the others are next to them. None: apart, no spring
enum Contact : unsigned char
{
    TOUCHING = 1,
    UNSETTLED = 16 ///< as left by a rebuild of the neighbour list: part of the flags set
};

/// Pairs that are looked through in one go, whose flags and springs lie one behind the other
struct PairBlock
{
    int first, end; ///< pairs, both multiples of four
    int entered;    ///< the local particle behind all that its pairs, and those before, are of
    int left;       ///< the local particle before which all are done with after it
    int* flag;      ///< LIGGGHTS' contact flags: where that of the very first pair would be
    double* spring; ///< and springs, likewise
};

/// The pairs of LIGGGHTS' neighbour list one after the other, from one rebuild to the next, looked at four at a time.
/// Among them, behind a block, and behind all are pairs of two particles that are nowhere, which fill up the last four.
struct ContactPairs
{
    /// A pair whose flag and spring wait for the end of the step
    struct Change
    {
        int* flag;
        double* spring;
        bool touches;
    };

    std::vector<int> i, j;              ///< particles; from arrange() on their rows
    std::vector<unsigned char> contact; ///< of four pairs
    std::vector<unsigned short> types;  ///< which constants
    std::vector<PairBlock> blocks;
    std::vector<Change> changed;
    int stride = 3; ///< from a spring to the next one
    int ring = 1;   ///< rows of local particles; those of ghosts follow

    void clear(int springStride);
    /// @param known  bits of Contact
    void add(int first, int second, unsigned short type, unsigned known, int* flag, double* spring);
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

/// The most particles that ContactStep::complete is told of: what is read and written of them stays in the nearest
/// cache.
constexpr int completeAtOnce = 256;

struct ContactStep
{
    const ContactConstants* constants;
    bool oneConstants; ///< the same for all pairs
    bool friction;     ///< false: normal forces only
    bool add;          ///< to forces and torques that are there; false: these are set, also those of no pair
    double timestep;
    double parted; ///< squared distance over squared sum of radii up to which a spring ends
    int flagBits;  ///< of a touching pair
    /// Told of local particles [first, end), in their order, once they have all that pairs give them; nothing reads
    /// them afterwards. ContactParticles::force and torque are those of [first, end) then, completeAtOnce + 1 rows.
    /// Not with `add`. Empty: they are those of all particles.
    std::function<void(int first, int end)> complete;
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
    std::vector<Place> place; ///< behind the last one: two particles that are nowhere
    std::vector<Motion> motion;
    std::vector<Load> load;
};

/// A particle that touches a wall at rest
struct WallContact
{
    double from[3]; ///< from the wall to the centre
    double* spring;
    int particle;
    int type;                   ///< which constants
    double force[3], torque[3]; ///< on the particle, from wallForces()
};

/// Whether the processor has the registers this is written for (AVX2); without them it is slower than one by one.
bool canVectorise();

/// Springs are carried on; nothing is added to the particles.
/// @param constants  of each type of WallContact
void wallForces(const ContactParticles& particles, std::vector<WallContact>& contacts,
                const ContactConstants* constants, double timestep);

/// Rows of pairs that are known by their particles yet: after the last one is added.
/// @param local  particles, of `all`
void arrange(ContactPairs& pairs, int local, int all);

void contactForces(const ContactParticles& particles, ContactPairs& pairs, const ContactStep& step, ContactRows& rows);

} // namespace hotbed
