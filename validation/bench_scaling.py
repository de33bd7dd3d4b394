"""How the cost grows with particles and ranks. `./hotbed bench scaling [--quick]`; the figures of two ranks need two free
cores.

Contacts: beds of the paper's shape of 3,072 to 720,000 particles, LIGGGHTS with the contact law alone, one rank, in turn,
`run 100` as often as makes a time of it, since each `run` takes the list of pairs anew; a bed's time is the least of seven; the
largest also twice at the same time, which tells what two ranks can gain on a machine that shares its memory. Coupled: the
paper's bed, `l = 1.5`, gas steps of 40 DEM steps on one and two ranks in turn, from what a coupled run left at 0.05 s (made
once and kept in results/fluidized_bed/bench), the first steps left out; from its lattice start bytes that a rank sends for the
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


def particle_steps(folder, numbers, rounds, copies=1):
    """Nanoseconds of one step of one particle in beds of the paper's shape that have settled, of the slowest of some copies that run
    at the same time. The beds take turns, so that all meet the same hour of the machine.

    @return [rounds, beds]
    """
    def bed(number):
        layer = [round(n * (number / 720000)**(1 / 3)) for n in (80, 50)]
        height = 1.2 * number / np.prod(layer) * 2.5 * contact_scenes.DIAMETER
        place = folder / f"bed,{number}"
        settled, _ = contact_scenes.settled(place, layer, number, height, steps=2000)
        runs = max(1, round(1.5e5 / number))
        return place, contact_scenes.script(contact_scenes.ours, settled, [50] + [100] * runs), 100 * runs * number

    def seconds(place, text):
        with ThreadPoolExecutor(copies) as pool:
            return max(pool.map(lambda copy: sum(contact_scenes.liggghts(place, f"settled.{copy}", text, 1)[0][1:]), range(copies)))

    beds = [bed(number) for number in numbers]
    return np.array([[seconds(place, text) / size * 1e9 for place, text, size in beds] for _ in range(rounds)])


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
    # other programs on the processor only add to a time: the least one is that of the bed
    cost = particle_steps(folder, numbers, 7)
    for n, times in zip(numbers, cost.T):
        figures.note(f"{n} particles: a particle-step, least of 7 [ns]", times.min())
        figures.note(f"{n} particles: median of 7 [ns]", float(np.median(times)))
    least = cost.min(axis=0)
    figures.add("a particle-step, largest over smallest of all sizes", least.max() / least.min(), 1.25)
    figures.note(f"{numbers[-1]} particles: a particle-step of each of two copies at once, over that of one alone",
                 particle_steps(folder, numbers[-1:], 3, 2).min() / least[-1])

    l, begin, repeats = ("2.5", 0.02, 7) if options.quick else ("1.5", 0.05, 9)
    source = paper_bed.start(l, begin)
    pairs = np.array([[results.loop_time(paper_bed.a_gas_step(source, folder / f"l={l},ranks={ranks}", l, STEP, 5, 25, ranks))
                       for ranks in (1, 2)] for _ in range(repeats)])
    ratio = pairs[:, 0] / pairs[:, 1]
    figures.note(f"l = {l}: seconds a gas step, one rank", float(np.median(pairs[:, 0])))
    figures.add(f"l = {l}: time on one rank over that on two", np.median(ratio), 1.7, f"{ratio.min():.2f} to {ratio.max():.2f}", least=True)

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
