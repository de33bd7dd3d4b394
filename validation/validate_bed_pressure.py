"""Pressure drop through a fixed bed against Beetstra's correlation (eq 5), five velocities, every `l`.
`./hotbed validate bed_pressure [--quick]`: --quick takes fewer velocities.

The scene is that of examples/fixed_bed without heat; the gradient is fitted to the cross-section means of the pressure
over the middle of the bed.
"""

import argparse
import itertools
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "fixed_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
from run import prepare, run_case

VOIDAGE, VISCOSITY, DENSITY, DIAMETER = 0.4, 1.8e-5, 300.0, 4.875e-4
HEIGHT, CELLS = 0.06, 40


def gradient(velocity):
    """-dp/dz of eq 2 and 4 for a superficial velocity [Pa/m]: eps dp/dz = -n 3 pi mu eps d beta u, written out here."""
    e = VOIDAGE
    re = DENSITY * velocity * DIAMETER / VISCOSITY
    beta = 10 * (1 - e) / e**2 + e**2 * (1 + 1.5 * (1 - e) ** 0.5) + 0.413 * re / (24 * e**2) * (
        1 / e + 3 * e * (1 - e) + 8.4 * re**-0.343) / (1 + 10 ** (3 * (1 - e)) * re ** (-0.5 - 2 * (1 - e)))
    return 18 * VISCOSITY * (1 - e) * beta * velocity / e / DIAMETER**2


def measured(folder, l, velocity):
    """Fitted gradient of a run [Pa/m]."""
    run = folder / f"l={l},u0={velocity}"
    step = 2.5e-4 / velocity
    prepare(CASE, run, {"l": l, "u0": f"{velocity}", "height": f"{HEIGHT}", "cellsHeight": f"{CELLS}",
                        "deltaT": f"{step}", "endTime": f"{40 * step}", "writeInterval": f"{40 * step}"}, overwrite=True)
    script = run / "DEM/in.fixed_bed"
    script.write_text("\n".join(line for line in script.read_text().splitlines()
                                if not line.startswith(("fix             heat", "fix             layers"))) + "\n")
    run_case(run)
    last = max((p for p in run.iterdir() if (p / "p").is_file()), key=lambda p: float(p.name))
    p = results.field(last / "p").reshape(CELLS, -1).mean(axis=1)
    z = (np.arange(CELLS) + 0.5) * HEIGHT / CELLS
    middle = slice(CELLS // 5, -CELLS // 5)
    return -np.polyfit(z[middle], p[middle], 1)[0]


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate bed_pressure", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="two velocities")
    options = parser.parse_args()
    figures = results.Figures("bed_pressure")
    folder = Path("results") / "bed_pressure" / ("validate-quick" if options.quick else "validate")
    velocities = (0.001, 0.1) if options.quick else (0.001, 0.01, 0.03, 0.1, 0.3)
    jobs = list(itertools.product(("1", "1.5", "2", "2.5"), velocities))
    with ThreadPoolExecutor(2) as pool:
        found = dict(zip(jobs, pool.map(lambda job: measured(folder, *job), jobs)))
    for (l, velocity), value in found.items():
        figures.add(f"l = {l}, u0 = {velocity} m/s: pressure gradient against eq 5, relative",
                    abs(value / gradient(velocity) - 1), 1e-2, f"{value:.5g} Pa/m")
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
