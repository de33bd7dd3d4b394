#include "liggghts.hpp"

#include "fix_hotbed_drag.h"

#include "fix_nve_sphere_hotbed.h"

#include "vectorised.hpp"

#include <algorithm>
#include <string>
#include <vector>

using namespace LAMMPS_NS;

FixHotbedDrag::FixHotbedDrag(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
    if (narg != 3) error->fix_error(FLERR, this, "takes no arguments");
    if (hotbed::anotherOfStyle(*modify, *this))
        error->fix_error(FLERR, this, "the gas acts on the particles already through another fix hotbed/drag");
}

int FixHotbedDrag::setmask()
{
    return FixConst::POST_FORCE;
}

FixPropertyAtom* FixHotbedDrag::property(const char* name, int values)
{
    if (Fix* known = modify->find_fix_property(name, "property/atom", "vector", values, 0, style, false))
        return static_cast<FixPropertyAtom*>(known);
    std::vector<const char*> arg = {name, "all", "property/atom", name, "vector", "yes", "no", "no"};
    arg.insert(arg.end(), std::size_t(values), "0.");
    return modify->add_fix_property_atom(int(arg.size()), const_cast<char**>(arg.data()), style);
}

void FixHotbedDrag::post_create()
{
    force_ = property("gasForce", 3);
    alone_ = property("gasAlone", 4);
    kept_ = property("restartForce", 6);
}

void FixHotbedDrag::init()
{
    left_ = false;
    for (int i = 0; i < modify->nfix; ++i)
        if (const auto* integration = dynamic_cast<const FixNVESphereHotbed*>(modify->fix[i]))
            left_ |= integration->addsForceOf(*this);
}

double** FixHotbedDrag::force() const
{
    return force_->array_atom;
}

double** FixHotbedDrag::alone() const
{
    return alone_->array_atom;
}

HOTBED_VECTORISED void FixHotbedDrag::set(int first, int count, const double (*force)[3])
{
    // LIGGGHTS keeps n x 3 arrays in one block behind row pointers
    double* __restrict kept = this->force()[first];
    double* __restrict sum = atom->f[first];
    const double* __restrict now = force[0];
    const int* mask = atom->mask + first;
    int in = groupbit;
    for (int i = 0; i < count; ++i) in &= mask[i];
    if (in)
        for (int k = 0; k < 3 * count; ++k) sum[k] += now[k] - kept[k];
    else
        for (int k = 0; k < 3 * count; ++k) sum[k] += mask[k / 3] & groupbit ? now[k] - kept[k] : 0.0;
    std::copy_n(now, 3 * count, kept);
}

void FixHotbedDrag::keepForces()
{
    for (int i = 0; i < atom->nlocal; ++i)
    {
        std::copy_n(atom->f[i], 3, kept_->array_atom[i]);
        std::copy_n(atom->torque[i], 3, kept_->array_atom[i] + 3);
    }
}

void FixHotbedDrag::restoreForces()
{
    for (int i = 0; i < atom->nlocal; ++i)
    {
        std::copy_n(kept_->array_atom[i], 3, atom->f[i]);
        std::copy_n(kept_->array_atom[i] + 3, 3, atom->torque[i]);
    }
}

void FixHotbedDrag::post_force(int)
{
    if (!left_) add();
}

void FixHotbedDrag::add()
{
    double** f = atom->f;
    double** gas = force();
    for (int i = 0; i < atom->nlocal; ++i)
        if (atom->mask[i] & groupbit)
            for (int a = 0; a < 3; ++a) f[i][a] += gas[i][a];
}
