"""The slim bed from its start on a lattice: pressure-drop plateau against the weight of the particles over the
cross-section, conservation, and cooling and Nusselt number over `l`. `./hotbed validate slim_bed [--quick]`: --quick
takes the two coarsest `l` only, 0.25 s."""

import argparse
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "slim_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import campaign
import results
from validate_fluidized_bed import report


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate slim_bed", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="l = 2 and 2.5, 0.25 s")
    options = parser.parse_args()
    figures = results.Figures("slim_bed")
    folder = Path("results") / "slim_bed" / ("validate-quick" if options.quick else "validate")
    ratios, end, start = (("2.5", "2"), 0.25, 0.1) if options.quick else (("2.5", "2", "1.5"), 1.5, 0.2)
    runs = campaign.run_all(CASE, folder, [{"l": l, "endTime": f"{end}", "writeInterval": "0.05"} for l in ratios])
    for run in runs:
        report(figures, run, start, plateau=not options.quick)
    beds = [results.bed(run) for run in runs]
    nusselt = [campaign.mean(bed, "Nu_mean", start, end) for bed in beds]
    for l, bed, (value, error) in list(zip(ratios, beds, nusselt))[1:]:
        # from the start on: before, hot particles meet cold gas, the more of it above the bed the wider their kernels
        drops = [np.subtract(*np.interp([start, end], b["time_s"], b["T_mean_K"])) for b in (beds[0], bed)]
        figures.add(f"cooling from {start} to {end} s, l = 2.5 against {l}, relative", abs(drops[0] / drops[1] - 1), 0.01,
                    f"{drops[0]:.4f} and {drops[1]:.4f} K")
        figures.note(f"cooling in the first {start} s, l = 2.5 less l = {l} [K]",
                     np.interp(start, bed["time_s"], bed["T_mean_K"]) - np.interp(start, beds[0]["time_s"], beds[0]["T_mean_K"]))
        figures.add(f"mean Nusselt number, l = 2.5 against {l}, relative", abs(nusselt[0][0] / value - 1), 0.01,
                    f"{nusselt[0][0]:.3f} +- {nusselt[0][1]:.3f} and {value:.3f} +- {error:.3f}")
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
