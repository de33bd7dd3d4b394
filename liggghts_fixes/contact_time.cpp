#include "liggghts.hpp"

#include "contact_time.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace LAMMPS_NS;

namespace hotbed
{
namespace
{

/// Steps that the contact of two particles must have so that a dense packing of such contacts cannot gain energy. The
/// stiffest motion of a face-centred cubic packing has twice the frequency and twice the damping ratio of one contact;
/// the integration (forces with the velocity of half a step before) holds up to frequency * step =
/// 2 (sqrt(1 + ratio^2) - ratio). Found so by trial too, see docs/pair_gran_hotbed.md; a fifth more is asked for.
/// @param damping  damping ratio of the contact
double leastSteps(double damping)
{
    return 1.2 * M_PI * (std::sqrt(1.0 + 4.0 * damping * damping) + 2.0 * damping);
}

} // namespace

std::vector<ContactTime> contactTimes(LAMMPS& lmp, const std::vector<ContactConstants>& constants)
{
    const Atom& atom = *lmp.atom;
    const double none = std::numeric_limits<double>::max();
    std::vector<double> lightest(std::size_t(atom.ntypes), none);
    for (int i = 0; i < atom.nlocal; ++i)
        lightest[atom.type[i] - 1] = std::min(lightest[atom.type[i] - 1], atom.rmass[i]);
    MPI_Allreduce(MPI_IN_PLACE, lightest.data(), atom.ntypes, MPI_DOUBLE, MPI_MIN, lmp.world);

    std::vector<ContactTime> times;
    for (int i = 0; i < atom.ntypes; ++i)
        for (int j = i; j < atom.ntypes; ++j)
        {
            const Row& c = constants[std::size_t(i) * atom.ntypes + j].normal;
            if (lightest[i] == none || lightest[j] == none || !(c[0] > 0.0)) continue;
            const double mass = lightest[i] * lightest[j] / (lightest[i] + lightest[j]);
            const double damping = (c[1] + c[2] * std::sqrt(mass)) / (2.0 * std::sqrt(c[0] * mass));
            times.push_back({i + 1, j + 1, M_PI * std::sqrt(mass / c[0]) / lmp.update->dt, leastSteps(damping), c[3]});
        }
    return times;
}

} // namespace hotbed
