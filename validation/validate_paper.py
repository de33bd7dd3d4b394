"""The paper's campaign: mean temperature and Nusselt number of a fluidised bed at every coarse-graining ratio and velocity
against the finest one (Figs 5 and 11), and against a bed whose gas leaves at the particles' mean temperature.

`./hotbed validate paper [--bed fluidized_bed] [--until T] [--quick]`: the slim bed at `l` = 1, 1.5, 2, 2.5 for 5 s, hours;
stopped runs go on. Coarse runs are repeated with a velocity that differs by a millionth: the bed is chaotic, and its repeats
tell how far two runs differ where nothing is different. `--bed fluidized_bed`: the paper's own bed at `l` = 2 and 2.5 for 2.5 s.
--quick: `l` = 2 and 2.5 of the slim bed, one velocity, 1 s."""

import argparse
import csv
import itertools
import re
import shutil
import sys
from pathlib import Path

import numpy as np
from scipy.stats import t as student

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cfd_solver"))
import campaign
import results
from run import read_settings

HOT, COLD = 363.15, 293.15  # particles at the start, gas at the inlet [K]
NUDGES = (1, 1 + 1e-6, 1 - 1e-6)  # of the velocity, for repeats


class Course:
    """A run's mean temperature and Nusselt number at even times."""

    def __init__(self, run, times):
        self.setting = {k: float(v) for k, v in read_settings(run / "settings").items()}
        self.l = self.setting["l"]
        bed = results.bed(run)
        self.temperature = np.interp(times, bed["time_s"], bed["T_mean_K"])
        self.nusselt = np.interp(times, bed["time_s"], bed["Nu_mean"])


def spread(groups):
    """Standard deviation of a run from runs that differ by nothing that matters, pooled.

    @param groups  arrays [repeats, ...]
    @return (deviation [...], degrees of freedom)
    """
    freedom = sum(len(g) - 1 for g in groups)
    squares = sum(((g - g.mean(axis=0))**2).sum(axis=0) for g in groups)
    return np.sqrt(squares / freedom), freedom


def bar(deviation, freedom, *repeats):
    """Half-width of the 95 % confidence interval of the difference of two means of so many repeats."""
    return student.ppf(0.975, freedom) * deviation * np.sqrt(sum(1 / n for n in repeats))


def cooling_time(case, setting):
    """Heat capacity of the particles over that of the gas that enters in a second [s]: tau of `T = COLD + 70 exp(-t/tau)`."""
    gas = (case / "constant/thermophysicalProperties").read_text()
    script = (case / "DEM/in.bed").read_text()
    number = lambda pattern, text: float(re.search(pattern + r"\s+(\S+?)[;\s]", text)[1])
    density = number("density", script)
    particles = setting["solids"] * density * number("peratomtype", script)
    flow = 101325 * number("molWeight", gas) / (8314.46 * COLD) * setting["u0"] * setting["width"] * setting["depth"]
    return particles / (flow * number("Cp", gas))


