"""The paper's bed (Table 2) from its start on a lattice: pressure-drop plateau against the weight of the particles over the
cross-section. `./hotbed validate fluidized_bed [--quick]`: `l = 2.5`, 0.20 m/s, 1 s on two ranks, ten minutes; goes on
where it was stopped. --quick: `l = 5` for 0.35 s (2 minutes), too short for a plateau: there the momentum balance counts. Longer, at
three velocities and with the paper's figures: `validate paper --bed fluidized_bed`."""

import argparse
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "fluidized_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import campaign
import results
from run import read_settings

DENSITY, GRAVITY = 1040, 9.81
FLUIDISED = 0.2  # [s] the lattice has lifted off and broken up


def report(figures, run, start, plateau=True):
    """The figures of one run, means in time from `start` [s] on.

    @param plateau  whether that is long enough for the mean pressure drop to be the weight: some rises and falls of the bed
    """
    setting = {k: float(v) for k, v in read_settings(run / "settings").items()}
    weight = setting["solids"] * DENSITY * GRAVITY / (setting["width"] * setting["depth"])
    bed = results.bed(run)
    end = bed["time_s"][-1]
    drop, error = campaign.mean(bed, "pressure_drop_Pa", start, end)
    nusselt, nusseltError = campaign.mean(bed, "Nu_mean", start, end)
    case = f"l = {setting['l']:g}, u0 = {setting['u0']:g} m/s"
    if plateau:
        figures.add(f"{case}: pressure drop from {start:.3g} to {end:.3g} s against the weight, relative", abs(drop / weight - 1),
                    0.03, f"{drop:.1f} +- {error:.1f} Pa, weight {weight:.1f} Pa")
    else:
        figures.note(f"{case}: pressure drop from {start:.3g} to {end:.3g} s over the weight", drop / weight)
    # what the gas gave the particles beyond their weight is their momentum, and what the walls rub off
    force = drop - weight / GRAVITY * campaign.acceleration(bed, start, end)
    figures.add(f"{case}: the same less the change of the particles' momentum", abs(force / weight - 1), 0.03,
                f"{force:.1f} Pa, {force / weight - 1:+.1%}")
    figures.add(f"{case}: energy not accounted for, of the exchange", abs(bed["budget_error"][-1]), 1e-8)
    figures.add(f"{case}: taken from one phase less given to the other, worst step", bed["mismatch"].max(), 1e-12)
    figures.add(f"{case}: gas outside inlet and hottest particle [K]",
                max(293.15 - bed["gas_T_min_K"].min(), bed["gas_T_max_K"].max() - 363.15), 1e-9)
    figures.note(f"{case}: mean temperature at the end [K]", bed["T_mean_K"][-1])
    figures.note(f"{case}: mean Nusselt number", nusselt)
    figures.note(f"{case}: its standard error", nusseltError)
    timing = results.timing(run)
    figures.note(f"{case}: wall time of the last piece of the run [s]", results.wall_time(run))
    figures.note(f"{case}: of that gas, a step [s]", timing["gas"])
    figures.note(f"{case}: of that DEM, a step [s]", timing["DEM"])


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate fluidized_bed", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="l = 5, 0.35 s")
    options = parser.parse_args()
    figures = results.Figures("fluidized_bed")
    folder = Path("results") / "fluidized_bed" / ("validate-quick" if options.quick else "validate")
    l, end, start = ("5", "0.35", 0.15) if options.quick else ("2.5", "1.0", FLUIDISED)
    run, = campaign.run_all(CASE, folder, [{"l": l, "u0": "0.2", "endTime": end, "writeInterval": "0.05"}], at_once=1, ranks=2)
    report(figures, run, start, plateau=not options.quick)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
