#include "contact_models.h"
#include "fix_insert_stream.h"
#include "vectorised_pair.hpp"
#include "vectorised_wall.hpp"

#include "borders.hpp"
#include "contact_constants.hpp"
#include "contact_time.hpp"
#include "fix_nve_sphere_hotbed.h"
#include "integrate.h"
#include "timer.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

using namespace LAMMPS_NS;

namespace hotbed
{
namespace
{

constexpr int flagBits =
    LIGGGHTS::ContactModels::CONTACT_NORMAL_MODEL | LIGGGHTS::ContactModels::CONTACT_TANGENTIAL_MODEL;

/// Whether the integrator leaves the forces of the last step to be replaced; protected in LIGGGHTS.
struct Clearing : Integrate
{
    static int& byPairs(Integrate& integrate) { return integrate.*&Clearing::external_force_clear; }
};

/// Whether nothing is added to the forces before those of the pairs in a step. Of LIGGGHTS' fixes that do something
/// before them, these only make lists and properties.
bool pairsAreFirst(const LAMMPS& lmp, const PairGran* pair)
{
    const auto harmless = [](const std::string& style)
    {
        for (const char* known : {"wall/gran", "mesh/", "contacthistory/mesh", "neighlist/mesh", "heat/", "hotbed/"})
            if (style.rfind(known, 0) == 0) return true;
        return false;
    };
    if (lmp.force->pair != pair || lmp.neighbor->includegroup || lmp.atom->erforce_flag || lmp.atom->e_flag ||
        lmp.atom->rho_flag || lmp.cuda)
        return false;
    for (int i = 0; i < lmp.modify->nfix; ++i)
        if (lmp.modify->fmask[i] & FixConst::PRE_FORCE && !harmless(lmp.modify->fix[i]->style)) return false;
    return true;
}

/// What the integrator does before the forces of a step.
void clearForces(const Atom& atom)
{
    const std::size_t all = std::size_t(atom.nlocal + atom.nghost) * 3;
    if (all == 0) return;
    std::fill_n(atom.f[0], all, 0.0);
    std::fill_n(atom.torque[0], all, 0.0);
}

} // namespace

std::vector<char*> withoutKeyword(LAMMPS& lmp, int narg, char** arg, bool& vectorised)
{
    vectorised = true;
    std::vector<char*> others;
    for (int a = 0; a < narg; ++a)
    {
        if (std::strcmp(arg[a], "vectorised") != 0)
        {
            others.push_back(arg[a]);
            continue;
        }
        const std::string value = ++a < narg ? arg[a] : "";
        if (value != "on" && value != "off")
            lmp.error->all(FLERR, ("vectorised must be on or off, not '" + value + "'").c_str());
        vectorised = value == "on";
    }
    return others;
}

ContactParticles contactParticles(const Atom& atom)
{
    // LIGGGHTS keeps n x 3 arrays in one block behind row pointers
    const auto block = [](double** rows) { return reinterpret_cast<double(*)[3]>(rows[0]); };
    return {atom.nlocal,       atom.nlocal + atom.nghost,
            block(atom.x),     block(atom.v),
            block(atom.omega), atom.radius,
            atom.rmass,        block(atom.f),
            block(atom.torque)};
}

VectorisedPair::VectorisedPair(LAMMPS* lmp, PairGran* parent, int64_t hash)
    : PlainPair(lmp, parent, hash), lmp_(*lmp), parent_(parent), offset_(get_history_offset("hotbed_spring"))
{
}

void VectorisedPair::settings(int narg, char** arg, LIGGGHTS::IContactHistorySetup* setup)
{
    std::vector<char*> others = withoutKeyword(lmp_, narg, arg, enabled_);
    PlainPair::settings(int(others.size()), others.data(), setup);
}

void VectorisedPair::init_granular()
{
    PlainPair::init_granular();
    stale_ = true;
    first_ = pairsAreFirst(lmp_, parent_);
    Clearing::byPairs(*lmp_.update->integrate) = false;

    // the fixes are those that the plain loop asks about each contact
    Modify& modify = *lmp_.modify;
    plain_ = !enabled_ || !canVectorise() || modify.n_fixes_style_strict("freeze") > 0 ||
             modify.n_fixes_style("insert/stream/predefined") > 0 || modify.n_fixes_style("rigid") > 0;
    if (!plain_) borders_ = BothSides::install(lmp_);

    constants_ = contactTable(lmp_);
    friction_ =
        std::any_of(constants_.begin(), constants_.end(), [](const ContactConstants& c) { return c.normal[3] > 0.0; });
}

bool VectorisedPair::forcesOnly(PairGran& pair, int eflag, int vflag, int addflag) const
{
    return !eflag && !vflag && !addflag && pair.computeflag() && pair.shearupdate() && !pair.storeContactForces() &&
           !pair.storeContactForcesStress() && !pair.storeSumDelta() && !pair.store_sum_normal_force();
}

void VectorisedPair::takeList(PairGran& pair)
{
    const NeighList& list = *pair.list;
    int** flag = pair.listgranhistory->firstneigh;
    double** history = pair.listgranhistory->firstdouble;
    const int* type = lmp_.atom->type;
    const int types = lmp_.atom->ntypes;
    const int local = lmp_.atom->nlocal;
    pairs_.clear(pair.dnum());
    for (int n = 0; n < list.inum; ++n)
    {
        const int i = list.ilist[n];
        for (int k = 0; k < list.numneigh[i]; ++k)
        {
            const int j = list.firstneigh[i][k] & NEIGHMASK;
            const int bits = flag[i][k] & flagBits;
            double* spring = history[i] + std::size_t(pair.dnum()) * k + offset_;
            // without friction nothing keeps the springs of an earlier run, or of the plain loop, up to date
            if (bits && !friction_) std::fill_n(spring, 3, 0.0);
            pairs_.add(i, j, (unsigned short)((type[i] - 1) * types + type[j] - 1),
                       bits == 0          ? 0
                       : bits == flagBits ? TOUCHING
                                          : UNSETTLED,
                       &flag[i][k], spring);
        }
    }
    arrange(pairs_, local, local + lmp_.atom->nghost);
    stale_ = false;
}

/// The fix that may move particles in this step as soon as their forces are complete, null: none may.
FixNVESphereHotbed* VectorisedPair::movesEarly()
{
    const Modify& modify = *lmp_.modify;
    FixNVESphereHotbed* integration = nullptr;
    walls_.clear();
    std::vector<const Fix*> known;
    for (int i = 0; i < modify.nfix; ++i)
    {
        if (auto* one = dynamic_cast<FixNVESphereHotbed*>(modify.fix[i])) integration = one;
        auto* wall = dynamic_cast<VectorisedWall*>(modify.fix[i]);
        if (!wall || !wall->mayBeFirst()) continue;
        walls_.push_back(wall);
        known.push_back(wall);
    }
    return integration && !lmp_.atom->molecular && integration->movesEarly(known) ? integration : nullptr;
}

/// Particles get the forces of walls and move while those of their pairs are in the cache.
void VectorisedPair::forcesAndMotion(ContactStep& step, FixNVESphereHotbed& integration)
{
    // as LIGGGHTS takes the time of fixes, of which none is that of pairs
    double others = 0.0;
    const auto timed = [&others](Fix& fix, const auto& work)
    {
        others -= fix.get_recorded_time();
        fix.begin_time_recording();
        work();
        fix.end_time_recording();
        others += fix.get_recorded_time();
    };
    for (VectorisedWall* wall : walls_) timed(*wall, [&] { wall->compute(); });
    double force[completeAtOnce + 1][3], torque[completeAtOnce + 1][3];
    ContactParticles particles = contactParticles(*lmp_.atom);
    particles.force = force;
    particles.torque = torque;
    step.complete = [&](int first, int end)
    {
        for (VectorisedWall* wall : walls_) wall->give(first, end, force, torque);
        timed(integration, [&] { integration.moveEarly(first, end, force[0], torque[0]); });
        if (borders_) borders_->packEarly(first, end);
    };
    contactForces(particles, pairs_, step, rows_);
    lmp_.timer->array[TIME_PAIR] -= others;
}

/// Ends the run with an error where the contact of the lightest particles is too short for the time step.
void VectorisedPair::checkTimestep()
{
    const double dt = lmp_.update->dt;
    for (const ContactTime& contact : contactTimes(lmp_, constants_))
    {
        const bool refused = contact.steps < contact.least;
        if (!refused && (warned_ || contact.steps > 2.0 * contact.least)) continue;
        const double share = contact.steps / (refused ? contact.least : 2.0 * contact.least);
        char text[512];
        std::snprintf(text, sizeof text,
                      "pair_style gran model hotbed: the contact of the lightest particles of types %d and %d has "
                      "%.3g time steps, %s: set timestep to at most %.3g (it is %.3g), or kn to at most %.3g times "
                      "what it is",
                      contact.first, contact.second, contact.steps,
                      refused ? "too few: the particles would gain energy from nothing"
                              : "few: restitution and packing are inaccurate",
                      dt * share, dt, share * share);
        if (refused) lmp_.error->all(FLERR, text);
        if (lmp_.comm->me == 0) lmp_.error->warning(FLERR, text);
        warned_ = true;
    }
}

void VectorisedPair::compute_force(PairGran* pair, int eflag, int vflag, int addflag)
{
    if (lmp_.neighbor->ago == 0) checkTimestep(); // particles may have been added
    int& cleared = Clearing::byPairs(*lmp_.update->integrate);
    if (plain_ || !forcesOnly(*pair, eflag, vflag, addflag))
    {
        if (cleared && pair->computeflag())
        {
            clearForces(*lmp_.atom);
            cleared = false;
        }
        stale_ = true; // the flags change without our knowing
        PlainPair::compute_force(pair, eflag, vflag, addflag);
        return;
    }
    cleared = first_ && lmp_.update->ntimestep != lmp_.update->laststep; // another pair_style may follow
    pair->evflag = pair->vflag_fdotr = 0;
    if (stale_ || lmp_.neighbor->ago == 0) takeList(*pair);

    if (lmp_.atom->nlocal == 0) return;
    ContactStep step;
    step.constants = constants_.data();
    step.oneConstants = constants_.size() == 1;
    step.friction = friction_;
    step.add = !first_;
    step.timestep = lmp_.update->dt;
    step.parted = lmp_.neighbor->contactDistanceFactor * lmp_.neighbor->contactDistanceFactor;
    step.flagBits = flagBits;
    if (FixNVESphereHotbed* const integration = cleared ? movesEarly() : nullptr)
        forcesAndMotion(step, *integration);
    else
        contactForces(contactParticles(*lmp_.atom), pairs_, step, rows_);
}

} // namespace hotbed
