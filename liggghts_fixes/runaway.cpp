#include "liggghts.hpp"

#include "runaway.hpp"

#include <cmath>
#include <sstream>

using namespace LAMMPS_NS;

namespace hotbed
{
namespace
{

double squared(const double* v)
{
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

} // namespace

std::string describe(const LAMMPS& lmp, int particle)
{
    const double* x = lmp.atom->x[particle];
    const double* v = lmp.atom->v[particle];
    std::ostringstream text;
    text << "particle " << lmp.atom->tag[particle] << " at (" << x[0] << ' ' << x[1] << ' ' << x[2]
         << ") m with velocity (" << v[0] << ' ' << v[1] << ' ' << v[2] << ") m/s";
    return text.str();
}

std::string fastest(const LAMMPS& lmp)
{
    if (lmp.atom->nlocal == 0) return {};
    int first = 0;
    for (int i = 1; i < lmp.atom->nlocal; ++i)
        if (!(squared(lmp.atom->v[i]) <= squared(lmp.atom->v[first]))) first = i; // one that is not finite stays
    return describe(lmp, first);
}

void refuseRunaways(const LAMMPS& lmp)
{
    // without contacts a step may be any number of radii long
    const double step = lmp.force->pair ? lmp.update->dt : 0.0;
    const double* radius = lmp.atom->radius;
    for (int i = 0; i < lmp.atom->nlocal; ++i)
    {
        const double* x = lmp.atom->x[i];
        // the sum is not finite where one of them is not
        if (squared(lmp.atom->v[i]) * step * step + 0.0 * (x[0] + x[1] + x[2]) <= radius[i] * radius[i]) continue;
        std::ostringstream text;
        text << describe(lmp, i) << " blew up at DEM step " << lmp.update->ntimestep
             << ": it moves by more than its radius (" << radius[i] << " m) in a DEM step of " << lmp.update->dt
             << " s. Likely particles were made or inserted on top of each other, a wall or the gas pushed it too "
                "hard, or the contacts are too stiff for the DEM step: look at it in the dumps; a shorter timestep or "
                "a softer kn in the DEM script helps where they are too stiff. The restarts written before are whole";
        lmp.error->one(FLERR, text.str().c_str());
    }
}

} // namespace hotbed
