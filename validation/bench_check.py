"""The time that `hotbed check` tells against the time that the run takes. `./hotbed bench check [--quick]`; needs free cores.

Every example that is a case, checked and then run, on one rank, then on two: settling_particle, fixed_bed, cylinder_bed, slim_bed
at `l` = 2 and (beds too large to settle while they are checked) at `l` = 1, the paper's bed at `l` = 2.5 for 1 s. --quick: the
slim bed at `l` = 2.5, 0.4 s. From each bed also what check takes for beds that have not settled (check_rows.py): cost of a DEM step
after a fall through the bed's height over that before, largest gas velocity over u0/voidage.
"""

import argparse
import re
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cfd_solver"))
import check
import check_rows
import results
from run import prepare, start

CASES = [("settling_particle", {}), ("fixed_bed", {}), ("cylinder_bed", {}), ("slim_bed", {}), ("slim_bed", {"l": "1"}),
         ("fluidized_bed", {"l": "2.5", "endTime": "1"})]
SCENES = [(*case, ranks) for ranks in (1, 2) for case in CASES if ranks == 1 or case[0] != "settling_particle"]
QUICK = [("slim_bed", {"l": "2.5", "endTime": "0.4"}, ranks) for ranks in (1, 2)]


def steps_of(run):
    """[gas steps, 4]: time [s], Courant number, DEM steps, processor time of the first rank so far [s]"""
    log = (run / "log.hotbedFoam").read_text()
    return np.array(re.findall(r"Time = (\S+)  Courant (\S+)  DEM steps (\d+)[\s\S]*?ExecutionTime = (\S+) s", log), float)


def after_settling(run, facts):
    """(cost of a DEM step from two fall times on over that up to one, largest gas velocity over u0/voidage), None where nothing moves
    or the run is too short."""
    fall, (time, courant, dem_steps, cpu) = check_rows.fall_time(facts), steps_of(run).T
    if not fall or time[-1] < 3 * fall:
        return None
    phases = results.timing(run)
    gas = (results.loop_time(phases) - phases["DEM"]) * cpu[-1] / results.wall_time(run)  # of a gas step

    def dem_step(within):
        spent, steps = np.ptp(cpu[within]), within.sum() - 1
        return (spent - gas * steps) / dem_steps[within][1:].sum()

    late = time > 2 * fall
    rate = np.average(courant[late] / np.diff(time, prepend=0)[late])
    even = facts["u0"] / facts["voidage"][0] / facts["cell"][1]
    return dem_step(late) / dem_step((time > 0.1 * fall) & (time < fall)), rate / even


def main():
    parser = argparse.ArgumentParser(prog="hotbed bench check", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="the slim bed at l = 2.5, 0.4 s")
    parser.add_argument("--example", choices=dict(CASES), help="only the scenes of this one")
    parser.add_argument("--seconds", type=float, default=10, help="as that of hotbed check (default 10)")
    options = parser.parse_args()
    scenes = [s for s in (QUICK if options.quick else SCENES) if options.example in (None, s[0])]
    if not scenes:
        parser.error(f"--quick has no scene of {options.example}")
    figures = results.Figures("check" + (f"-{options.example}" if options.example else ""), verb="bench")
    folder = Path("results") / "check" / "bench"
    for name, settings, ranks in scenes:
        case, label = ROOT / "examples" / name, " ".join([name, *(f"{k}={v}" for k, v in settings.items()), f"-np {ranks}"])
        facts, control, _, refused = check.measure(case, settings, ranks, options.seconds)
        if refused:
            sys.exit(f"{label}: {refused}")
        estimate, gas_steps, _ = check_rows.wall_time(facts, control, ranks)
        run = folder / label.replace(" ", ",")
        prepare(case, run, settings, ranks=ranks, overwrite=True)
        begin = time.monotonic()
        if start(run, ranks).wait():
            sys.exit(f"{label}: the run failed, see {run / 'log.hotbedFoam'}")
        steps, wall = steps_of(run), time.monotonic() - begin  # of the solver, from its start as a program
        figures.add(f"{label}: time told against that taken, off", abs(estimate / wall - 1), 0.3,
                    f"told {estimate:.3g} s{'' if check_rows.settled(facts) else ' (not settled)'}, taken {wall:.3g} s, "
                    f"processor {steps[-1, 3]:.0f} s")
        figures.note(f"{label}: gas steps told over those taken", gas_steps / len(steps))
        if found := after_settling(run, facts):
            figures.note(f"{label}: DEM step after settling over that before", found[0])
            figures.note(f"{label}: largest gas velocity over u0/voidage", found[1])
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
