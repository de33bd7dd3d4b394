#!/usr/bin/python3
"""How much void particles leave at walls, behind `wallSetback` of the beds (docs/theory.md): examples/slim_bed with its walls in
place is fluidised, the gas is turned off, and once the particles lie still, their solids beside the side walls are measured in slices.
Told for each `l`, in coarse diameters: the thickness of the layer that would have to be empty for the rest to be as full as the bed is
one to four diameters from the wall. A minute at `l = 2.5`, a quarter of an hour at `l = 1`.

    ./hotbed --version >/dev/null   # builds
    /usr/bin/python3 validation/studies/wall_void.py [L ...]   # default 2.5 2 1.5 1
"""

import shutil
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ("examples", "validation", "cfd_solver")]
import campaign
from bed_pictures import Run

FLUIDISED, END = 0.3, 0.6  # [s]
SLICES, DEEP = 4, 4  # slices of a diameter; how many diameters from the wall
LOW, HIGH = 0.003, 0.018  # heights between which particles are counted [m]: neither the floor's layers nor the surface


def in_slices(distance, radius, edge):
    """Volume of spheres between planes at distances `edge` from a wall, by slice."""
    at = np.clip(edge[:, None] - distance, -radius, radius)
    return np.diff((np.pi * (radius**2 * at - at**3 / 3)).sum(axis=1))


def solids(run):
    """@return solids by slice [walls across width and depth, slices] at the end of a run"""
    diameter = 5e-4 * run.l
    edge = np.arange(SLICES * DEEP + 1) * diameter / SLICES
    width, depth = run.width, float(run.setting["depth"])
    particles = run.particles(max(run.dumps))
    inside = (particles["z"] > LOW) & (particles["z"] < HIGH)
    x, y = (particles[name][inside] for name in "xy")
    sums = [sum(in_slices(distance, diameter / 2, edge) for distance in (place, far - place)) / (2 * across * (HIGH - LOW))
            for place, far, across in ((x, width, depth), (y, depth, width))]
    return np.array(sums) / np.diff(edge)


def main():
    folder = Path("results") / "studies" / "wall_void"
    case = folder / "case"
    shutil.copytree(ROOT / "examples" / "slim_bed", case, dirs_exist_ok=True)
    campaign.edit(case / "0/U", r"^( *inlet).*", r"\1 { type uniformFixedValue; uniformValue table "
                  f"((0 (0 0 $u0)) ({FLUIDISED} (0 0 $u0)) ({FLUIDISED + 0.01} (0 0 0)));" " }")
    for l in sys.argv[1:] or ["2.5", "2", "1.5", "1"]:
        run, = campaign.run_all(case, folder, [{"l": l, "endTime": f"{END}", "writeInterval": f"{END / 2}", "wallSetback": "0"}])
        for name, wall in zip(("width", "depth"), solids(Run(run))):
            void = (1 - wall[:SLICES] / wall[SLICES:].mean()).mean()
            print(f"l = {l}, across the {name}: {void:.3f} diameters empty; solids by quarters of a diameter",
                  " ".join(f"{s:.3f}" for s in wall), flush=True)


if __name__ == "__main__":
    main()
