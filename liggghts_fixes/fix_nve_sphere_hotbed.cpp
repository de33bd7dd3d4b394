#include "liggghts.hpp"

#include "fix_nve_sphere_hotbed.h"

#include "fix_hotbed_drag.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

using namespace LAMMPS_NS;

namespace
{

/// LIGGGHTS' particles: n x 3 arrays are one block
struct Spheres
{
    int number;
    double *x, *v, *f, *omega;
    const double* torque;
    const double* gas; ///< [N], null: none
    const double* radius;
    const double* mass;
    const int* mask;
};

struct Step
{
    int groupbit;
    double drift, kick, turn; ///< dt; of v by f/m and of omega by torque/(m r^2)
    const double* gravity;    ///< [m/s2], null: f is complete
};

constexpr int width = 64;

/// Square of the longest way of any particle along each axis, [width][3] [m2]
using Peaks = double[3 * width];

/// Particles from `start` on, `width` at most. What a particle has one of is written out for its three components, so
/// that the loop over all components runs in vector registers.
template <bool second, bool first> inline void block(const Spheres& p, const Step& step, int start, Peaks& peaks)
{
    const int n = std::min(width, p.number - start);
    const double* __restrict mass = p.mass + start;
    const double* __restrict radius = p.radius + start;
    const int* __restrict mask = p.mask + start;
    double kick[3 * width], turn[3 * width], weight[3 * width];
    for (int i = 0; i < n; ++i)
    {
        const double in = mask[i] & step.groupbit ? 1.0 : 0.0;
        const double k = in * (step.kick / mass[i]), t = in * (step.turn / (radius[i] * radius[i] * mass[i]));
        for (int a = 0; a < 3; ++a) kick[3 * i + a] = k;
        for (int a = 0; a < 3; ++a) turn[3 * i + a] = t;
    }
    const double none[3] = {};
    const double* gravity = step.gravity ? step.gravity : none;
    for (int i = 0; i < n; ++i)
        for (int a = 0; a < 3; ++a) weight[3 * i + a] = mass[i] * gravity[a];
    if (p.gas)
        for (int k = 0; k < 3 * n; ++k) weight[k] += p.gas[3 * start + k];

    double* __restrict x = p.x + 3 * start;
    double* __restrict v = p.v + 3 * start;
    double* __restrict f = p.f + 3 * start;
    double* __restrict omega = p.omega + 3 * start;
    const double* __restrict torque = p.torque + 3 * start;
    double way[3 * width];
    const double drift = step.drift;
    for (int k = 0; k < 3 * n; ++k)
    {
        const double force = f[k] + weight[k];
        const double push = kick[k] * force, spin = turn[k] * torque[k];
        double velocity = v[k] + push, rotation = omega[k] + spin;
        if (second && first)
        {
            velocity += push;
            rotation += spin;
        }
        v[k] = velocity;
        omega[k] = rotation;
        if (first)
        {
            way[k] = (kick[k] > 0.0 ? drift : 0.0) * velocity;
            x[k] += way[k];
        }
        else
            f[k] = kick[k] > 0.0 ? force : f[k];
    }
    for (int k = 0; first && k < 3 * n; ++k) peaks[k] = std::max(peaks[k], way[k] * way[k]);
}

#define EVERY_PROCESSOR __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default"), flatten))

EVERY_PROCESSOR void firstHalf(const Spheres& p, const Step& step, Peaks& peaks)
{
    for (int start = 0; start < p.number; start += width) block<false, true>(p, step, start, peaks);
}

/// The complete force is left in f.
EVERY_PROCESSOR void secondHalf(const Spheres& p, const Step& step, Peaks& peaks)
{
    for (int start = 0; start < p.number; start += width) block<true, false>(p, step, start, peaks);
}

EVERY_PROCESSOR void secondAndFirstHalf(const Spheres& p, const Step& step, Peaks& peaks)
{
    for (int start = 0; start < p.number; start += width) block<true, true>(p, step, start, peaks);
}

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
    ahead_ = !seen();
    integrate(ahead_ ? SECOND_AND_FIRST : SECOND);
}

void FixNVESphereHotbed::integrate(Half half)
{
    if (half != SECOND && neighbor->ago == 0) std::fill_n(way_, 3, 0.0);
    if (atom->nlocal == 0) return;
    const bool loads = withGravity_ && half != FIRST;
    const Spheres spheres = {atom->nlocal,
                             atom->x[0],
                             atom->v[0],
                             atom->f[0],
                             atom->omega[0],
                             atom->torque[0],
                             loads && drag_ ? drag_->force()[0] : nullptr,
                             atom->radius,
                             atom->rmass,
                             atom->mask};
    const double inertia = domain->dimension == 2 ? 0.5 : 0.4; // of a disc, of a sphere, over m r^2
    const Step step = {groupbit, dtv, dtf, dtf / inertia, loads ? gravity_ : nullptr};
    Peaks peaks = {};
    half == FIRST    ? firstHalf(spheres, step, peaks)
    : half == SECOND ? secondHalf(spheres, step, peaks)
                     : secondAndFirstHalf(spheres, step, peaks);
    double peak[3] = {};
    for (int k = 0; k < 3 * width; ++k) peak[k % 3] = std::max(peak[k % 3], peaks[k]);
    for (int a = 0; a < 3; ++a) way_[a] += std::sqrt(peak[a]);
}
