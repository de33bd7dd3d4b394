"""One hot sphere in gas at rest, one step and fifty, over h A dt/(m c) from 1e-8 to 1e8, coupled, against closed forms:
in gas of endless heat capacity the exponential of eq 15, in a closed pair the common equilibrium that neither may pass.
`./hotbed validate hot_sphere [--quick]`: --quick takes fewer stiffnesses.
"""

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "validation" / "hot_sphere"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
from run import prepare, run_case

HOT, COLD = 363.15, 293.15
DIAMETER, BOX, STEP, GAS_HEAT, PRANDTL = 1e-3, 0.01, 1.0, 1000.0, 0.72
CAPACITY = 800.0 * np.pi / 6 * DIAMETER**3 * 1500.0
VOIDAGE = 1 - np.pi / 6 * DIAMETER**3 / BOX**3
NUSSELT = 7 - 10 * VOIDAGE + 5 * VOIDAGE**2  # eq 9 at rest


def sphere(folder, stiffness, ratio):
    """Runs one case; `ratio` is the heat capacity of the gas over that of the sphere. @return its bed.csv"""
    conductivity = stiffness * CAPACITY / (NUSSELT * np.pi * DIAMETER * STEP)
    density = ratio * CAPACITY / (VOIDAGE * BOX**3 * GAS_HEAT)
    run = folder / f"stiffness={stiffness:.0e},ratio={ratio:.0e}"
    prepare(CASE, run, {"viscosity": f"{conductivity * PRANDTL / GAS_HEAT:.17g}", "rho": f"{density:.17g}"},
            overwrite=True)
    run_case(run)
    return results.bed(run)


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate hot_sphere", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="every fourth stiffness")
    options = parser.parse_args()
    figures = results.Figures("hot_sphere")
    folder = Path("results") / "hot_sphere" / ("validate-quick" if options.quick else "validate")
    stiffness = [10.0**e for e in range(-8, 9, 4 if options.quick else 1)]
    jobs = [(b, ratio) for ratio in (1e15, 1e3, 1.0, 1e-3) for b in stiffness]
    with ThreadPoolExecutor(2) as pool:
        beds = dict(zip(jobs, pool.map(lambda job: sphere(folder, *job), jobs)))

    for (b, ratio), bed in beds.items():
        T, gas, t = bed["T_mean_K"], bed["gas_T_max_K"], bed["time_s"]
        if ratio == 1e15:
            exact = COLD + (HOT - COLD) * np.exp(-b * t / STEP)
            error = np.abs(T - exact) / (HOT - COLD)
            figures.add(f"h A dt/(m c) = {b:.0e}, constant gas: one step against exp", error[0], 1e-10)
            figures.add(f"h A dt/(m c) = {b:.0e}, constant gas: fifty steps against exp", error[-1], 1e-10)
            continue
        pair = f"h A dt/(m c) = {b:.0e}, gas/sphere capacity {ratio:.0e}"
        equilibrium = (HOT + ratio * COLD) / (1 + ratio)
        passed = max(np.max(equilibrium - T), np.max(gas - equilibrium), 0.0) / (HOT - COLD)
        figures.add(f"{pair}: past equilibrium", passed, 1e-12)
        # temperatures are kept in doubles: what their last digit holds, once a step, can be more than 1e-9 of a tiny heat
        digit = len(t) * 2.0**-52 * CAPACITY * (HOT + ratio * HOT) / bed["exchanged_J"][-1]
        figures.add(f"{pair}: energy lost, of that exchanged", abs(bed["budget_error"][-1]), max(1e-9, digit))
        exact = equilibrium + (HOT - equilibrium) * np.exp(-b * t / STEP * (1 + 1 / ratio))
        figures.note(f"{pair}: one step against the exact pair", abs(T[0] - exact[0]) / (HOT - COLD))
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
