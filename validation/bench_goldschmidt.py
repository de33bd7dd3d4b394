"""Speed of a coupled step against DPMFoam on its own tutorial lagrangian/DPMFoam/Goldschmidt (Debian package
openfoam-examples): same particles, mesh, gas step, drag law (Ergun, Wen & Yu), DEM steps a contact and a gas step, one rank.
`./hotbed bench goldschmidt [--quick]`. Both start from the same lattice and run in turn; the first steps are left out.
"""

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "validation" / "goldschmidt"
TUTORIAL = Path("/usr/share/doc/openfoam-examples/examples/lagrangian/DPMFoam/Goldschmidt")
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
from run import environment, prepare, run_case, tool

STEP, SKIP = 2e-5, 10


def dpmfoam(folder, steps):
    """@return seconds a gas step"""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(TUTORIAL, folder)
    control = folder / "system/controlDict"
    text = re.sub(r"(?m)^endTime\s.*", f"endTime {steps * STEP:g};", control.read_text())
    control.write_text(re.sub(r"(?m)^writeInterval\s.*", "writeInterval 1;", text))
    tool(folder, "blockMesh")
    with open(folder / "log.DPMFoam", "w") as out:
        subprocess.check_call(["DPMFoam"], cwd=folder, stdout=out, stderr=subprocess.STDOUT, env=environment())
    return results.seconds_a_step(folder / "log.DPMFoam", SKIP)


def hotbed(folder, steps):
    """@return seconds a gas step"""
    prepare(CASE, folder, {"endTime": f"{steps * STEP:g}"}, overwrite=True)
    run_case(folder)
    return results.seconds_a_step(folder / "log.hotbedFoam", SKIP)


def main():
    parser = argparse.ArgumentParser(prog="hotbed bench goldschmidt", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer and shorter runs, two minutes")
    options = parser.parse_args()
    if not TUTORIAL.is_dir():
        sys.exit(f"hotbed: {TUTORIAL} is missing: install the Debian package openfoam-examples")
    figures = results.Figures("goldschmidt", verb="bench")
    folder = Path("results") / "goldschmidt" / "bench"
    repeats, steps = (3, 60) if options.quick else (5, 150)
    seconds = np.array([(dpmfoam(folder / "DPMFoam", steps), hotbed(folder / "hotbedFoam", steps)) for _ in range(repeats)])
    ratio = seconds[:, 0] / seconds[:, 1]
    figures.note("DPMFoam, seconds a gas step", float(np.median(seconds[:, 0])))
    figures.note("hotbedFoam, seconds a gas step", float(np.median(seconds[:, 1])))
    figures.note("spread of the ratio, largest less smallest", float(np.ptp(ratio)))
    figures.add("Goldschmidt's bed: DPMFoam's time over ours", np.median(ratio), 10, least=True)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
