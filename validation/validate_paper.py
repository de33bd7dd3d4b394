"""The paper's campaign: mean temperature and Nusselt number of a fluidised bed at every coarse-graining ratio and velocity
against the finest one (Figs 5 and 11), and against a bed whose gas leaves at the particles' mean temperature.

`./hotbed validate paper [--bed BED] [--ratios L ...] [--velocities U0 ...] [--until T] [--quick] [--figures [FOLDER]]`: the slim
bed at `l` = 1, 1.5, 2, 2.5 for 5 s, hours; stopped runs go on. Coarse runs, and the finest at the lowest velocity, are repeated
with a velocity that differs by a millionth: the bed is chaotic, and its repeats tell how far two runs differ where nothing is
different. `--bed fluidized_bed`: the paper's own bed at `l` = 2 and 2.5 for 2.5 s, each run once; the bar of its Nusselt numbers
comes from blocks of time. Also the figures of `validate fluidized_bed`, over that longer time. `--bed slim_bed_wide`: a column
twice as wide and deep, at the lowest velocity, 3 s.
--quick: `l` = 2 and 2.5 of the slim bed, one velocity, 1 s.

Writes small tables, results/paper*.csv, and from them and the runs the paper's figures 2 to 12 beside the runs. Temperatures and
Nusselt numbers are compared from the tables, so with runs of before, too, that the tables keep, and results/paper*.json keeps
what else was told of those. --figures runs nothing: it makes the tables anew from the runs that have come to the end (or to
--until), if there are any, draws the figures, in FOLDER if one is given, and tells what tables and runs tell."""

import argparse
import itertools
import re
import shutil
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cfd_solver"))
import campaign
import paper_figures
import paper_tables
import results
import run as hotbed
import validate_fluidized_bed
from bed_pictures import Run
from paraview import read_dump

# bed -> (end of the runs [s], ratios, velocities [m/s])
VELOCITIES = ["0.14", "0.2", "0.3"]
BEDS = {"slim_bed": (5, ["2.5", "2", "1.5", "1"], VELOCITIES), "slim_bed_wide": (3, ["2.5", "2", "1.5", "1"], VELOCITIES[:1]),
        "fluidized_bed": (2.5, ["2.5", "2"], VELOCITIES)}
QUICK = (1, ["2.5", "2"], ["0.2"])
IN_PLACE = {"wallSetback": "0"}  # these beds were run before walls stood back
WIDE = {"width": "0.04", "depth": "0.02", "cellsWidth": "32", "cellsDepth": "16", "solids": "1.25663706e-5", **IN_PLACE}
HOT, COLD = 363.15, 293.15  # particles at the start, gas at the inlet [K]


def repeats(bed, l, u0):
    """How often a run is made. Fine beds take long; those that bubble least scatter most."""
    if bed == "fluidized_bed":
        return 1
    often = {"1": 3, "2": 5, "2.5": 5} if (bed, u0) == ("slim_bed", "0.14") else {"2": 2, "2.5": 3}
    return often.get(l, 1)


def cooling_time(case, setting, u0):
    """Heat capacity of the particles over that of the gas that enters in a second [s]: tau of `T = COLD + 70 exp(-t/tau)`."""
    gas = (case / "constant/thermophysicalProperties").read_text()
    script = (case / "DEM/in.bed").read_text()
    number = lambda pattern, text: float(re.search(pattern + r"\s+(\S+?)[;\s]", text)[1])
    particles = float(setting["solids"]) * number("density", script) * number("peratomtype", script)
    flow = 101325 * number("molWeight", gas) / (8314.46 * COLD) * u0 * float(setting["width"]) * float(setting["depth"])
    return particles / (flow * number("Cp", gas))


