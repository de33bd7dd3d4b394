#!/usr/bin/python3
"""What it does to a moving bed that particles answer to the gas as closures told some gas steps ago (`closureCo`): examples/slim_bed at
`l = 2.5` with gas steps of 5e-5 s, answers kept as by default or not at all, three runs each that differ by a millionth of the gas
velocity. Three minutes a run.

    ./hotbed --version >/dev/null   # builds
    /usr/bin/python3 validation/studies/kept_answers.py
"""

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ("validation", "cfd_solver")]
import campaign
import results
from run import read_settings

CASE = ROOT / "examples" / "slim_bed"
VALUES, REPEATS = ("0", "0.2"), 3
START, END = 0.2, 0.7  # [s], of the means


def figures(run):
    """cooling [K], mean Nusselt number, mean pressure drop and its standard deviation [Pa]"""
    bed = results.bed(run)
    moving = bed["time_s"] > START
    return [-np.diff(np.interp([START, END], bed["time_s"], bed["T_mean_K"]))[0], campaign.mean(bed, "Nu_mean", START, END)[0],
            bed["pressure_drop_Pa"][moving].mean(), bed["pressure_drop_Pa"][moving].std()]


def main():
    u0 = float(read_settings(CASE / "settings")["u0"])
    plan = [{"l": "2.5", "u0": f"{u0 * nudge:.9g}", "closureCo": value, "deltaT": "5e-5", "maxDeltaT": "5e-5", "endTime": f"{END}",
             "writeInterval": "0.35"} for nudge in campaign.NUDGES[:REPEATS] for value in VALUES]
    runs = campaign.run_all(CASE, Path("results") / "studies" / "kept_answers", plan)
    sets = {value: [run for run, settings in zip(runs, plan) if settings["closureCo"] == value] for value in VALUES}
    rows = {value: np.array([figures(run) for run in sets[value]]) for value in VALUES}
    deviation, freedom = campaign.spread(list(rows.values()))
    for value in VALUES:
        part = results.evaluated((sets[value][0] / "log.hotbedFoam").read_text())
        cooling, nusselt, drop, waves = rows[value].mean(axis=0)
        print(f"closureCo {value}, closures in {part:.0%} of the steps: cooling from {START} to {END} s {cooling:.4f} K, "
              f"Nusselt {nusselt:.4f}, pressure drop {drop:.2f} Pa, its deviation {waves:.2f} Pa")
    cooling, nusselt, drop, waves = campaign.bar(deviation, freedom, REPEATS, REPEATS)
    print(f"bar of the difference of two: {cooling:.4f} K, {nusselt:.4f}, {drop:.2f} Pa, {waves:.2f} Pa")


if __name__ == "__main__":
    main()
