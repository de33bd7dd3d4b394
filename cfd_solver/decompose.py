"""How the gas is cut for a number of ranks where system/decomposeParDict leaves it open."""

import math
import re

DICTIONARY = """FoamFile
{
    version     2.0;
    format      ascii;
    class       dictionary;
    object      decomposeParDict;
}

numberOfSubdomains  1;
method              simple;
simpleCoeffs        { n (1 1 1); delta 0.001; }
"""
PIECES = r"\bn\s*\(([^()]*)\)"  # n (2 1 1), of the methods simple and hierarchical


def pieces(ranks, size, gravity):
    """Into how many pieces a box is cut along x, y, z so that all cuts together are smallest, of equally small ones in the
    fewest directions; never across gravity, so that each rank has a share of the bed.

    @param size     of the box along x, y, z
    @param gravity  its vector; along its largest component nothing is cut
    """
    up = max(range(3), key=lambda a: abs(gravity[a])) if any(gravity) else None
    area = [math.prod(size) / extent for extent in size]
    grids = [(a, b, ranks // (a * b)) for a in range(1, ranks + 1) if ranks % a == 0
             for b in range(1, ranks // a + 1) if ranks // a % b == 0]
    return min((grid for grid in grids if up is None or grid[up] == 1),
               key=lambda grid: (float(f"{sum((n - 1) * cut for n, cut in zip(grid, area)):.9g}"), -max(grid), [-n for n in grid]))


def is_open(text, ranks):
    """Whether the text of a decomposeParDict counts pieces along x, y, z for another number of ranks."""
    if not re.search(r"(?m)^\s*method\s+(simple|hierarchical)\s*;", text) or not (found := re.search(PIECES, text)):
        return False
    numbers = found[1].replace("$numberOfSubdomains", str(ranks)).split()
    return all(n.isdigit() for n in numbers) and math.prod(map(int, numbers)) != ranks


def extent(log):
    """Size of the mesh along x, y, z, from what checkMesh prints."""
    low, high = re.search(r"Overall domain bounding box \(([^)]*)\) \(([^)]*)\)", log).groups()
    return [float(b) - float(a) for a, b in zip(low.split(), high.split())]