def compare(figures, case, u0, groups, times, start):
    """Figures of one velocity.

    @param groups  l -> [Course], repeats
    @param start   of the means of the Nusselt number [s]
    @return mean Nusselt number and its bar at the finest l
    """
    late = times >= start
    finest = min(groups)
    values = {l: np.array([c.temperature for c in g]) for l, g in groups.items()}
    numbers = {l: np.array([c.nusselt[late].mean() for c in g]) for l, g in groups.items()}
    deviation, freedom = spread([v for v in values.values() if len(v) > 1])
    deviationNu, _ = spread([n for n in numbers.values() if len(n) > 1])
    reference, referenceNu = values[finest].mean(axis=0), numbers[finest].mean()
    for l in sorted(groups)[1:]:
        allowed = bar(deviation, freedom, len(values[l]), len(values[finest]))
        away = np.abs(values[l].mean(axis=0) - reference)
        beyond = np.where(away > allowed, away, 0) / (HOT - reference)
        worst = np.argmax(away / (HOT - reference))
        figures.add(f"u0 = {u0:g} m/s, l = {l:g} against {finest:g}: mean temperature, of the drop, beyond its bar", beyond.max(),
                    0.01, f"largest {away[worst] / (HOT - reference[worst]):.2%} at {times[worst]:.2f} s, bar there "
                    f"{allowed[worst] / (HOT - reference[worst]):.2%}")
        allowed = bar(deviationNu, freedom, len(numbers[l]), len(numbers[finest])) / referenceNu
        figures.add(f"u0 = {u0:g} m/s, l = {l:g} against {finest:g}: mean Nusselt number", abs(numbers[l].mean() / referenceNu - 1),
                    max(0.01, allowed), f"{numbers[l].mean():.3f} and {referenceNu:.3f}, bar {allowed:.2%}")
    for l, runs in sorted(groups.items()):
        tau = cooling_time(case, runs[0].setting)
        drop = (HOT - COLD) * -np.expm1(-times / tau)
        away = HOT - values[l].mean(axis=0) - drop
        worst = np.argmax(np.abs(away / drop))
        figures.add(f"u0 = {u0:g} m/s, l = {l:g}: mean temperature against gas that leaves at it, of the drop",
                    abs(away[worst] / drop[worst]), 0.02, f"at {times[worst]:.2f} s; {away[-1] / drop[-1]:+.2%} at the end, tau {tau:.1f} s")
    return referenceNu, bar(deviationNu, freedom, len(numbers[finest]), len(numbers[finest]))


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate paper", description=__doc__)
    parser.add_argument("--bed", choices=("slim_bed", "fluidized_bed"), default="slim_bed", help="example to run")
    parser.add_argument("--until", type=float, help="end of the runs [s] (default 5; fluidized_bed 2.5; quick 1)")
    parser.add_argument("--at-once", type=int, default=2, help="runs at a time, one core each (default 2)")
    parser.add_argument("--quick", action="store_true", help="l = 2 and 2.5, one velocity, 1 s")
    options = parser.parse_args()
    slim = options.bed == "slim_bed"
    end = options.until or (1 if options.quick else 5 if slim else 2.5)
    ratios = ["2", "2.5"] if options.quick or not slim else ["1", "1.5", "2", "2.5"]  # the dearest first
    velocities = ["0.2"] if options.quick else ["0.14", "0.2", "0.3"]
    start = 0.4 * end if end < 5 else 2.5  # the paper leaves out its first 2.5 s
    folder = Path("results") / "paper" / (options.bed + ("-quick" if options.quick else ""))
    case = folder / "case"
    shutil.copytree(ROOT / "examples" / options.bed, case, dirs_exist_ok=True)
    # else the particles heat the gas they start in at once, the more of it the wider their kernels
    campaign.edit(case / "0/T", rf"^internalField   uniform {COLD}", f"internalField   uniform {HOT}")

    plan = [(l, u0, nudge) for l, u0 in itertools.product(ratios, velocities)
            for nudge in (NUDGES if l == ratios[-1] else NUDGES[:2 if l == "2" and slim else 1])]
    runs = campaign.run_all(case, folder, [
        {"l": l, "u0": f"{float(u0) * nudge:.9g}", "endTime": f"{end:g}", "writeInterval": "0.1"} for l, u0, nudge in plan],
        options.at_once)
    times = np.linspace(0.1, end, 50)
    courses = {key: Course(run, times) for key, run in zip(plan, runs)}
    figures = results.Figures("paper" if slim else "paper_" + options.bed)
    means = []
    for u0 in velocities:
        groups = {}
        for (l, velocity, _), course in courses.items():
            if velocity == u0:
                groups.setdefault(float(l), []).append(course)
        means.append(compare(figures, case, float(u0), groups, times, start))
    for (slow, fast), ((above, a), (below, b)) in zip(itertools.pairwise(velocities), itertools.pairwise(means)):
        figures.add(f"mean Nusselt number at {fast} m/s less than at {slow} m/s, over the bars of the two",
                    (above - below) / np.hypot(a, b), 1.0, f"{below:.3f} and {above:.3f}", least=True)
    with open(figures.folder / f"{figures.name}{'-quick' if options.quick else ''}.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["l", "u0", "nudge", "time_s", "T_mean_K", "Nu_mean"])
        for (l, u0, nudge), course in courses.items():
            for row in zip(times, course.temperature, course.nusselt):
                table.writerow([l, u0, nudge, *(f"{x:.7g}" for x in row)])
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
