"""How the cost grows with particles and ranks. `./hotbed bench scaling [--quick]`; the figures of two ranks need two free
cores.

Contacts: beds of 3,072 to 720,000 particles, LIGGGHTS with the contact law alone, one rank. Coupled: the paper's bed from its
lattice start: `l = 1.5` on one and two ranks in turn, bytes that a rank sends for the exchange on 2, 4 and 8 ranks, memory
at `l = 1`. --quick leaves out the largest beds and takes `l = 2.5` for the ranks.
"""

import argparse
import re
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "fluidized_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import bench_contact
import results
from run import prepare, run_case

STEP = 1e-4


def a_particle_step(folder, number):
    """Nanoseconds of one step of one particle in a bed 9 particles deep that has been shaken."""
    across = int(round((number / 9) ** 0.5))
    layer = (across, -(-number // (9 * across)))
    bench_contact.WIDTH, bench_contact.DEPTH = (n * bench_contact.D for n in layer)
    bench_contact.LAYER, bench_contact.NUMBER = layer, number
    folder = folder / f"{number}"
    folder.mkdir(parents=True, exist_ok=True)
    bench_contact.settle(folder, 2000)
    steps = max(20, int(1.5e7 / number))
    times = [bench_contact.liggghts(folder, "settled", bench_contact.script(bench_contact.OURS, "data.settled", [50, steps]), 1)[1]
             for _ in range(3)]
    return np.median(times) / steps / number * 1e9


def coupled(folder, l, ranks, steps):
    """A few steps of the paper's bed. @return (seconds a step, bytes sent by a rank a step, MiB)"""
    run = folder / f"l={l},ranks={ranks}"
    prepare(CASE, run, {"l": l, "deltaT": f"{STEP}", "maxDeltaT": f"{STEP}", "endTime": f"{steps * STEP:g}", "writeInterval": "1"},
            ranks=ranks, overwrite=True)
    run_case(run, ranks)
    phases = results.timing(run)
    log = (run / "log.hotbedFoam").read_text()
    sent = re.search(r"sent by a rank a step\s+([\d.e+]+) KiB", log)
    return results.loop_time(phases), float(sent[1]) * 1024 if sent else 0.0, phases["memory"]


def main():
    parser = argparse.ArgumentParser(prog="hotbed bench scaling", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="without the largest beds")
    options = parser.parse_args()
    figures = results.Figures("scaling", verb="bench")
    folder = (Path("results") / "scaling" / "bench").resolve()

    numbers = (3072, 11520, 46080, 184320) if options.quick else (3072, 11520, 46080, 184320, 720000)
    cost = {n: a_particle_step(folder, n) for n in numbers}
    for n, nanoseconds in cost.items():
        figures.note(f"{n} particles: a particle-step [ns]", nanoseconds)
    figures.add("a particle-step, largest over smallest of all sizes", max(cost.values()) / min(cost.values()), 1.25)

    l, repeats = ("2.5", 3) if options.quick else ("1.5", 3)
    pairs = np.array([[coupled(folder, l, ranks, 20)[0] for ranks in (1, 2)] for _ in range(repeats)])
    figures.note(f"l = {l}: seconds a gas step, one rank", float(np.median(pairs[:, 0])))
    figures.add(f"l = {l}: time on one rank over that on two", np.median(pairs[:, 0] / pairs[:, 1]), 1.7, least=True)

    sent = {ranks: coupled(folder, "2.5", ranks, 5)[1] for ranks in (2, 4, 8)}
    for ranks, size in sent.items():
        figures.note(f"l = 2.5, {ranks} ranks: most that a rank sends for the exchange a step [KiB]", size / 1024)
    # two ranks share one face; of eight, two across the depth, an inner one has three smaller ones
    figures.add("sent by a rank, 8 ranks over 2", sent[8] / sent[2], 2.5)

    if not options.quick:
        figures.add("l = 1, 720,000 particles, one rank: peak memory [MiB]", coupled(folder, "1", 1, 5)[2], 2048)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
