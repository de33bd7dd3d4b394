#pragma once

#include "cells.hpp"
#include "fvMesh.H"

#include <memory>

namespace hotbed
{

/// A lattice over a mesh of cells of any shape, for the mapping. Collective.
///
/// The cells are cut along the planes of the lattice: what a box holds of a cell is its share of the box's mass. What a
/// box has beyond the walls is mirrored at the nearest point of the boundary and goes to the cells there.
/// @param perCell  boxes along each axis in a cell of mean size
/// @param reach    how far beyond the walls the kernel of a particle can reach [m]
std::unique_ptr<const Cells> latticeOver(const Foam::fvMesh& mesh, int perCell, double reach);

} // namespace hotbed
