// Read by LIGGGHTS' model lists as well as as a header, hence the two halves.
#ifdef TANGENTIAL_MODEL
TANGENTIAL_MODEL(HOTBED_TANGENTIAL, hotbed, 40)
#else
#ifndef TANGENTIAL_MODEL_HOTBED_H
#define TANGENTIAL_MODEL_HOTBED_H
#include "contact_models.h"
#include "tangential_model_base.h"

#include "contact_constants.hpp"

namespace LIGGGHTS
{
namespace ContactModels
{

/// Tangential spring and dashpot with Coulomb's limit on their SUM, eq 19. Beyond the limit the force keeps the
/// direction of spring plus dashpot and the spring is shortened to what that force leaves, so that nothing jumps where
/// sliding turns into sticking (the paper takes the direction of the sliding velocity and says nothing of the spring).
template <> class TangentialModel<HOTBED_TANGENTIAL> : public TangentialModelBase
{
public:
    TangentialModel(LAMMPS* lmp, IContactHistorySetup* hsetup, class ContactModelBase* c)
        : TangentialModelBase(lmp, hsetup, c), offset_(hsetup->add_history_value("shearx", "1"))
    {
        hsetup->add_history_value("sheary", "1");
        hsetup->add_history_value("shearz", "1");
        c->add_history_offset("hotbed_spring", offset_);
    }

    void registerSettings(Settings&) {}
    void postSettings(IContactHistorySetup*, ContactModelBase*) {}
    void connectToProperties(PropertyRegistry& registry)
    {
        hotbed::connect(registry, "hotbed_friction", &hotbed::friction, friction_, "tangential hotbed");
    }

    void surfacesIntersect(const SurfacesIntersectData& s, ForceData& i, ForceData& j)
    {
        if (s.contact_flags) *s.contact_flags |= CONTACT_TANGENTIAL_MODEL;
        double* spring = &s.contact_history[offset_];
        const double velocity[3] = {s.vtr1, s.vtr2, s.vtr3};
        const bool update = s.computeflag && s.shearupdate;
        double stretch[3] = {spring[0], spring[1], spring[2]};
        if (update)
        {
            // turned with the contact plane, keeping its length
            const double before = stretch[0] * stretch[0] + stretch[1] * stretch[1] + stretch[2] * stretch[2];
            const double out = stretch[0] * s.en[0] + stretch[1] * s.en[1] + stretch[2] * s.en[2];
            for (int a = 0; a < 3; ++a) stretch[a] -= out * s.en[a];
            const double after = stretch[0] * stretch[0] + stretch[1] * stretch[1] + stretch[2] * stretch[2];
            const double scale = after > 0.0 ? std::sqrt(before / after) : 0.0;
            for (int a = 0; a < 3; ++a) stretch[a] = scale * stretch[a] + velocity[a] * update_dt();
        }
        double force[3], square = 0.0;
        for (int a = 0; a < 3; ++a)
        {
            force[a] = -s.kt * stretch[a] - s.gammat * velocity[a];
            square += force[a] * force[a];
        }
        const double limit = friction_[s.itype][s.jtype] * std::abs(s.Fn);
        if (square > limit * limit)
        {
            const double ratio = limit / std::sqrt(square);
            for (int a = 0; a < 3; ++a)
            {
                force[a] *= ratio;
                if (s.kt > 0.0) stretch[a] = -(force[a] + s.gammat * velocity[a]) / s.kt;
            }
        }
        if (update)
            for (int a = 0; a < 3; ++a) spring[a] = stretch[a];

        const double turn[3] = {s.en[1] * force[2] - s.en[2] * force[1], s.en[2] * force[0] - s.en[0] * force[2],
                                s.en[0] * force[1] - s.en[1] * force[0]};
        const double area = s.is_wall ? s.area_ratio : 1.0;
        for (int a = 0; a < 3; ++a)
        {
            i.delta_F[a] += area * force[a];
            i.delta_torque[a] -= area * s.cri * turn[a];
            if (s.is_wall) continue;
            j.delta_F[a] -= force[a];
            j.delta_torque[a] -= s.crj * turn[a];
        }
    }

    /// The surfaces have parted: so has the spring.
    void surfacesClose(SurfacesCloseData& s, ForceData&, ForceData&)
    {
        if (s.contact_flags) *s.contact_flags &= ~CONTACT_TANGENTIAL_MODEL;
        if (!s.contact_history) return;
        for (int a = 0; a < 3; ++a) s.contact_history[offset_ + a] = 0.0;
    }

    void beginPass(SurfacesIntersectData&, ForceData&, ForceData&) {}
    void endPass(SurfacesIntersectData&, ForceData&, ForceData&) {}

private:
    double update_dt() const { return update->dt; }

    const int offset_;
    double** friction_ = nullptr;
};

} // namespace ContactModels
} // namespace LIGGGHTS
#endif
#endif
