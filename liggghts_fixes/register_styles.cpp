/// Makes the styles of this library known to every LIGGGHTS instance of the process, also after the script command
/// `clear`: LIGGGHTS rebuilds its style tables in LAMMPS::create(), which this definition stands in front of (linked
/// into an executable, or preloaded under the unmodified `liggghts`) and then extends.

#include "liggghts.hpp"

#include "fix_hotbed_balance.h"
#include "fix_hotbed_carried.h"
#include "fix_hotbed_coarsegrain.h"
#include "fix_hotbed_drag.h"
#include "fix_hotbed_heat.h"
#include "fix_nve_sphere_hotbed.h"
#include "register_contact.hpp"
#include "vectorised_wall.hpp"

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

namespace
{

using FixCreator = LAMMPS_NS::Fix* (*)(LAMMPS_NS::LAMMPS*, int, char**);
using FixMap = std::map<std::string, FixCreator>;

template <class Style> LAMMPS_NS::Fix* makeFix(LAMMPS_NS::LAMMPS* lmp, int narg, char** arg)
{
    return new Style(lmp, narg, arg);
}

/// The table of fix styles is private; an explicit instantiation may name it ([temp.explicit]).
template <FixMap* LAMMPS_NS::Modify::*member> struct FixMapOf
{
    friend FixMap& fixMapOf(LAMMPS_NS::Modify& modify) { return *(modify.*member); }
};
FixMap& fixMapOf(LAMMPS_NS::Modify& modify);
template struct FixMapOf<&LAMMPS_NS::Modify::fix_map>;

} // namespace

namespace LAMMPS_NS
{

__attribute__((visibility("default"))) void LAMMPS::create()
{
    using Create = void (*)(LAMMPS*);
    static const auto real = reinterpret_cast<Create>(dlsym(RTLD_NEXT, "_ZN9LAMMPS_NS6LAMMPS6createEv"));
    if (!real)
    {
        std::fprintf(stderr, "hotbed: libliggghts not found behind the hotbed styles: load it after this library\n");
        std::abort();
    }
    real(this);
    hotbed::registerContact();

    FixMap& fixes = fixMapOf(*modify);
    fixes["hotbed/balance"] = &makeFix<FixHotbedBalance>;
    fixes["hotbed/carried"] = &makeFix<FixHotbedCarried>;
    fixes["hotbed/coarsegrain"] = &makeFix<FixHotbedCoarsegrain>;
    fixes["hotbed/drag"] = &makeFix<FixHotbedDrag>;
    fixes["hotbed/heat"] = &makeFix<FixHotbedHeat>;
    fixes["wall/gran"] = &makeFix<hotbed::VectorisedWall>;
    fixes["nve/sphere/hotbed"] = &makeFix<FixNVESphereHotbed>;
}

} // namespace LAMMPS_NS
