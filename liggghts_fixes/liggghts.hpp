#pragma once

/// The installed LIGGGHTS headers that the styles need, in the one order in which they compile.

#include "lammps.h"
#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "fix_gravity.h"
#include "fix_property_atom.h"
#include "fix_property_global.h"
#include "force.h"
#include "input.h"
#include "integrate.h"
#include "modify.h"
#include "neighbor.h"
#include "output.h"
#include "timer.h"
#include "universe.h"
#include "update.h"
#include "variable.h"
#include "write_restart.h"
#include "fix_wall_gran.h"
#include "neigh_list.h"
#include "pair_gran.h"
#include "primitive_wall.h"

#include "range.hpp"

#include <cstring>

namespace hotbed
{

/// A fix of the same style under another id, of which a script may have only one; null without one. A fix that is
/// redefined under its own id is not another one.
inline LAMMPS_NS::Fix* anotherOfStyle(const LAMMPS_NS::Modify& modify, const LAMMPS_NS::Fix& fix)
{
    for (int i = 0; i < modify.nfix; ++i)
        if (std::strcmp(modify.fix[i]->style, fix.style) == 0 && std::strcmp(modify.fix[i]->id, fix.id) != 0)
            return modify.fix[i];
    return nullptr;
}

/// The number that an argument of a fix holds; an error that names fix, keyword and range where it does not.
inline double number(LAMMPS_NS::Error& error, LAMMPS_NS::Fix& fix, const std::string& keyword, const char* text,
                     const Range& range, const char* unit)
{
    double value;
    if (!range.read(text, value))
        error.fix_error(
            FLERR, &fix,
            (keyword + " must be a number " + range.text() + " [" + unit + "], not '" + text + "'").c_str());
    return value;
}

} // namespace hotbed
