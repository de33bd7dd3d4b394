#include "liggghts.hpp"

#include "fix_hotbed_coarsegrain.h"

#include "closures.hpp"
#include "runaway.hpp"

#include <cmath>
#include <string>

using namespace LAMMPS_NS;

FixHotbedCoarsegrain::FixHotbedCoarsegrain(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg)
{
    if (const Fix* other = hotbed::anotherOfStyle(*modify, *this))
        error->fix_error(
            FLERR, this,
            (std::string("the coarse-graining ratio is given already, by fix ") + other->id + ": keep one of the two")
                .c_str());

    for (int i = 3; i < narg;)
    {
        const std::string keyword = arg[i];
        const int values = keyword == "restitution" ? 2 : 1;
        if (i + values >= narg)
            error->fix_error(FLERR, this,
                             ("keyword " + keyword + " wants " + (values == 2 ? "two values" : "a value")).c_str());
        const auto once = [&](double& value, double most, const char* unit)
        {
            if (value != 0.0) error->fix_error(FLERR, this, ("keyword " + keyword + " is given twice").c_str());
            value = hotbed::number(*error, *this, keyword, arg[++i], {0.0, false, most}, unit);
        };
        if (keyword == "ratio")
            once(ratio_, 1000.0, "-");
        else if (keyword == "diameter")
            once(diameter_, 10.0, "m");
        else if (keyword == "density")
            once(density_, 1e6, "kg/m3");
        else if (keyword == "stiffness")
            once(stiffness_, 1e12, "N/m");
        else if (keyword == "restitution")
        {
            once(normalRestitution_, 1.0, "-");
            once(tangentialRestitution_, 1.0, "-");
        }
        else
            error->fix_error(
                FLERR, this,
                ("unknown keyword " + keyword + "; known are ratio, diameter, density, stiffness, restitution")
                    .c_str());
        ++i;
    }
    if (ratio_ == 0.0)
        error->fix_error(FLERR, this,
                         "keyword ratio is missing: add 'ratio L' with the coarse-graining ratio, 1 for "
                         "the original particles");

    scalar_flag = 1;
    vector_flag = 1;
    size_vector = 7;
    global_freq = 1;
    extscalar = extvector = 0;
}

int FixHotbedCoarsegrain::setmask()
{
    return FixConst::PRE_EXCHANGE;
}

/// Before new neighbour lists, when particles outside the box are still there.
void FixHotbedCoarsegrain::pre_exchange()
{
    hotbed::refuseRunaways(*lmp);
}

double FixHotbedCoarsegrain::given(double value, const char* keyword) const
{
    if (value == 0.0)
        error->all(FLERR, (std::string("Fix hotbed/coarsegrain (id ") + id + "): this value of f_" + id +
                           " needs the keyword " + keyword + ": add it")
                              .c_str());
    return value;
}

/// 1 l, 2 l^3, 3 diameter, 4 k_n, 5 k_t, 6 eta_n, 7 eta_t of the coarse particle (eq 18, 19)
double FixHotbedCoarsegrain::compute_vector(int index)
{
    const double cube = ratio_ * ratio_ * ratio_;
    switch (index)
    {
    case 0:
        return ratio_;
    case 1:
        return cube;
    case 2:
        return ratio_ * given(diameter_, "diameter");
    case 3:
        return cube * given(stiffness_, "stiffness");
    case 4:
        return cube * hotbed::tangentialStiffness(given(stiffness_, "stiffness"),
                                                  given(normalRestitution_, "restitution"), tangentialRestitution_);
    default:
        break;
    }
    const double mass = M_PI / 6.0 * given(density_, "density") * std::pow(given(diameter_, "diameter"), 3);
    const double stiffness = given(stiffness_, "stiffness");
    const double en = given(normalRestitution_, "restitution");
    if (index == 5) return cube * hotbed::dashpot(en, stiffness, mass / 2.0);
    return cube * hotbed::dashpot(tangentialRestitution_,
                                  hotbed::tangentialStiffness(stiffness, en, tangentialRestitution_), mass / 7.0);
}
