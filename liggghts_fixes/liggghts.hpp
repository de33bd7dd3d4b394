#pragma once

/// The installed LIGGGHTS headers that the styles need, in the one order in which they compile.

#include "lammps.h"
#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "fix_property_atom.h"
#include "fix_property_global.h"
#include "force.h"
#include "input.h"
#include "integrate.h"
#include "modify.h"
#include "neighbor.h"
#include "output.h"
#include "update.h"
#include "write_restart.h"
