#pragma once

/// The contact law `hotbed` of pairs of particles. Include after what pair_gran_base.h wants to be included before it.

#include "contact_kernel.hpp"

#include "pair_gran_base.h"

#include <vector>

namespace LAMMPS_NS
{
class FixNVESphereHotbed;
}

namespace hotbed
{

using ContactStyle =
    LIGGGHTS::ContactModels::GranStyle<LIGGGHTS::ContactModels::HOTBED_NORMAL,
                                       LIGGGHTS::ContactModels::HOTBED_TANGENTIAL,
                                       LIGGGHTS::ContactModels::COHESION_OFF, LIGGGHTS::ContactModels::ROLLING_OFF,
                                       LIGGGHTS::ContactModels::SURFACE_DEFAULT>;
using ContactModel = LIGGGHTS::ContactModels::ContactModel<ContactStyle>;
using PlainPair = LIGGGHTS::PairStyles::Granular<ContactModel>;

/// Takes the keyword `vectorised on|off` out of a model's settings. @return the others
std::vector<char*> withoutKeyword(LAMMPS_NS::LAMMPS& lmp, int narg, char** arg, bool& vectorised);

/// At least one particle is local.
ContactParticles contactParticles(const LAMMPS_NS::Atom& atom);

/// LIGGGHTS' own loop over the contact models (PlainPair), and beside it a loop of ours that computes forces and
/// torques alone, many pairs at a time. Neighbour lists, contact flags and history are LIGGGHTS'; both loops leave the
/// same in them, so a step takes the plain one wherever more than forces is asked for.
class VectorisedPair : public PlainPair
{
public:
    VectorisedPair(LAMMPS_NS::LAMMPS* lmp, LAMMPS_NS::PairGran* parent, int64_t hash);

    void settings(int narg, char** arg, LIGGGHTS::IContactHistorySetup* setup) override;
    void init_granular() override;
    void compute_force(LAMMPS_NS::PairGran* pair, int eflag, int vflag, int addflag) override;

private:
    bool forcesOnly(LAMMPS_NS::PairGran& pair, int eflag, int vflag, int addflag) const;
    void takeList(LAMMPS_NS::PairGran& pair);
    void checkTimestep();
    LAMMPS_NS::FixNVESphereHotbed* movesEarly();
    void forcesAndMotion(ContactStep& step, LAMMPS_NS::FixNVESphereHotbed& integration);

    LAMMPS_NS::LAMMPS& lmp_;
    LAMMPS_NS::PairGran* const parent_;
    const int offset_;    ///< of the spring in a pair's history
    bool enabled_ = true; ///< by the script
    bool plain_ = false;  ///< all steps take the plain loop
    bool friction_ = true;
    bool warned_ = false;
    bool stale_ = true;  ///< pairs_ is not the present neighbour list
    bool first_ = false; ///< nothing adds to the forces of a step before: they are set, not added to
    std::vector<ContactConstants> constants_;
    ContactPairs pairs_;
    ContactRows rows_;
    class BothSides* borders_ = nullptr;       ///< null: LIGGGHTS' own
    std::vector<class VectorisedWall*> walls_; ///< whose forces come before those of pairs in this step
};

} // namespace hotbed
