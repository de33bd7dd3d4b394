"""One particle falling in gas at rest, against the fine solution of its equation of motion (eq 13), for drag relaxation
times from 1000 down to 0.001 gas steps. The particle is small (10 um, Re 0.002): the Reynolds number in the drag is that at
the start of a gas step, which a particle that starts from rest feels in its first step. `./hotbed validate settling [--quick]`; --quick leaves out the finest steps."""

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "settling_particle"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
from run import prepare, run_case

GRAVITY, VISCOSITY, GAS, PARTICLE, DIAMETER = 9.81, 1.8e-5, 1.2, 1000.0, 1e-5
RELAXATION = PARTICLE * DIAMETER**2 / (18 * VISCOSITY)  # Stokes


def beta(reynolds):
    """Eq 5 at voidage 1, written out here."""
    if reynolds == 0:
        return 1.0
    return 1 + 0.413 * reynolds / 24 * (1 + 8.4 * reynolds**-0.343) / (1 + reynolds**-0.5)


def fine(times):
    """Velocity at times [s] from rest [m/s]."""
    def acceleration(_, v):
        speed = abs(v[0])
        return [-GRAVITY - 3 * np.pi * VISCOSITY * DIAMETER * beta(GAS * speed * DIAMETER / VISCOSITY) * v[0]
                / (PARTICLE * np.pi / 6 * DIAMETER**3)]

    # nothing happens after 60 relaxation times
    inside = np.minimum(times, 60 * RELAXATION)
    solved = solve_ivp(acceleration, (0, inside.max()), [0.0], method="LSODA", t_eval=np.unique(inside), rtol=1e-11,
                       atol=1e-16)
    return np.interp(inside, solved.t, solved.y[0])


def fall(folder, ratio, l):
    """@param ratio relaxation time over the gas step. @return (times, velocities)"""
    step = RELAXATION / ratio
    steps = int(np.clip(8 * ratio, 6, 2000))
    run = folder / f"ratio={ratio:g},l={l}"
    prepare(CASE, run, {"deltaT": f"{step:.12g}", "deltaTDEM": f"{step / 10:.12g}", "endTime": f"{steps * step:.12g}",
                        "diameter": f"{DIAMETER}", "l": f"{l}"}, overwrite=True)
    run_case(run)
    velocity = [float(line.split()[1]) for line in (run / "DEM/post/fall.txt").read_text().splitlines()
                if len(line.split()) == 2 and line[0].isdigit() and "." in line]
    return step * np.arange(len(velocity)), np.array(velocity)


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate settling", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="without the finest steps")
    options = parser.parse_args()
    figures = results.Figures("settling")
    folder = Path("results") / "settling" / ("validate-quick" if options.quick else "validate")
    ratios = [0.001, 0.01, 0.1, 1, 10, 100] + ([] if options.quick else [1000])
    jobs = [(ratio, l) for ratio in ratios for l in (1, 2)]
    with ThreadPoolExecutor(2) as pool:
        falls = dict(zip(jobs, pool.map(lambda job: fall(folder, *job), jobs)))
    for (ratio, l), (times, velocity) in falls.items():
        exact = fine(times)
        terminal = fine(np.array([60 * RELAXATION]))[0]
        figures.add(f"relaxation time {ratio:g} gas steps, l = {l}: history, of the terminal velocity",
                    np.max(np.abs(velocity - exact)) / abs(terminal), 1e-3)
        if times[-1] > 7.5 * RELAXATION:
            figures.add(f"relaxation time {ratio:g} gas steps, l = {l}: last velocity", abs(velocity[-1] / exact[-1] - 1),
                        1e-3)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