def compare(figures, u0, tau, table, start):
    """Figures of one velocity, from the table of temperatures and Nusselt numbers in time.

    @param tau    see `cooling_time`
    @param start  of the means of the Nusselt number [s]
    @return mean Nusselt numbers of all runs, standard errors from blocks of time of each
    """
    groups = {l: table.repeats(u0, l) for l in table.ratios(u0)}
    finest = min(groups)
    times = groups[finest][0]["time_s"]
    late = times >= start
    repeated = any(len(g) > 1 for g in groups.values())
    values = {l: np.array([lines["T_mean_K"] for lines in g]) for l, g in groups.items()}
    numbers = {l: np.array([lines["Nu_mean"][late].mean() for lines in g]) for l, g in groups.items()}
    errors = {l: [campaign.mean(lines, "Nu_mean", start, times[-1])[1] for lines in g] for l, g in groups.items()}
    deviation, freedom = np.zeros(len(times)), 1  # no bars of temperatures without repeats
    if repeated:
        deviation, freedom = campaign.spread([v for v in values.values() if len(v) > 1])
        deviationNu, _ = campaign.spread([n for n in numbers.values() if len(n) > 1])
    reference, referenceNu = values[finest].mean(axis=0), numbers[finest].mean()
    for l in sorted(groups)[1:]:
        allowed = campaign.bar(deviation, freedom, len(values[l]), len(values[finest]))
        away = np.abs(values[l].mean(axis=0) - reference)
        beyond = np.where(away > allowed, away, 0) / (HOT - reference)
        worst = np.argmax(away / (HOT - reference))
        figures.add(f"u0 = {u0:g} m/s, l = {l:g} against {finest:g}: mean temperature, of the drop, beyond its bar", beyond.max(),
                    0.01, f"largest {away[worst] / (HOT - reference[worst]):.2%} at {times[worst]:.2f} s, " +
                    (f"bar there {allowed[worst] / (HOT - reference[worst]):.2%}" if repeated else "one run each, no bar"))
        allowed = (campaign.bar(deviationNu, freedom, len(numbers[l]), len(numbers[finest])) if repeated else
                   campaign.bar_from_blocks(errors[l], errors[finest])) / referenceNu
        figures.add(f"u0 = {u0:g} m/s, l = {l:g} against {finest:g}: mean Nusselt number", abs(numbers[l].mean() / referenceNu - 1),
                    max(0.01, allowed), f"{numbers[l].mean():.3f} and {referenceNu:.3f}, bar {allowed:.2%}")
    drop = (HOT - COLD) * -np.expm1(-times / tau)
    for l in sorted(groups):
        away = HOT - values[l].mean(axis=0) - drop
        worst = np.argmax(np.abs(away / drop))
        figures.add(f"u0 = {u0:g} m/s, l = {l:g}: mean temperature against gas that leaves at it, of the drop",
                    abs(away[worst] / drop[worst]), 0.02, f"at {times[worst]:.2f} s; {away[-1] / drop[-1]:+.2%} at the end, tau {tau:.1f} s")
    return np.concatenate(list(numbers.values())), list(itertools.chain(*errors.values()))


