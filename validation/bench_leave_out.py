"""What a scene that needs less saves: the slim bed (`l = 2`) with a turbulence model, heat, friction, moving particles and
output, against the same with each of them left out. `./hotbed bench leave_out [--quick]`. All forms run in turn, from the
same lattice; the gas is too slow to lift the bed, so that it is in contact all over when the steps are counted. They are counted in
spans of two outputs each, and the shortest of all spans is a form's: other programs on the processor only add to it, and more than some
forms save."""

import argparse
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "slim_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
from campaign import edit
from run import prepare, run_case

SETTLED, SPAN = 200, 100  # gas steps
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


def run(folder, form, end):
    """@return processor seconds a gas step of each span"""
    target = folder / form.replace(" ", "_")
    prepare(CASE, target, {"u0": "0.03", "deltaT": "1e-4", "maxDeltaT": "1e-4", "endTime": f"{end}", "writeInterval": "0.005"}, overwrite=True)
    edits = FORMS[form]
    if edits is not None:
        for name, dimensions in (("nut", "[0 2 -1 0 0 0 0]"), ("alphat", "[1 -1 -1 0 0 0 0]")):
            (target / "0" / name).write_text(FIELD.format(name=name, dimensions=dimensions))
    for file, pattern, replacement in ([LAMINAR, *edits] if edits is not None else []):
        edit(target / file, pattern, replacement)
    run_case(target)
    return np.diff(results.processor_times(target / "log.hotbedFoam")[SETTLED - 1::SPAN]) / SPAN


def main():
    parser = argparse.ArgumentParser(prog="hotbed bench leave_out", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer runs")
    options = parser.parse_args()
    figures = results.Figures("leave_out", verb="bench")
    folder = Path("results") / "leave_out" / "bench"
    seconds = {form: [] for form in FORMS}
    for _ in range(3 if options.quick else 9):
        for form in FORMS:
            seconds[form].extend(run(folder, form, 0.1))
    everything = seconds["everything"]
    figures.note("everything: seconds a gas step", min(everything))
    for form in list(FORMS)[1:]:
        figures.add(f"{form}: time over that of everything", min(seconds[form]) / min(everything), 1,
                    f"of medians {np.median(seconds[form]) / np.median(everything):.3f}, {len(everything)} spans")
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
