"""Momentum of gas and particles, what crossed the boundary and gravity, added up over a run, against pressure tolerance and
correctors. `./hotbed validate momentum [--quick]`: --quick leaves out the dearest settings.

Scene: in the column of examples/slim_bed two clouds of particles fly into each other, away from the walls, in gas that
flows upwards: particles act on each other and on the gas, and nothing else acts on them but gravity. The particles'
momentum is summed from LIGGGHTS' own dump.
"""

import argparse
import itertools
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "slim_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
from campaign import edit
from run import prepare, run_case

STEP, END = 1e-4, 0.01
GAS_CONSTANT = 8314.46 / 28.0134  # of nitrogen [J/kg/K]
CLOUDS = """
lattice         sc 1.3e-3
region          lower block 0.004 0.016 0.003 0.007 0.010 0.020 units box
region          upper block 0.004 0.016 0.003 0.007 0.022 0.032 units box
create_atoms    1 region lower
create_atoms    1 region upper
group           lower region lower
group           upper region upper
set             group all diameter ${d} density 1040
velocity        lower set 0.02 0.01 0.3 units box
velocity        upper set 0 0 -0.3 units box
"""


def residual(folder, tolerance, correctors, outer):
    """@return momentum not accounted for by gas and particles together and by particles alone, of the impulse that went
    from gas to particles; largest difference of a cell's gas to the gas law, relative"""
    run = folder / f"tolerance={tolerance:g},correctors={correctors},outer={outer}"
    prepare(CASE, run, {"deltaT": f"{STEP}", "maxDeltaT": f"{STEP}", "endTime": f"{END}", "writeInterval": f"{END}", "height": "0.05",
                        "cellsHeight": "40"}, overwrite=True)
    edit(run / "DEM/in.bed", r"(?s)^lattice .*?(?=\nlabel           filled)", CLOUDS)
    edit(run / "DEM/in.bed", r"^dump .*?$", "dump particles all custom ${every} DEM/post/particles*.txt id mass vx vy vz\n"
         'dump_modify particles format "%d %.17g %.17g %.17g %.17g"')
    edit(run / "system/fvSolution", r'(?s)"p\|pFinal".*?\n    }',
         f'"p|pFinal" {{ solver GAMG; smoother GaussSeidel; tolerance {tolerance:g}; relTol 0; maxIter 100; }}')
    edit(run / "system/fvSolution", r"nOuterCorrectors\s+\d+;\s*nCorrectors\s+\d+;",
         f"nOuterCorrectors {outer}; nCorrectors {correctors};")
    run_case(run)

    def momentum(step):
        rows = np.loadtxt(run / f"DEM/post/particles{step}.txt", skiprows=9)
        return rows[:, 1].sum(), (rows[:, 1, None] * rows[:, 2:5]).sum(axis=0)

    mass, start = momentum(0)
    _, end = momentum(round(END / 2.5e-6))
    last = results.bed(run)[-1]
    received = np.array([last[f"impulse_{axis}_Ns"] for axis in "xyz"])
    gas = last["momentum_error"] * last["impulse_exchanged_Ns"]
    particles = np.linalg.norm(end - start - received - mass * END * np.array([0, 0, -9.81]))
    p, T, voidage, held = (results.field(run / f"{END}" / name) for name in ("p", "T", "voidage", "gasMass"))
    return ((gas + particles) / last["impulse_exchanged_Ns"], particles / last["impulse_exchanged_Ns"],
            np.max(np.abs(held / (voidage * p / (GAS_CONSTANT * T)) - 1)))


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate momentum", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="without the dearest settings")
    options = parser.parse_args()
    figures = results.Figures("momentum")
    folder = Path("results") / "momentum" / ("validate-quick" if options.quick else "validate")
    tolerances = (1e-3, 1e-9) if options.quick else (1e-3, 1e-5, 1e-7, 1e-9)
    loops = ((2, 1), (2, 4), (2, 12)) if options.quick else ((1, 1), (2, 1), (3, 1), (2, 2), (2, 4), (2, 8), (2, 16))
    jobs = list(itertools.product(tolerances, loops))
    with ThreadPoolExecutor(2) as pool:
        found = dict(zip(jobs, pool.map(lambda job: residual(folder, job[0], *job[1]), jobs)))
    for title, column in (("momentum not accounted for, of the impulse exchanged", 0), ("gas law, largest relative error of a cell", 2)):
        print(f"{title}; across: nCorrectors x nOuterCorrectors")
        print(f"{'pressure tolerance':20s}" + "".join(f"{f'{c} x {o}':>12s}" for c, o in loops))
        for tolerance in tolerances:
            print(f"{tolerance:<20g}" + "".join(f"{found[tolerance, loop][column]:12.2e}" for loop in loops))
    for (tolerance, (correctors, outer)), (both, _, law) in found.items():
        figures.note(f"momentum residual, tolerance {tolerance:g}, {correctors} x {outer} correctors", both)
        figures.note(f"gas law residual, tolerance {tolerance:g}, {correctors} x {outer} correctors", law)
    finest, coarsest = min(tolerances), max(tolerances)
    default = (2, 1)
    figures.add("particles alone: momentum less impulse received and gravity", max(row[1] for row in found.values()), 1e-9)
    figures.add("default correctors, finest tolerance: momentum residual", found[finest, default][0], 1e-2)
    figures.add("most correctors over the default ones: momentum residual",
                found[finest, loops[-1]][0] / found[finest, default][0], 0.1)
    figures.add("finest tolerance over the coarsest, most correctors: gas law residual",
                found[finest, loops[-1]][2] / found[coarsest, loops[-1]][2], 0.5)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
