"""What a scene that needs less saves: the slim bed (`l = 2`) with a turbulence model, heat, friction, moving particles and
output, against the same with each of them left out. `./hotbed bench leave_out [--quick]`. All forms start from the same lattice; the gas
is too slow to lift the bed, so that it is in contact all over when the steps are counted. All run side by side, half a second each
in turn while the others are stopped: other programs take more of the processor at some minutes than at others, more than some
forms save. Processor time is counted."""

import argparse
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "slim_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
import run as hotbed
from campaign import edit

SETTLED, SPAN = 200, 100  # gas steps
TURN = 0.5  # [s]
SCRIPT, COUPLING = "DEM/in.bed", "constant/couplingProperties"
LAMINAR = ("constant/turbulenceProperties", r"simulationType\s+laminar;",
           "simulationType LES; LES { LESModel Smagorinsky; turbulence on; delta cubeRootVol; cubeRootVolCoeffs {} }")
FIELD = """FoamFile {{ version 2.0; format ascii; class volScalarField; object {name}; }}
dimensions {dimensions};
internalField uniform 0;
boundaryField {{ ".*" {{ type calculated; value uniform 0; }} }}
"""
# name -> edits (file, pattern, replacement); None: the field files and the model of turbulence are not added
FORMS = {
    "everything": [],
    "isothermal": [(SCRIPT, r"^fix\s+heat .*", ""), (COUPLING, r"heatTransfer\s+Gunn", "heatTransfer none"),
                   (SCRIPT, r" f_Temp f_Nusselt", "")],
    "frictionless": [(SCRIPT, r"coefficientFriction peratomtypepair 1 \S+", "coefficientFriction peratomtypepair 1 0")],
    "fixed": [(SCRIPT, r"^fix\s+(integrate|drag|gravity|[xyz](low|high)) .*", ""), (SCRIPT, r"^pair_.*", "atom_modify sort 0 0")],
    "laminar": None,
    "no output": [(SCRIPT, r"^dump .*", ""), (COUPLING, r"^drag ", "writeRestart no;\nbedInterval 1000000;\ndrag "),
                  ("settings", r"writeInterval\s+\S+;", "writeInterval 10;")],
}


def prepared(folder, form, end):
    """@return folder of the run"""
    target = folder / form.replace(" ", "_")
    hotbed.prepare(CASE, target, {"u0": "0.03", "deltaT": "1e-4", "maxDeltaT": "1e-4", "endTime": f"{end}", "writeInterval": "0.005"}, overwrite=True)
    edits = FORMS[form]
    if edits is not None:
        for name, dimensions in (("nut", "[0 2 -1 0 0 0 0]"), ("alphat", "[1 -1 -1 0 0 0 0]")):
            (target / "0" / name).write_text(FIELD.format(name=name, dimensions=dimensions))
    for file, pattern, replacement in ([LAMINAR, *edits] if edits is not None else []):
        edit(target / file, pattern, replacement)
    return target


def take_turns(runs):
    """Until all have ended; one that fails ends all."""
    processes = []
    try:
        for run in runs:
            processes.append(hotbed.start(run))
            processes[-1].send_signal(signal.SIGSTOP)
        while any(process.returncode is None for process in processes):
            for process in processes:
                process.send_signal(signal.SIGCONT)
                try:
                    if process.wait(TURN) != 0:
                        sys.exit(f"hotbed: {' '.join(process.args)} failed: see log.hotbedFoam there")
                except subprocess.TimeoutExpired:
                    process.send_signal(signal.SIGSTOP)
    finally:
        for process in processes:
            process.kill()


def main():
    parser = argparse.ArgumentParser(prog="hotbed bench leave_out", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="shorter runs")
    options = parser.parse_args()
    figures = results.Figures("leave_out", verb="bench")
    folder = Path("results") / "leave_out" / "bench"
    runs = [prepared(folder, form, 0.1 if options.quick else 0.3) for form in FORMS]
    take_turns(runs)
    spans = np.array([np.diff(np.array(results.processor_times(run / "log.hotbedFoam"))[SETTLED - 1::SPAN]) / SPAN for run in runs])
    figures.note("everything: seconds a gas step", spans[0].mean())
    for form, seconds in list(zip(FORMS, spans))[1:]:
        ratios = seconds / spans[0]
        figures.add(f"{form}: time over that of everything", seconds.mean() / spans[0].mean(), 1,
                    f"of {SPAN} gas steps {ratios.min():.2f} to {ratios.max():.2f}")
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
