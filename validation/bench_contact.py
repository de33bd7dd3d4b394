"""Speed of the contact law, walls and integration against LIGGGHTS' own `hooke/stiffness tangential history`, `nve/sphere` and
`gravity`, on the same bed with the same constants and neighbour lists. `./hotbed bench contact [--quick]`.

A settled bed of 46,080 particles (the paper's at l = 2.5), the same bed shaken, every particle at 0.2 m/s in some direction,
and the slim bed fluidised: particles as a coupled run left them (l = 1, 48,000 particles, made once and kept; --quick l = 2,
6000), each with the force that the gas had on it, held constant; in stock LIGGGHTS by `couple/cfd/force`. On one and two ranks.
Stock and ours run in turn in the unmodified `liggghts`; the first steps are left out. A figure is the median of the ratios of
runs that followed each other.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import contact_scenes
import results
from contact_scenes import GRAVITY, TIMESTEP, liggghts, ours, script, stock

WARM = 100  # steps left out


def apart(folder, bed, steps):
    """Whether both apply the same forces: difference of the mean vertical velocities after some steps, over that of free fall.
    Without tangential dashpots, which LIGGGHTS' own law adds to the limited spring without limit and ours does not."""
    velocity = [liggghts(folder, f"same.{law.__name__}", script(law, bed, [steps], et=1.0), 1)[1][-1] for law in (stock, ours)]
    return abs(velocity[1] - velocity[0]) / (GRAVITY * steps * TIMESTEP)


def main():
    parser = argparse.ArgumentParser(prog="hotbed bench contact", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer and shorter runs, a coarser fluidised bed")
    options = parser.parse_args()
    figures = results.Figures("contact", verb="bench")
    folder = (Path("results") / "contact" / "bench").resolve()
    settled, shaken = contact_scenes.settled(folder, (160, 32), 46080)
    fluidised = contact_scenes.fluidised((Path("results") / "contact" / "fluidised").resolve(), "2" if options.quick else "1")
    figures.add("fluidised bed: mean velocity, ours less stock's, over that of free fall", apart(folder, fluidised, 500), 0.02)
    repeats = 3 if options.quick else 5
    scenes = [("settled", settled, 1, 2.3), ("settled", settled, 2, 2.0), ("shaken", shaken, 1, 2.0), ("shaken", shaken, 2, 2.0),
              ("fluidised", fluidised, 1, 2.0), ("fluidised", fluidised, 2, 2.0)]
    for name, bed, ranks, bound in scenes:
        steps = 200 if options.quick and bed.number > 10000 else 400
        where = f"{name} bed, {ranks} rank{'s' if ranks > 1 else ''}"
        seconds = {stock: [], ours: []}
        for _ in range(repeats):
            for law in (stock, ours):
                times, _ = liggghts(folder, f"{name}.{law.__name__}", script(law, bed, [WARM, steps]), ranks)
                seconds[law].append(times[-1])
        ratio = np.array(seconds[stock]) / seconds[ours]
        for law, times in seconds.items():
            figures.note(f"{where}: {law.__name__}, million particle-steps a second", bed.number * steps / np.median(times) / 1e6)
        figures.note(f"{where}: spread of the ratio, largest less smallest", float(np.ptp(ratio)))
        figures.add(f"{where}: stock's time over ours", np.median(ratio), bound, least=True)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
