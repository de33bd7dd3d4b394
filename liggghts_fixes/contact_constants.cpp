#include "liggghts.hpp"

#include "contact_constants.hpp"

#include "closures.hpp"
#include "fix_hotbed_coarsegrain.h"
#include "range.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <string>

using namespace LAMMPS_NS;

namespace hotbed
{
namespace
{

/// a property/global ... peratomtypepair of the script; null where it is not there
FixPropertyGlobal* optional(PropertyRegistry& registry, const char* name, const char* caller)
{
    const int types = registry.max_type();
    return static_cast<FixPropertyGlobal*>(registry.getLAMMPS()->modify->find_fix_property(
        name, "property/global", "peratomtypepair", types, types, caller, false));
}

FixPropertyGlobal& required(PropertyRegistry& registry, const char* name, const char* unit, const char* caller)
{
    if (FixPropertyGlobal* property = optional(registry, name, caller)) return *property;
    registry.getLAMMPS()->error->all(FLERR, (std::string(caller) + ": " + name +
                                             " is missing: add 'fix ID all property/global " + name +
                                             " peratomtypepair " + std::to_string(registry.max_type()) + " ...' " +
                                             unit + ", the original particle's, one value for each pair of types")
                                                .c_str());
    std::abort();
}

constexpr Range ofStiffness = {0.0, false, 1e12}, ofTangentialStiffness = {0.0, true, 1e12},
                ofDashpot = {0.0, true, 1e6}, ofRestitution = {0.0, false, 1.0}, ofFriction = {0.0, true, 1e6};

/// checked value of a property for a pair of types (0-based)
double value(PropertyRegistry& registry, FixPropertyGlobal& property, const char* name, const Range& range, int i,
             int j)
{
    const double v = property.compute_array(i, j);
    if (!range.holds(v))
    {
        char text[256];
        std::snprintf(text, sizeof text, "property/global %s must be %s, but is %g for types %d and %d", name,
                      range.text().c_str(), v, i + 1, j + 1);
        registry.getLAMMPS()->error->all(FLERR, text);
    }
    return v;
}

/// LIGGGHTS counts types from 1
MatrixProperty* fill(PropertyRegistry& registry, const std::function<double(int, int)>& entry)
{
    const int types = registry.max_type();
    auto* matrix = new MatrixProperty(types + 1, types + 1);
    for (int i = 0; i < types; ++i)
        for (int j = 0; j < types; ++j) matrix->data[i + 1][j + 1] = entry(i, j);
    return matrix;
}

double cubedRatio(PropertyRegistry& registry)
{
    Modify& modify = *registry.getLAMMPS()->modify;
    for (int f = 0; f < modify.nfix; ++f)
        if (const auto* owner = dynamic_cast<FixHotbedCoarsegrain*>(modify.fix[f]))
            return owner->ratio() * owner->ratio() * owner->ratio();
    return 1.0;
}

MatrixProperty* stiffness(PropertyRegistry& registry, const char* caller)
{
    FixPropertyGlobal& kn = required(registry, "kn", "[N/m]", caller);
    const double cube = cubedRatio(registry);
    return fill(registry, [&](int i, int j) { return cube * value(registry, kn, "kn", ofStiffness, i, j); });
}

MatrixProperty* dashpots(PropertyRegistry& registry, const char* name, const char* caller)
{
    FixPropertyGlobal* eta = optional(registry, name, caller);
    const double cube = cubedRatio(registry);
    return fill(registry,
                [&](int i, int j) { return eta ? cube * value(registry, *eta, name, ofDashpot, i, j) : 0.0; });
}

} // namespace

MatrixProperty* normalStiffness(PropertyRegistry& registry, const char* caller, bool)
{
    return stiffness(registry, caller);
}

MatrixProperty* tangentialStiffnesses(PropertyRegistry& registry, const char* caller, bool)
{
    const double cube = cubedRatio(registry);
    if (FixPropertyGlobal* kt = optional(registry, "kt", caller))
        return fill(registry,
                    [&](int i, int j) { return cube * value(registry, *kt, "kt", ofTangentialStiffness, i, j); });
    FixPropertyGlobal& kn = required(registry, "kn", "[N/m]", caller);
    FixPropertyGlobal& en = required(registry, "coefficientRestitution", "[-] (or give kt)", caller);
    FixPropertyGlobal& et = required(registry, "tangentialRestitution", "[-] (or give kt and etat)", caller);
    return fill(registry,
                [&](int i, int j)
                {
                    return cube *
                           tangentialStiffness(value(registry, kn, "kn", ofStiffness, i, j),
                                               value(registry, en, "coefficientRestitution", ofRestitution, i, j),
                                               value(registry, et, "tangentialRestitution", ofRestitution, i, j));
                });
}

MatrixProperty* normalDashpotPerRootMass(PropertyRegistry& registry, const char* caller, bool)
{
    if (optional(registry, "etan", caller)) return fill(registry, [](int, int) { return 0.0; });
    const MatrixProperty* k = registry.getMatrixProperty("hotbed_kn", caller);
    FixPropertyGlobal& e = required(registry, "coefficientRestitution", "[-] (or give etan)", caller);
    return fill(registry,
                [&](int i, int j) {
                    return dashpot(value(registry, e, "coefficientRestitution", ofRestitution, i, j),
                                   k->data[i + 1][j + 1], 1.0);
                });
}

MatrixProperty* tangentialDashpotPerRootMass(PropertyRegistry& registry, const char* caller, bool)
{
    if (optional(registry, "etat", caller)) return fill(registry, [](int, int) { return 0.0; });
    const MatrixProperty* k = registry.getMatrixProperty("hotbed_kt", caller);
    FixPropertyGlobal& e = required(registry, "tangentialRestitution", "[-] (or give etat)", caller);
    return fill(registry,
                [&](int i, int j)
                {
                    return dashpot(value(registry, e, "tangentialRestitution", ofRestitution, i, j),
                                   k->data[i + 1][j + 1], 2.0 / 7.0);
                });
}

MatrixProperty* normalDashpots(PropertyRegistry& registry, const char* caller, bool)
{
    return dashpots(registry, "etan", caller);
}

MatrixProperty* tangentialDashpots(PropertyRegistry& registry, const char* caller, bool)
{
    return dashpots(registry, "etat", caller);
}

MatrixProperty* friction(PropertyRegistry& registry, const char* caller, bool)
{
    FixPropertyGlobal& mu = required(registry, "coefficientFriction", "[-]", caller);
    return fill(registry, [&](int i, int j) { return value(registry, mu, "coefficientFriction", ofFriction, i, j); });
}

std::vector<ContactConstants> contactTable(LAMMPS& lmp)
{
    PropertyRegistry& registry = lmp.force->registry;
    const int types = lmp.atom->ntypes;
    const int used = registry.max_type(); // the matrices end with the largest type in use
    const auto matrix = [&](const char* name) { return registry.getMatrixProperty(name, "model hotbed")->data; };
    double** kn = matrix("hotbed_kn");
    double** kt = matrix("hotbed_kt");
    double** dn = matrix("hotbed_dn");
    double** dt = matrix("hotbed_dt");
    double** etan = matrix("hotbed_etan");
    double** etat = matrix("hotbed_etat");
    double** mu = matrix("hotbed_friction");
    std::vector<ContactConstants> table;
    for (int i = 1; i <= types; ++i)
        for (int j = 1; j <= types; ++j)
        {
            if (std::max(i, j) > used)
            {
                table.push_back(ContactConstants{});
                continue;
            }
            const double softness = kt[i][j] > 0.0 ? 1.0 / kt[i][j] : 0.0;
            table.push_back(ContactConstants{Row{kn[i][j], etan[i][j], dn[i][j], mu[i][j]},
                                             Row{kt[i][j], etat[i][j], dt[i][j], softness}});
        }
    return table;
}

} // namespace hotbed
