"""How the cost grows with particles and ranks. `./hotbed bench scaling [--quick]`; the figures of two ranks need two free
cores.

Contacts: beds of the paper's shape of 3,072 to 720,000 particles, LIGGGHTS with the contact law alone, one rank; the largest
also twice at the same time, which tells what two ranks can gain on a machine that shares its memory. Coupled: the paper's
bed, `l = 1.5`, gas steps of 40 DEM steps on one and two ranks in turn, from what a coupled run left at 0.05 s (made once and
kept in results/fluidized_bed/bench), the first steps left out; from its lattice start bytes that a rank sends for the
exchange on 2, 4 and 8 ranks, and memory at `l = 1`. --quick leaves out the largest beds and takes `l = 2.5` at 0.02 s for the
ranks.
"""

import argparse
import re
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cfd_solver"))
import contact_scenes
import paper_bed
import results
from run import prepare, run_case

STEP = 1e-4


def a_particle_step(folder, number, copies=1):
    """Nanoseconds of one step of one particle in a bed of the paper's shape that has settled, of the slowest of some copies that run
    at the same time."""
    layer = [round(n * (number / 720000)**(1 / 3)) for n in (80, 50)]
    height = 1.2 * number / np.prod(layer) * 2.5 * contact_scenes.DIAMETER
    folder = folder / f"bed,{number}"
    bed, _ = contact_scenes.settled(folder, layer, number, height, steps=2000)
    steps = max(20, int(1.5e7 / number))
    text = contact_scenes.script(contact_scenes.ours, bed, [50, steps])
    with ThreadPoolExecutor(copies) as pool:
        times = [max(pool.map(lambda copy: contact_scenes.liggghts(folder, f"settled.{copy}", text, 1)[0][-1], range(copies)))
                 for _ in range(3)]
    return np.median(times) / steps / number * 1e9


def coupled(folder, l, ranks):
    """Five steps of the paper's bed from its lattice. @return folder of the run"""
    run = folder / f"l={l},ranks={ranks}"
    prepare(paper_bed.CASE, run, {"l": l, "deltaT": f"{STEP}", "maxDeltaT": f"{STEP}", "endTime": f"{5 * STEP:g}",
                                  "writeInterval": "1"}, ranks=ranks, overwrite=True)
    run_case(run, ranks)
    return run


def sent_a_step(folder, l, ranks):
    """Bytes that a rank sends for the exchange a gas step, the most of all ranks."""
    log = (coupled(folder, l, ranks) / "log.hotbedFoam").read_text()
    return float(re.search(r"sent by a rank a step\s+([\d.e+]+) KiB", log)[1]) * 1024


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

    figures.note(f"{numbers[-1]} particles: a particle-step of each of two copies at once, over that of one alone",
                 a_particle_step(folder, numbers[-1], 2) / cost[numbers[-1]])

    l, begin, repeats = ("2.5", 0.02, 3) if options.quick else ("1.5", 0.05, 5)
    source = paper_bed.start(l, begin)
    pairs = np.array([[results.loop_time(paper_bed.a_gas_step(source, folder / f"l={l},ranks={ranks}", l, STEP, 5, 25, ranks))
                       for ranks in (1, 2)] for _ in range(repeats)])
    figures.note(f"l = {l}: seconds a gas step, one rank", float(np.median(pairs[:, 0])))
    figures.add(f"l = {l}: time on one rank over that on two", np.median(pairs[:, 0] / pairs[:, 1]), 1.7, least=True)

    sent = {ranks: sent_a_step(folder, "2.5", ranks) for ranks in (2, 4, 8)}
    for ranks, size in sent.items():
        figures.note(f"l = 2.5, {ranks} ranks: most that a rank sends for the exchange a step [KiB]", size / 1024)
    # two ranks share one face; of eight, two across the depth, an inner one has three smaller ones
    figures.add("sent by a rank, 8 ranks over 2", sent[8] / sent[2], 2.5)

    if not options.quick:
        figures.add("l = 1, 720,000 particles, one rank: peak memory [MiB]",
                    results.timing(coupled(folder, "1", 1))["memory"], 2048)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