def of_runs(figures, u0, l, tau, runs, end, start):
    """Figures that take more than the tables hold. @param runs  repeats"""
    beds = [results.bed(run) for run in runs]
    even = np.linspace(start, end, 2000)  # lines are as far apart as gas steps are long
    figures.note(f"u0 = {u0:g} m/s, l = {l:g}: standard deviation of the pressure drop [Pa]",
                 np.mean([np.interp(even, bed["time_s"], bed["pressure_drop_Pa"]).std() for bed in beds]))
    figures.note(f"u0 = {u0:g} m/s, l = {l:g}: mean bed height [m]",
                 np.mean([np.interp(even, bed["time_s"], bed["height_m"]).mean() for bed in beds]))
    dumps = {time: read_dump(file) for time, file in sorted(Run(runs[0]).dumps.items()) if time <= end + 1e-9}
    top = [d["f_Temp"][d["z"] >= np.quantile(d["z"], 0.8)].mean() for d in dumps.values()]
    cooled = HOT - np.interp(end, beds[0]["time_s"], beds[0]["T_mean_K"])
    carried = np.trapz(np.array(top) - COLD, list(dumps)) / tau
    figures.add(f"u0 = {u0:g} m/s, l = {l:g}: mean temperature against gas that leaves at that of the uppermost fifth, of the drop",
                abs(cooled / carried - 1), 0.02, f"{cooled:.3f} and {carried:.3f} K at the end")


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate paper", description=__doc__)
    parser.add_argument("--bed", choices=BEDS, default="slim_bed", help="what to run")
    parser.add_argument("--until", type=float, help="end of the runs [s] (default 5; slim_bed_wide 3; fluidized_bed 2.5; quick 1)")
    parser.add_argument("--ratios", nargs="+", metavar="L", help="coarse-graining ratios, the coarsest first; the finest is compared "
                        "with (default 2.5 2 1.5 1; fluidized_bed and quick 2.5 2)")
    parser.add_argument("--velocities", nargs="+", metavar="U0", choices=VELOCITIES, help="of the campaign, to make it in pieces")
    parser.add_argument("--at-once", type=int, default=2, help="runs at a time, one core each (default 2)")
    parser.add_argument("--quick", action="store_true", help="l = 2 and 2.5, one velocity, 1 s")
    parser.add_argument("--figures", nargs="?", const="", metavar="FOLDER", help="run nothing, draw the paper's figures")
    options = parser.parse_args()
    slim = options.bed == "slim_bed"
    end, ratios, velocities = QUICK if options.quick else BEDS[options.bed]
    end, ratios, velocities = options.until or end, options.ratios or ratios, options.velocities or velocities
    start = 0.4 * end if end < 5 else 2.5  # the paper leaves out its first 2.5 s
    folder = Path("results") / "paper" / (options.bed + ("-quick" if options.quick else ""))
    example, case = ROOT / "examples" / options.bed.removesuffix("_wide"), folder / "case"
    changed = {"slim_bed": {}, "slim_bed_wide": WIDE, "fluidized_bed": IN_PLACE}[options.bed]
    name = "paper" if slim else "paper_" + options.bed
    stem = Path("results") / (name + ("-quick" if options.quick else ""))  # of the tables

    plan = [(l, u0, nudge) for repeat, nudge in enumerate(campaign.NUDGES) for l, u0 in itertools.product(ratios, velocities)
            if repeat < repeats(options.bed, l, u0)]
    settings = [{"l": l, "u0": f"{float(u0) * nudge:.9g}", "endTime": f"{end:g}", "writeInterval": "0.1"} for l, u0, nudge in plan]
    if options.figures is None:
        shutil.copytree(example, case, dirs_exist_ok=True)
        hotbed.change_settings(case / "settings", changed)
        # else the particles heat the gas they start in at once, the more of it the wider their kernels
        campaign.edit(case / "0/T", rf"^internalField   uniform {COLD}", f"internalField   uniform {HOT}")
        campaign.run_all(case, folder, settings, options.at_once)
    folders = {key: folder / campaign.name(s) for key, s in zip(plan, settings) if campaign.done(folder / campaign.name(s), s)}
    if not folders and not paper_tables.path(stem, "").is_file():
        sys.exit(f"hotbed: neither runs that have reached {end:g} s in {folder} nor {stem}.csv: run the campaign, or give --until")
    times = np.linspace(0.1, end, 50)
    runs, shown = paper_tables.make(stem, folders, times, start) if folders else ({}, [])
    pictures = Path(options.figures or folder)
    pictures.mkdir(parents=True, exist_ok=True)
    paper_figures.draw(stem, runs, shown, start, pictures)

    figures = results.Figures(name)
    table = paper_tables.Table(stem)
    setting = {**hotbed.read_settings(example / "settings"), **changed}
    tau = {u0: cooling_time(example, setting, u0) for u0 in table.velocities}
    means, errors = zip(*(compare(figures, u0, tau[u0], table, start) for u0 in table.velocities))
    for n, ((slow, fast), (above, below)) in enumerate(zip(itertools.pairwise(table.velocities), itertools.pairwise(means))):
        bar = campaign.bar_of_difference(above, below) if slim else campaign.bar_from_blocks(*errors[n:n + 2])
        figures.add(f"mean Nusselt number at {fast:g} m/s less than at {slow:g} m/s, all ratios, over the bar of the difference",
                    (above.mean() - below.mean()) / bar, 1.0, f"{below.mean():.3f} and {above.mean():.3f}, bar {bar:.3f}", least=True)
    for what, value in paper_tables.distances(stem, HOT).items():
        figures.note(what, value)
    for u0, l in sorted({(u0, l) for l, u0, _ in folders}):
        runs = [run for key, run in folders.items() if key[:2] == (l, u0)]
        of_runs(figures, float(u0), float(l), tau[float(u0)], runs, end, start)
    for run in folders.values() if options.bed == "fluidized_bed" else ():
        validate_fluidized_bed.report(figures, run, validate_fluidized_bed.FLUIDISED)
    # as the tables keep the lines of runs whose folders are not there
    figures.keep(tuple(start for u0, l, _ in table.runs for start in
                       (f"u0 = {u0:g} m/s, l = {l:g}: ", f"l = {l:g}, u0 = {u0:g} m/s: ")))
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
