#include "liggghts.hpp"

#include "fix_hotbed_balance.h"

#include "slabs.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

using namespace LAMMPS_NS;

FixHotbedBalance::FixHotbedBalance(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
    if (hotbed::anotherOfStyle(*modify, *this))
        error->fix_error(FLERR, this, "the particles are shared out already by another fix hotbed/balance");
    if (narg != 3 && (narg != 5 || std::strcmp(arg[3], "every") != 0))
        error->fix_error(FLERR, this, "expecting 'every N' or nothing after the style");
    if (narg == 5)
    {
        const hotbed::Range range = {1, true, 1e9};
        double steps;
        if (!range.read(arg[4], steps) || steps != std::floor(steps))
            error->fix_error(
                FLERR, this,
                ("every must be a whole number " + range.text() + " [DEM steps], not '" + arg[4] + "'").c_str());
        every_ = int(steps);
    }
    force_reneighbor = 1;
    next_reneighbor = update->ntimestep + 1;
    box_change_domain = 1; // LIGGGHTS renews ghosts, bins and the elements of mesh walls together with neighbour lists
}

int FixHotbedBalance::setmask()
{
    return FixConst::PRE_EXCHANGE;
}

/// Before particles change ranks.
void FixHotbedBalance::pre_exchange()
{
    if (update->ntimestep < next_reneighbor) return;
    next_reneighbor = update->ntimestep + every_;
    double* planes[3] = {comm->xsplit, comm->ysplit, comm->zsplit};
    for (int axis = 0; axis < 3; ++axis)
        if (comm->procgrid[axis] > 1) move(axis, planes[axis]);
    comm->uniform = 0;
}

void FixHotbedBalance::move(int axis, double* planes) const
{
    std::vector<double> count(1000, 0.0);
    const int last = int(count.size()) - 1;
    for (int i = 0; i < atom->nlocal; ++i)
    {
        const double place = (atom->x[i][axis] - domain->boxlo[axis]) / domain->prd[axis];
        ++count[place > 0.0 ? std::size_t(std::min(place * (last + 1), double(last))) : 0];
    }
    MPI_Allreduce(MPI_IN_PLACE, count.data(), last + 1, MPI_DOUBLE, MPI_SUM, world);
    hotbed::moveTowardsEqualShares(planes, comm->procgrid[axis], count, comm->cutghost[axis] / domain->prd[axis]);
}
