// Read by LIGGGHTS' model lists as well as as a header, hence the two halves.
#ifdef NORMAL_MODEL
NORMAL_MODEL(HOTBED_NORMAL, hotbed, 40)
#else
#ifndef NORMAL_MODEL_HOTBED_H
#define NORMAL_MODEL_HOTBED_H
#include "contact_models.h"
#include "normal_model_base.h"

#include "contact_constants.hpp"

namespace LIGGGHTS
{
namespace ContactModels
{

/// Linear spring and dashpot, eq 18, from the original particle's constants: Fn = k_n delta - eta_n v_n, all scaled by
/// the coarse-graining ratio of fix hotbed/coarsegrain. See docs/pair_gran_hotbed.md.
template <> class NormalModel<HOTBED_NORMAL> : public NormalModelBase
{
public:
    NormalModel(LAMMPS* lmp, IContactHistorySetup* hsetup, class ContactModelBase* c) : NormalModelBase(lmp, hsetup, c)
    {
    }

    void registerSettings(Settings&) {}
    void postSettings(IContactHistorySetup*, ContactModelBase*) {}
    void connectToProperties(PropertyRegistry& registry)
    {
        // contacts that have just opened are visited too, so that their history can end
        neighbor->register_contact_dist_factor(1.01);
        const char* caller = "model hotbed";
        hotbed::connect(registry, "hotbed_kn", &hotbed::normalStiffness, k_n, caller);
        hotbed::connect(registry, "hotbed_kt", &hotbed::tangentialStiffnesses, k_t, caller);
        hotbed::connect(registry, "hotbed_dn", &hotbed::normalDashpotPerRootMass, dn, caller);
        hotbed::connect(registry, "hotbed_dt", &hotbed::tangentialDashpotPerRootMass, dt, caller);
        hotbed::connect(registry, "hotbed_etan", &hotbed::normalDashpots, eta_n, caller);
        hotbed::connect(registry, "hotbed_etat", &hotbed::tangentialDashpots, eta_t, caller);
    }

    double stressStrainExponent() { return 1.0; }

    void surfacesIntersect(SurfacesIntersectData& s, ForceData& i, ForceData& j)
    {
        if (s.contact_flags) *s.contact_flags |= CONTACT_NORMAL_MODEL;
        const double root = std::sqrt(s.meff);
        s.kn = k_n[s.itype][s.jtype];
        s.kt = k_t[s.itype][s.jtype];
        s.gamman = eta_n[s.itype][s.jtype] + dn[s.itype][s.jtype] * root;
        s.gammat = eta_t[s.itype][s.jtype] + dt[s.itype][s.jtype] * root;
        s.Fn = s.kn * s.deltan - s.gamman * s.vn;
        for (int a = 0; a < 3; ++a)
        {
            const double force = s.Fn * s.en[a];
            i.delta_F[a] += s.is_wall ? force * s.area_ratio : force;
            if (!s.is_wall) j.delta_F[a] -= force;
        }
    }

    void surfacesClose(SurfacesCloseData& s, ForceData&, ForceData&)
    {
        if (s.contact_flags) *s.contact_flags &= ~CONTACT_NORMAL_MODEL;
    }
    void beginPass(SurfacesIntersectData&, ForceData&, ForceData&) {}
    void endPass(SurfacesIntersectData&, ForceData&, ForceData&) {}

private:
    double** k_n = nullptr;
    double** k_t = nullptr;
    double** dn = nullptr;
    double** dt = nullptr;
    double** eta_n = nullptr;
    double** eta_t = nullptr;
};

} // namespace ContactModels
} // namespace LIGGGHTS
#endif
#endif
