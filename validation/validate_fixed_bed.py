"""Fixed bed of Table 1 against its exact solution (paper section 3, Fig 1): error for each `l`, difference between
them, convergence in time and cells, energy budget, cost. `./hotbed validate fixed_bed [--quick]`.

--quick takes a column of a quarter of the height with the same cells; its bounds hold for the same area between the
curves, so they are four times larger as a mean over the height.
"""

import argparse
import itertools
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "fixed_bed"
sys.path[:0] = [str(ROOT / "cfd_solver"), str(CASE)]
import plot
import results
import schumann
from run import prepare, run_case

RATIOS = ("1", "1.5", "2", "2.5")


def deviation(z, theta, exact):
    """(mean over the height, largest) of the absolute difference."""
    difference = np.abs(theta - exact)
    return difference.mean(), difference.max()


def run_all(jobs, workers=2):
    """Runs prepared folders, as many at once as there are cores."""
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(run_case, jobs))


def errors(run):
    """{time: (L1 gas, max gas, L1 particles, max particles)} of a run against the exact solution."""
    times, z, gas, particle = plot.profiles(run)
    out = {}
    for t in times:
        zp, theta = particle[t]
        out[t] = (*deviation(z, gas[t], schumann.solution(z, t)[0]),
                  *deviation(zp, theta, schumann.solution(zp, t)[1]))
    return out


def convergence(figures, folder):
    """L1 at the last time over the time step and over the cells, on the short column with l = 2."""
    variants = {}
    for factor in (4, 2, 1, 0.5, 0.25):
        variants["time", factor] = {"deltaT": 2.5e-3 * factor}
    for cells in (25, 50, 200):
        variants["cells", cells] = {"cellsHeight": cells, "deltaT": 2.5e-3 * 100 / cells}
    jobs = {key: folder / f"convergence-{key[0]}-{key[1]}" for key in variants}
    for key, change in variants.items():
        prepare(CASE, jobs[key], {"l": "2", **{k: f"{v:g}" for k, v in change.items()}}, overwrite=True)
    run_all(list(jobs.values()))
    last = {key: max(errors(run).items())[1] for key, run in jobs.items()}
    last["cells", 100] = last["time", 1]
    finest = plot.profiles(jobs["time", 0.25])
    print("\nconvergence on the short column, l = 2, at the last time: mean differences, order against the row above")
    print("      gas step [ms]   gas to exact   particles to exact   gas to the finest step   order")
    before = None
    for factor in (4, 2, 1, 0.5):
        gas, _, particles, _ = last["time", factor]
        times, _, theta, _ = plot.profiles(jobs["time", factor])
        own = np.abs(theta[times[-1]] - finest[2][times[-1]]).mean()
        order = "" if before is None else f"{np.log2(before / own):6.2f}"
        print(f"    {2.5 * factor:14g}   {gas:.3e}      {particles:.3e}            {own:.3e}             {order}")
        figures.rows.append({"name": f"convergence in time, {2.5 * factor:g} ms", "value": [gas, particles, own]})
        before = own
    print("              cells   gas to exact   particles to exact   order")
    before = None
    for cells in (25, 50, 100, 200):
        gas, _, particles, _ = last["cells", cells]
        order = "" if before is None else f"{np.log2(before / gas):6.2f}"
        print(f"    {cells:14d}   {gas:.3e}      {particles:.3e}          {order}")
        figures.rows.append({"name": f"convergence in cells, {cells}", "value": [gas, particles]})
        before = gas
    change = max(abs(last["time", 0.5][n] / last["time", 1][n] - 1) for n in (0, 2))
    figures.add("change of L1 when the gas step is halved", change, 0.20)


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate fixed_bed", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a column of a quarter of the height")
    options = parser.parse_args()
    figures = results.Figures("fixed_bed")
    folder = Path("results") / "fixed_bed" / ("validate-quick" if options.quick else "validate")
    scale = 4.0 if options.quick else 1.0

    runs = {l: folder / f"l={l}" for l in RATIOS}
    for l, run in runs.items():
        prepare(CASE, run, {"l": l}, full=not options.quick, overwrite=True)
    run_all(list(runs.values()))

    for l, run in runs.items():
        for t, (gas, gas_max, particles, particles_max) in errors(run).items():
            figures.add(f"l = {l}, {t:g} s: gas, mean difference to exact", gas, 2e-3 * scale)
            figures.add(f"l = {l}, {t:g} s: particles, mean difference to exact", particles, 2e-3 * scale)
            figures.add(f"l = {l}, {t:g} s: gas, largest difference", gas_max, 1.5e-2)
            figures.add(f"l = {l}, {t:g} s: particles, largest difference", particles_max, 1.5e-2)
    profiles = {l: plot.profiles(run) for l, run in runs.items()}
    for a, b in itertools.combinations(RATIOS, 2):
        worst = 0.0
        for t in profiles[a][0]:
            z, particles = profiles[a][1], [np.interp(profiles[a][1], *profiles[l][3][t]) for l in (a, b)]
            worst = max(worst, deviation(z, profiles[a][2][t], profiles[b][2][t])[0],
                        deviation(z, *particles)[0])
        figures.add(f"l = {a} against l = {b}: mean difference, worst of all times", worst, 1e-3 * scale)
    for l, run in runs.items():
        bed = results.bed(run)
        figures.add(f"l = {l}: energy not accounted for, of the heat exchanged", abs(bed["budget_error"][-1]), 1e-9)
        outside = max(bed["gas_T_max_K"].max() - plot.HOT, plot.COLD - bed["gas_T_min_K"].min())
        figures.add(f"l = {l}: gas temperature beyond its bounds [K]", outside, 1e-9)
        table = results.timing(run)
        exchange = sum(table[name] for name in ("to gas", "to particles"))
        particles = bed["particles"][-1]
        figures.note(f"l = {l}: particles", particles)
        if l == "1" and not options.quick:
            figures.add("l = 1: exchange, seconds a step on one core", exchange, 0.25)
            figures.add("l = 1: peak memory, bytes a particle", table["memory"] * 2**20 / particles, 2000)
        else:
            figures.note(f"l = {l}: exchange, seconds a step on one core", exchange)
    plot.draw(runs, folder / "temperature.png")
    print(f"picture: {folder}/temperature.png")
    convergence(figures, folder)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
