#include "contact_models.h"
#include "fix_insert_stream.h"
#include "vectorised_pair.hpp"
#include "vectorised_wall.hpp"

#include "contact_constants.hpp"
#include "fix_wall_gran_base.h"
#include "primitive_wall.h"

#include <algorithm>
#include <utility>

using namespace LAMMPS_NS;

namespace hotbed
{
namespace
{

/// Particles that are fetched before it is their turn
constexpr int ahead = 32;

using PlainWall = LIGGGHTS::Walls::Granular<ContactModel>;

/// LIGGGHTS' own wall with the law, and the keyword
class WallModel : public PlainWall
{
public:
    WallModel(LAMMPS* lmp, FixWallGran* parent, int64_t hash) : PlainWall(lmp, parent, hash), lmp_(*lmp) {}

    void settings(int narg, char** arg, LIGGGHTS::IContactHistorySetup* setup) override
    {
        std::vector<char*> others = withoutKeyword(lmp_, narg, arg, vectorised);
        PlainWall::settings(int(others.size()), others.data(), setup);
    }

    bool vectorised = true;

private:
    LAMMPS& lmp_;
};

} // namespace

LIGGGHTS::Walls::IGranularWall* makeWallModel(LAMMPS* lmp, FixWallGran* parent, int64_t hash)
{
    return new WallModel(lmp, parent, hash);
}

void VectorisedWall::init()
{
    FixWallGran::init();
    const auto* model = dynamic_cast<WallModel*>(impl);
    // a history of three values is the spring and nothing else; only planes have no axis
    vectorised_ = model && model->vectorised && canVectorise() && meshwall_ == 0 && dnum_ == 3 &&
                  primitiveWall_->axis() < 0 && !shear_ && !atom->shapetype_flag && !atom->superquadric_flag;
    if (!vectorised_) return;
    offset_ = get_history_offset("hotbed_spring");
    const std::vector<ContactConstants> table = contactTable(*lmp);
    constants_.clear();
    for (int i = 0; i < atom->ntypes; ++i)
        constants_.push_back(table[std::size_t(i) * atom->ntypes + atom_type_wall_ - 1]);
}

bool VectorisedWall::forcesOnly() const
{
    return computeflag_ && shearupdate_ && !addflag_ && !store_force_ && !store_force_contact_ &&
           !store_force_contact_stress_ && !heattransfer_flag_ && !fix_rigid_ && !fix_store_multicontact_data_ &&
           !fix_sum_normal_force_;
}

void VectorisedWall::post_force_primitive(int vflag)
{
    if (std::exchange(computed_, false)) return;
    if (!vectorised_ || !forcesOnly())
    {
        FixWallGran::post_force_primitive(vflag);
        return;
    }
    nearForces();
    if (contacts_.empty()) return;
    const ContactParticles particles = contactParticles(*atom);
    give(0, particles.local, particles.force, particles.torque);
}

void VectorisedWall::compute()
{
    nearForces();
    computed_ = true;
}

void VectorisedWall::give(int first, int end, double (*force)[3], double (*torque)[3])
{
    const std::size_t count = contacts_.size();
    for (; given_ < count && contacts_[given_].particle < end; ++given_)
    {
        const int soon = contacts_[std::min(given_ + ahead, count - 1)].particle - first;
        __builtin_prefetch(force[soon], 1);
        __builtin_prefetch(torque[soon], 1);
        const WallContact& contact = contacts_[given_];
        for (int a = 0; a < 3; ++a)
        {
            force[contact.particle - first][a] += contact.force[a];
            torque[contact.particle - first][a] += contact.torque[a];
        }
    }
}

void VectorisedWall::nearForces()
{
    contacts_.clear();
    given_ = 0;
    int* near = nullptr;
    const int count = primitiveWall_->getNeighbors(near);
    if (count == 0) return;
    const ContactParticles particles = contactParticles(*atom);
    double* const springs = fix_history_primitive_->array_atom[0] + offset_;
    const bool all = groupbit == 1, alike = constants_.size() == 1;
    for (int k = 0; k < count; ++k)
    {
        const int soon = near[std::min(k + ahead, count - 1)]; // near particles lie anywhere in the memory
        __builtin_prefetch(particles.x[soon]);
        __builtin_prefetch(particles.radius + soon);
        const int i = near[k];
        if (!all && !(atom->mask[i] & groupbit)) continue;
        double* const spring = springs + std::size_t(dnum_) * i;
        double x[3] = {particles.x[i][0], particles.x[i][1], particles.x[i][2]}, toWall[3];
        if (primitiveWall_->resolveContact(x, particles.radius[i], toWall) <= 0.0)
            contacts_.push_back(
                WallContact{{-toWall[0], -toWall[1], -toWall[2]}, spring, i, alike ? 0 : atom->type[i] - 1, {}, {}});
        else
            std::fill_n(spring, 3, 0.0);
    }
    if (!contacts_.empty()) wallForces(particles, contacts_, constants_.data(), update->dt);
}

} // namespace hotbed
