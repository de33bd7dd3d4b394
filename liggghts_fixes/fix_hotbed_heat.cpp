#include "liggghts.hpp"

#include "fix_hotbed_heat.h"

#include "vectorised.hpp"

#include <cstdio>
#include <cstring>
#include <string>

using namespace LAMMPS_NS;

FixHotbedHeat::FixHotbedHeat(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
    if (!atom->radius_flag || !atom->rmass_flag)
        error->fix_error(FLERR, this, "particles have no size or mass: use 'atom_style granular'");
    if (hotbed::anotherOfStyle(*modify, *this))
        error->fix_error(FLERR, this, "particle temperature is held already by another fix hotbed/heat");
    if (narg != 5 || std::strcmp(arg[3], "initial_temperature") != 0)
        error->fix_error(FLERR, this, "expecting 'initial_temperature T0' and nothing else");
    initialTemperature_ = hotbed::number(*error, *this, arg[3], arg[4], {0.0, false, 1e5}, "K");
    scalar_flag = 1;
    global_freq = 1;
    extscalar = 1;
    peratom_flag = 1;
    size_peratom_cols = 0;
    peratom_freq = 1;
}

FixPropertyAtom* FixHotbedHeat::property(const char* name, const char* initial, bool ghosts)
{
    const char* arg[] = {name, "all", "property/atom", name, "scalar", "yes", ghosts ? "yes" : "no", "no", initial};
    Fix* known = modify->find_fix_property(name, "property/atom", "scalar", 0, 0, style, false);
    return known ? static_cast<FixPropertyAtom*>(known)
                 : modify->add_fix_property_atom(9, const_cast<char**>(arg), style);
}

void FixHotbedHeat::post_create()
{
    char initial[32];
    std::snprintf(initial, sizeof initial, "%.17g", initialTemperature_);
    temperature_ = property("Temp", initial, true);
    nusselt_ = property("Nusselt", "0.", false);
    vector_atom = temperature_->vector_atom;
}

void FixHotbedHeat::init()
{
    capacity_ = static_cast<FixPropertyGlobal*>(
        modify->find_fix_property("thermalCapacity", "property/global", "peratomtype", atom->ntypes, 0, style, false));
    if (!capacity_)
        error->fix_error(FLERR, this,
                         "the particles' heat capacity is missing: add "
                         "'fix ID all property/global thermalCapacity peratomtype C1 C2 ...' [J/kg/K], one a type");
    const hotbed::Range range = {0.0, false, 1e12};
    for (int t = 0; t < atom->ntypes; ++t)
        if (!range.holds(capacity_->compute_vector(t)))
            error->fix_error(FLERR, this,
                             ("thermalCapacity must be " + range.text() + " for every particle type [J/kg/K]").c_str());
    vector_atom = temperature_->vector_atom;
}

double* FixHotbedHeat::temperature() const
{
    return temperature_->vector_atom;
}

double* FixHotbedHeat::nusselt() const
{
    return nusselt_->vector_atom;
}

HOTBED_VECTORISED void FixHotbedHeat::heatCapacity(int first, int count, double* capacity) const
{
    const double* ofType = capacity_->get_values() - 1;
    const double* mass = atom->rmass + first;
    const int* type = atom->type + first;
    if (atom->ntypes == 1)
        for (int i = 0; i < count; ++i) capacity[i] = mass[i] * ofType[1];
    else
        for (int i = 0; i < count; ++i) capacity[i] = mass[i] * ofType[type[i]];
}

HOTBED_VECTORISED void FixHotbedHeat::warm(int first, int count, const double* change)
{
    vector_atom = temperature();
    double* __restrict T = vector_atom + first;
    for (int i = 0; i < count; ++i) T[i] += change[i];
}

double FixHotbedHeat::compute_scalar()
{
    double mine = 0.0, sum = 0.0;
    const double* T = temperature();
    const double* ofType = capacity_->get_values() - 1;
    for (int i = 0; i < atom->nlocal; ++i) mine += atom->rmass[i] * ofType[atom->type[i]] * T[i];
    MPI_Allreduce(&mine, &sum, 1, MPI_DOUBLE, MPI_SUM, world);
    return sum;
}
