#pragma once

#include "cells.hpp"

#include <algorithm>
#include <memory>

namespace hotbed
{

/// Cells that are boxes, through a lattice of nx x ny x nz boxes over the unit cube: overlaps written out here.
inline std::unique_ptr<LatticeCells> throughLattice(const std::vector<Box>& cells, std::array<int, 3> n)
{
    std::array<std::vector<double>, 3> face;
    for (int a = 0; a < 3; ++a)
        for (int i = 0; i <= n[a]; ++i) face[a].push_back(double(i) / n[a]);
    std::vector<LatticeCells::Share> shares;
    std::vector<char> inside(std::size_t(n[0] * n[1] * n[2]), 0);
    for (int box = 0; box < n[0] * n[1] * n[2]; ++box)
    {
        const int slot[3] = {box % n[0], box / n[0] % n[1], box / n[0] / n[1]};
        for (std::size_t c = 0; c < cells.size(); ++c)
        {
            double part = 1.0;
            for (int a = 0; a < 3; ++a)
                part *= n[a] * std::max(0.0, std::min(face[a][slot[a] + 1], cells[c].high[a]) -
                                                 std::max(face[a][slot[a]], cells[c].low[a]));
            if (!(part > 0.0)) continue;
            inside[box] = 1;
            shares.push_back({box, int(c), 0.25 * part}); // in two pieces, to be put together
            shares.push_back({box, int(c), 0.75 * part});
        }
    }
    return std::make_unique<LatticeCells>(int(cells.size()), face, shares, inside);
}

} // namespace hotbed
