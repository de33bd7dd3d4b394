"""The slim bed from its start on a lattice: pressure-drop plateau against the weight of the particles over the
cross-section, conservation, and cooling and Nusselt number over `l`, the two coarsest run three times: what they differ by is the bar.
`./hotbed validate slim_bed [--quick]`: --quick takes the two coarsest `l` only, once, 0.25 s."""

import argparse
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "slim_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import campaign
import results
from run import read_settings
from validate_fluidized_bed import report


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate slim_bed", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="l = 2 and 2.5, 0.25 s")
    options = parser.parse_args()
    figures = results.Figures("slim_bed")
    folder = Path("results") / "slim_bed" / ("validate-quick" if options.quick else "validate")
    ratios, end, start = (("2.5", "2"), 0.25, 0.1) if options.quick else (("2.5", "2", "1.5"), 1.5, 0.2)
    often = {l: 1 if options.quick or l == "1.5" else 3 for l in ratios}  # beds are chaotic: repeats tell how far two may differ
    plan = [(l, nudge) for repeat, nudge in enumerate(campaign.NUDGES) for l in ratios if repeat < often[l]]
    u0 = float(read_settings(CASE / "settings")["u0"])
    folders = campaign.run_all(CASE, folder, [{"l": l, "u0": f"{u0 * nudge:.9g}", "endTime": f"{end}", "writeInterval": "0.05"}
                                              for l, nudge in plan])
    runs = {l: [run for run, (ratio, _) in zip(folders, plan) if ratio == l] for l in ratios}
    for first, *_ in runs.values():
        report(figures, first, start, plateau=not options.quick)
    beds = {l: [results.bed(run) for run in runs[l]] for l in ratios}
    # from the start on: before, hot particles meet cold gas, the more of it above the bed the wider their kernels
    cooling = {l: np.array([np.subtract(*np.interp([start, end], b["time_s"], b["T_mean_K"])) for b in beds[l]]) for l in ratios}
    nusselt = {l: np.array([campaign.mean(b, "Nu_mean", start, end)[0] for b in beds[l]]) for l in ratios}
    at_start = {l: np.mean([np.interp(start, b["time_s"], b["T_mean_K"]) for b in beds[l]]) for l in ratios}
    for l in ratios[1:]:
        for what, values, unit in ((f"cooling from {start} to {end} s", cooling, " K"), ("mean Nusselt number", nusselt, "")):
            means, bar = [values[ratio].mean() for ratio in ("2.5", l)], 0.0
            if not options.quick:
                deviation, freedom = campaign.spread([values["2.5"], values["2"]])
                bar = campaign.bar(deviation, freedom, often["2.5"], often[l]) / means[1]
            figures.add(f"{what}, l = 2.5 against {l}, relative", abs(means[0] / means[1] - 1), max(0.01, bar),
                        f"{means[0]:.4f} and {means[1]:.4f}{unit}" + (f", bar {bar:.2%}" if bar else ""))
        figures.note(f"cooling in the first {start} s, l = 2.5 less l = {l} [K]", at_start[l] - at_start["2.5"])
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
