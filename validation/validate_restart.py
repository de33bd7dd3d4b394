"""A run that stops and goes on against one without a stop, on the same and on another number of ranks, and runs killed at
random moments. `./hotbed validate restart [--quick]`: 20 kills, --quick 5.

Scene: examples/slim_bed, l = 2.5, half as high, stopped after 0.02 s when the bed is in contact and moving, compared 200 DEM
steps later.
"""

import argparse
import random
import re
import shutil
import signal
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "slim_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
from campaign import edit
import run as hotbed

STOP, LATER, STEP = 0.02, 200, 2.5e-6
SMALL = {"l": "2.5", "height": "0.05", "cellsHeight": "40"}


def scene(folder, name, ranks, step, end, interval):
    """@param step gas step [s], the longest one where it follows the Courant number"""
    run = folder / name
    hotbed.prepare(CASE, run, {**SMALL, "maxDeltaT": step, "endTime": f"{end}", "writeInterval": f"{interval}"},
                   ranks=ranks, overwrite=True)
    # digits beyond the bound: pressure, dump
    edit(run / "system/fvSolution", r"tolerance\s+1e-7;\s*relTol\s+0.01;", "tolerance 1e-10; relTol 0;")
    edit(run / "DEM/in.bed", r"^dump .*$",
         f"dump particles all custom {LATER} DEM/post/particles*.txt id x y z vx vy vz f_Temp\n"
         'dump_modify particles sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g"')
    return run


def particles(run, step):
    """x y z vx vy vz T by particle id"""
    rows = np.loadtxt(run / f"DEM/post/particles{step}.txt", skiprows=9)
    return rows[np.argsort(rows[:, 0]), 1:]


def difference(a, b):
    """Largest difference of positions (of a particle's diameter), velocities (of the largest), temperatures (of
    themselves)."""
    scale = np.array([1.25e-3] * 3 + [np.abs(a[:, 3:6]).max()] * 3 + [363.15])
    return np.max(np.abs(a - b) / scale)


def went_on(whole, name, ranks):
    """A copy of a run, gone on with from STOP on another number of ranks. @return its folder"""
    target = whole.parent / name
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(whole, target)
    for dump in target.glob("DEM/post/particles*"):
        if int(re.findall(r"\d+", dump.name)[0]) > STOP / STEP * (1 + 1e-9):
            dump.unlink()
    hotbed.resume(target, ranks=ranks)
    hotbed.run_case(target, ranks)
    return target


def compare(figures, folder):
    step = round(STOP / STEP) + LATER
    for ranks, other, gasStep, text in ((1, 2, "2.5e-5", ""), (2, 1, "2.5e-5", ""), (1, 4, "1e-4", ", gas step by Courant number")):
        whole = scene(folder, f"whole-{ranks}-{gasStep}", ranks, gasStep, STOP + 1.5 * LATER * STEP, STOP)
        hotbed.run_case(whole, ranks)
        expected = particles(whole, step)
        for number, bound in ((ranks, 1e-12), (other, 1e-8)):
            run = went_on(whole, f"{whole.name}-on-{number}", number)
            figures.add(f"stopped on {ranks}, gone on with on {number} ranks{text}: {LATER} DEM steps later",
                        difference(expected, particles(run, step)), bound)


def kill(figures, folder, kills):
    moments = random.Random(1)
    interval = 0.002
    run = scene(folder, "killed", 1, "1e-4", 1.0, interval)
    lost = refused = 0
    worst = reached = 0.0
    for _ in range(kills):
        process = hotbed.start(run)
        time.sleep(moments.uniform(0.3, 3))
        process.send_signal(signal.SIGKILL)
        refused += process.wait() != -signal.SIGKILL
        times = [float(t) for t in re.findall(r"^Time = (\S+)", (run / "log.hotbedFoam").read_text(), re.M)]
        if not times:
            continue  # killed while it was starting
        worst = max(worst, reached - times[0])
        lost += times[0] < reached - interval - 2e-4
        reached = times[-1]
    edit(run / "settings", r"endTime\s+\S+;", f"endTime {reached + 0.002:.4f};")
    hotbed.run_case(run)
    figures.add(f"{kills} kills: runs that refused to go on", refused, 0)
    figures.add(f"{kills} kills: runs that lost more than the time since the last write", lost, 0,
                f"most lost {worst:.4f} s, written every {interval} s, reached {reached:.3f} s")
    figures.add(f"{kills} kills: energy not accounted for at the end, of the exchange",
                abs(results.bed(run)["budget_error"][-1]), 1e-8)


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate restart", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="five kills")
    options = parser.parse_args()
    figures = results.Figures("restart")
    folder = Path("results") / "restart" / ("validate-quick" if options.quick else "validate")
    compare(figures, folder)
    kill(figures, folder, 5 if options.quick else 20)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
