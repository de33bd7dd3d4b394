"""The paper's bed in motion, for benches: states that coupled runs left, kept for the next time, and gas steps from there."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "fluidized_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import campaign
import results


def start(l, end):
    """The bed after at least `end` seconds at the default settings, run on two ranks as far as it is not there yet.
    @return folder of the run"""
    run, = campaign.run_all(CASE, Path("results") / "fluidized_bed" / "bench",
                            [{"l": l, "endTime": f"{end}", "writeInterval": "0.01"}], at_once=1, ranks=2)
    return run


def a_gas_step(source, run, l, length, skip, number, ranks=1, **settings):
    """Seconds of a gas step by phase.

    @param source  folder of `start`
    @param run     folder of the runs from there, made anew
    @param length  of the gas steps [s]
    @param skip    steps left out, together longer than half the last step of `source`, below which OpenFOAM ends at once
    @param number  steps with those
    @param settings  others of the case
    """
    runs = []
    for steps in (skip, number):
        runs.append(run.with_name(f"{run.name},steps={steps}"))
        campaign.branch(CASE, source, runs[-1], {"l": l, "deltaT": f"{length}", "maxDeltaT": f"{length}", "writeInterval": "1", **settings,
                                                 "endTime": f"{campaign.reached(source) + steps * length:.10g}"}, ranks)
    return results.between(*runs)
