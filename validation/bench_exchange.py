"""Share of what is between gas and particles (weights, voidage, closures, drag, momentum and heat to and fro) in the time of the
paper's bed at 10 DEM steps a gas step (2.5e-5 s), one rank. `./hotbed bench exchange [--quick]`.

Each `l` goes on from the same bed after 0.05 s of a coupled run at the default settings (--quick: 0.02 s, `l` = 2.5 and 1.5
alone), made once and kept in results/fluidized_bed/bench. Two runs from there, one longer than the other, give the time of the
steps between, so the first steps are left out; output is left out, too. A figure is the median of several such pairs. Times are
those of the table that closes each log.
"""

import argparse
import shutil
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "fluidized_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import campaign
import results

STEP, SKIP = 2.5e-5, 10


def start(l, end):
    """The paper's bed after at least `end` seconds, run on two ranks as far as it is not there yet. @return folder of the run"""
    run, = campaign.run_all(CASE, Path("results") / "fluidized_bed" / "bench",
                            [{"l": l, "endTime": f"{end}", "writeInterval": f"{end}"}], at_once=1, ranks=2)
    return run


def steps(source, folder, l, number):
    """Some gas steps from a state. @return folder of the run"""
    run = folder / f"l={l},steps={number}"
    campaign.branch(CASE, source, run, {"l": l, "deltaT": f"{STEP}", "maxDeltaT": f"{STEP}", "writeInterval": "1",
                                        "endTime": f"{campaign.reached(source) + number * STEP:.10g}"})
    return run


def main():
    parser = argparse.ArgumentParser(prog="hotbed bench exchange", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="l = 2.5 and 1.5, from an earlier state, fewer steps")
    options = parser.parse_args()
    figures = results.Figures("exchange", verb="bench")
    folder = Path("results") / "exchange" / "bench"
    ratios, end, number = (("2.5", "1.5"), 0.02, 30) if options.quick else (("2.5", "2", "1.5", "1"), 0.05, 60)
    for l in ratios:
        source = start(l, end)
        pairs = [results.between(*(steps(source, folder, l, n) for n in (SKIP, number))) for _ in range(3)]
        phases = {name: float(np.median([pair[name] for pair in pairs])) for name in pairs[0]}
        particles = results.bed(folder / f"l={l},steps={number}")["particles"][-1]
        exchange = np.array([results.exchange_time(pair) for pair in pairs])
        share = exchange / [results.loop_time(pair) - pair.get("output", 0.0) for pair in pairs]
        figures.note(f"l = {l}: simulated time at the start [s]", campaign.reached(source))
        for name in ("DEM", "gas"):
            figures.note(f"l = {l}: {name}, seconds a gas step", phases[name])
        figures.note(f"l = {l}: between the two, nanoseconds a particle and gas step", float(np.median(exchange)) / particles * 1e9)
        figures.note(f"l = {l}: spread of the share, largest less smallest", float(np.ptp(share)))
        figures.add(f"l = {l}: share of weights, closures and exchange", np.median(share), 0.15)
    shutil.rmtree(folder, ignore_errors=True)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
