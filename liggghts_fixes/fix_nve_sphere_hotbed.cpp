#include "liggghts.hpp"

#include "fix_nve_sphere_hotbed.h"

#include "fix_hotbed_drag.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

using namespace LAMMPS_NS;
using namespace hotbed;

namespace
{

constexpr int never = std::numeric_limits<int>::max();

} // namespace

FixNVESphereHotbed::FixNVESphereHotbed(LAMMPS* lmp, int narg, char** arg) : FixNVESphere(lmp, 3, arg)
{
    if (narg == 3) return;
    if (narg != 9 || std::strcmp(arg[3], "gravity") != 0 || std::strcmp(arg[5], "vector") != 0)
        error->fix_error(FLERR, this, "expecting 'gravity g vector x y z' or nothing");
    const hotbed::Range range = {-1e6, true, 1e6};
    const double g = hotbed::number(*error, *this, "gravity", arg[4], range, "m/s2");
    for (int a = 0; a < 3; ++a)
    {
        gravity_[a] = hotbed::number(*error, *this, "vector", arg[6 + a], range, "-");
        if (a >= domain->dimension) gravity_[a] = 0.0;
    }
    const double length = std::hypot(gravity_[0], gravity_[1], gravity_[2]);
    if (!(length > 0.0))
        error->fix_error(FLERR, this, "the vector of gravity has no length: one of its components must not be 0");
    for (double& a : gravity_) a *= g / length;
    withGravity_ = true;
}

int FixNVESphereHotbed::setmask()
{
    return FixConst::INITIAL_INTEGRATE | FixConst::FINAL_INTEGRATE;
}

void FixNVESphereHotbed::init()
{
    FixNVESphere::init();
    if (std::strstr(update->integrate_style, "verlet") == nullptr)
        error->fix_error(FLERR, this, "needs 'run_style verlet'");
    ahead_ = false;
    drag_ = nullptr;
    movesAll_ = !domain->box_change && !atom->radvary_flag;
    for (int i = 0; i < modify->nfix; ++i)
        movesAll_ = movesAll_ && (modify->fix[i] == this || !(modify->fmask[i] & FixConst::INITIAL_INTEGRATE));
    if (!withGravity_) return;

    if (modify->n_fixes_style("gravity") > 0)
        error->fix_error(FLERR, this, "has gravity, and so has fix gravity: leave one of them out");
    // they hold or look at the sum of the forces, which is complete only after them
    for (const char* other :
         {"freeze", "setforce", "lineforce", "planeforce", "aveforce", "store/force", "rigid", "multisphere", "relax"})
        if (modify->n_fixes_style(other) > 0)
            error->fix_error(FLERR, this,
                             (std::string("adds gravity after fix ") + other +
                              " has seen the forces: use fix gravity instead of the keyword")
                                 .c_str());
    for (int i = 0; i < modify->nfix; ++i)
        if (auto* drag = dynamic_cast<FixHotbedDrag*>(modify->fix[i]))
            if (addsForceOf(*drag)) drag_ = drag;
}

/// The forces of the run's start: fix hotbed/drag adds its own then.
void FixNVESphereHotbed::setup(int)
{
    ahead_ = false;
    if (withGravity_)
        for (int i = 0; i < atom->nlocal; ++i)
            if (atom->mask[i] & groupbit)
                for (int a = 0; a < 3; ++a) atom->f[i][a] += atom->rmass[i] * gravity_[a];
}

/// Whether anybody looks at the particles at the end of this time step.
bool FixNVESphereHotbed::seen() const
{
    const bigint now = update->ntimestep;
    if (now == output->next || now == update->laststep || now == stop_ || modify->n_pre_initial_integrate > 0)
        return true;
    for (int i = 0; i < modify->nfix; ++i)
        if ((modify->fmask[i] & FixConst::END_OF_STEP) && now % modify->fix[i]->nevery == 0) return true;
    return false;
}

void FixNVESphereHotbed::initial_integrate(int)
{
    if (!ahead_) integrate(FIRST);
    ahead_ = false;
    delayCheck();
}

/// LIGGGHTS looks at every particle in every step whether it is half a skin away from where the neighbour lists were
/// built. As long as the way of the fastest one at each step is shorter, none can be.
void FixNVESphereHotbed::delayCheck()
{
    if (!movesAll_ || !neighbor->dist_check) return;
    if (neighbor->delay != never) delay_ = neighbor->delay;
    const int mine = std::hypot(way_[0], way_[1], way_[2]) > 0.499 * neighbor->skin;
    int any;
    MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
    neighbor->delay = any ? delay_ : never;
}

void FixNVESphereHotbed::post_run()
{
    if (neighbor->delay == never) neighbor->delay = delay_;
}

void FixNVESphereHotbed::final_integrate()
{
    ahead_ = moved_ || !seen();
    integrate(ahead_ ? SECOND_AND_FIRST : SECOND);
}

bool FixNVESphereHotbed::movesEarly(const std::vector<const Fix*>& known) const
{
    if (!movesAll_ || seen()) return false;
    constexpr int late = FixConst::POST_FORCE | FixConst::PRE_FINAL_INTEGRATE | FixConst::FINAL_INTEGRATE;
    for (int i = 0; i < modify->nfix; ++i)
    {
        const Fix* const fix = modify->fix[i];
        if (modify->fmask[i] & late && fix != this && fix != drag_ &&
            std::find(known.begin(), known.end(), fix) == known.end())
            return false;
    }
    return true;
}

MovingParticles FixNVESphereHotbed::particles(Half half) const
{
    return {atom->nlocal,
            atom->x[0],
            atom->v[0],
            atom->f[0],
            atom->omega[0],
            atom->torque[0],
            drag_ && half != FIRST ? drag_->force()[0] : nullptr,
            atom->radius,
            atom->rmass,
            atom->mask};
}

MotionStep FixNVESphereHotbed::motion(Half half) const
{
    const double inertia = domain->dimension == 2 ? 0.5 : 0.4; // of a disc, of a sphere, over m r^2
    return {groupbit, dtv, dtf, dtf / inertia, withGravity_ && half != FIRST ? gravity_ : nullptr};
}

void FixNVESphereHotbed::moveEarly(int first, int end, double* force, const double* torque)
{
    const std::size_t rows = 3 * std::size_t(first);
    MovingParticles some = particles(SECOND_AND_FIRST);
    some.number = end - first;
    for (double** moved : {&some.x, &some.v, &some.omega}) *moved += rows;
    some.force = force;
    some.torque = torque;
    if (some.gas) some.gas += rows;
    some.radius += first;
    some.mass += first;
    some.mask += first;
    move(SECOND_AND_FIRST, some, motion(SECOND_AND_FIRST), earlySquared_);
    moved_ = true;
}

void FixNVESphereHotbed::integrate(Half half)
{
    if (half != SECOND && neighbor->ago == 0) std::fill_n(way_, 3, 0.0);
    if (atom->nlocal == 0) return;
    double squared[3] = {};
    if (std::exchange(moved_, false))
        std::swap(squared, earlySquared_);
    else
        move(half, particles(half), motion(half), squared);
    for (int a = 0; a < 3; ++a) way_[a] += std::sqrt(squared[a]);
}
