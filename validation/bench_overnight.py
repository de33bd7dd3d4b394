"""The paper's bed for 25 s at the default settings (l = 2.5, 0.20 m/s) on two ranks, extrapolated from half a second of the moving
bed. `./hotbed bench overnight [--quick]`; needs two free cores.

Goes on from the bed after 0.2 s (--quick: 0.02 s, from which 0.02 s are run), which is made once and kept in
results/fluidized_bed/bench. Setting up is not counted, output is.
"""

import argparse
import re
import sys
from pathlib import Path

import paper_bed  # makes the next two known
import campaign
import results

RANKS, END = 2, 25.0


def main():
    parser = argparse.ArgumentParser(prog="hotbed bench overnight", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="0.02 s from an earlier state")
    options = parser.parse_args()
    figures = results.Figures("overnight", verb="bench")
    begin, length = (0.02, 0.02) if options.quick else (0.2, 0.5)
    source, run = paper_bed.start("2.5", begin), Path("results") / "overnight" / "bench"
    begin = campaign.reached(source)
    campaign.branch(paper_bed.CASE, source, run, {"endTime": f"{begin + length:g}"}, RANKS)
    log = (run / "log.hotbedFoam").read_text()
    steps = int(re.search(r"(?m)^Timing \(.* (\d+) steps\)", log)[1])
    phases = results.timing(run)
    hours = END / length / 3600
    figures.note("simulated, from [s]", begin)
    figures.note("simulated, for [s]", length)
    figures.note("mean gas step [s]", length / steps)
    figures.note("time of that [s]", results.loop_time(phases) * steps)
    for name, seconds in (("DEM", phases["DEM"]), ("gas", phases["gas"]), ("exchange", results.exchange_time(phases))):
        figures.note(f"of that {name}", seconds / results.loop_time(phases))
    figures.note("25 s on two ranks: processor time of a rank [h]", results.seconds_a_step(run / "log.hotbedFoam", 1) * steps * hours)
    figures.add("25 s on two ranks [h]", results.loop_time(phases) * steps * hours, 16)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
