"""Share of what is between gas and particles (weights, voidage, closures, drag, momentum and heat to and fro) in the time of the
paper's bed at 10 DEM steps a gas step (2.5e-5 s), one rank. `./hotbed bench exchange [--quick]`.

Each `l` goes on from the same bed after 0.05 s of a coupled run at the default settings (--quick: 0.02 s, `l` = 2.5 and 1.5
alone), made once and kept in results/fluidized_bed/bench. Two runs from there, one longer than the other, give the time of the
steps between, so the first steps are left out; output is left out, too. A figure is the median of several such pairs. Times are
those of the table that closes each log. The same with closures in every gas step (`closureCo 0`) in turn, to compare with.
"""

import argparse
import shutil
import sys
from pathlib import Path

import numpy as np

import paper_bed  # makes the next two known
import campaign
import results


def main():
    parser = argparse.ArgumentParser(prog="hotbed bench exchange", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="l = 2.5 and 1.5, from an earlier state, fewer steps")
    options = parser.parse_args()
    figures = results.Figures("exchange", verb="bench")
    folder = Path("results") / "exchange" / "bench"
    ratios, end, number = (("2.5", "1.5"), 0.02, 30) if options.quick else (("2.5", "2", "1.5", "1"), 0.05, 60)
    for l in ratios:
        source = paper_bed.start(l, end)
        pairs, each = [], []
        for _ in range(3):
            for runs, settings in ((pairs, {}), (each, {"closureCo": "0"})):
                runs.append(paper_bed.a_gas_step(source, folder / f"l={l}", l, 2.5e-5, 10, number, **settings))
        phases = {name: float(np.median([pair[name] for pair in pairs])) for name in pairs[0]}
        particles = results.bed(source)["particles"][-1]
        figures.note(f"l = {l}: simulated time at the start [s]", campaign.reached(source))
        for name in ("DEM", "gas"):
            figures.note(f"l = {l}: {name}, seconds a gas step", phases[name])
        shares = []
        for text, runs in ((", closures in every step", each), ("", pairs)):
            exchange = np.array([results.exchange_time(run) for run in runs])
            shares.append(exchange / [results.loop_time(run) - run.get("output", 0.0) for run in runs])
            figures.note(f"l = {l}: between the two, nanoseconds a particle and gas step{text}", float(np.median(exchange)) / particles * 1e9)
            figures.note(f"l = {l}: spread of the share, largest less smallest{text}", float(np.ptp(shares[-1])))
        name = f"l = {l}: share of weights, closures and exchange"
        figures.note(f"{name}, closures in every step", float(np.median(shares[0])))
        figures.add(name, np.median(shares[1]), 0.15)
    shutil.rmtree(folder, ignore_errors=True)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
