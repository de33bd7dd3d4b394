#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace hotbed
{

/// Moves the planes between slabs of a box towards where each slab holds as many particles: at most so far that a
/// particle then belongs to its slab or to one beside it, as LIGGGHTS hands particles over, and that no slab becomes
/// thinner than `least`, or than the thinnest one is already.
/// @param planes  [slabs + 1], rising from 0 to 1
/// @param count   particles in layers of equal thickness from 0 to 1
/// @param least   as a share of the box
inline void moveTowardsEqualShares(double* planes, int slabs, const std::vector<double>& count, double least)
{
    const std::vector<double> old(planes, planes + slabs + 1);
    for (int s = 0; s < slabs; ++s) least = std::min(least, old[s + 1] - old[s]);
    const double all = std::accumulate(count.begin(), count.end(), 0.0);
    double below = 0.0;
    std::size_t layer = 0;
    for (int s = 1; s < slabs && all > 0.0; ++s)
    {
        const double wanted = all * s / slabs;
        while (below + count[layer] < wanted) below += count[layer++];
        const double place = (double(layer) + (wanted - below) / count[layer]) / double(count.size());
        planes[s] = std::clamp(place, old[s] - 0.5 * (old[s] - old[s - 1] - least),
                               old[s] + 0.5 * (old[s + 1] - old[s] - least));
    }
}

} // namespace hotbed
