"""A gas step with voidage, drag and heat against a step of OpenFOAM's own rhoPimpleFoam on the paper's grid (32 x 20 x 160
cells), same gas, schemes, linear solvers, correctors and time step, one rank. `./hotbed bench gas [--quick]`. rhoPimpleFoam's
column is empty, which is easier for its pressure solver. Both run in turn; the first steps are left out. So do other settings of
`system/fvSolution` than those of the example, each against those.
"""

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "fluidized_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
from campaign import edit
from run import environment, prepare, run_case

STEP, SKIP = 1e-4, 5
# other settings of system/fvSolution: pattern, replacement
OTHERS = {"pressure: one level of the multigrid a time (mergeLevels 1)": (r"mergeLevels 2;.*", ""),
          "pressure: three levels (mergeLevels 3)": (r"mergeLevels 2;.*", "mergeLevels 3;"),
          "pressure: smoother DIC": (r"smoother +GaussSeidel;", "smoother DIC;"),
          "pressure: coarsest level of the multigrid solved": (r"coarsestLevelCorr\s*\{[^}]*\}", ""),
          "pressure: conjugate gradients": (r"solver +GAMG;\s+smoother +GaussSeidel;", "solver PCG; preconditioner DIC;"),
          "velocity: tolerance 1e-9": (r"1e-6;", "1e-9;"),
          "velocity: smoothSolver": (r"solver +PBiCGStab;\s+preconditioner DILU;\s+tolerance +1e-6;",
                                     "solver smoothSolver; smoother symGaussSeidel; tolerance 1e-6;"),
          "gradients made anew for each use": (r"^cache.*", "")}


def settings(steps):
    return {"deltaT": f"{STEP}", "maxDeltaT": f"{STEP}", "endTime": f"{steps * STEP:g}", "writeInterval": "1"}


def rhoPimpleFoam(folder, steps):
    """@return seconds a step"""
    prepare(CASE, folder, settings(steps), overwrite=True)
    edits = {"0/U": [(r"interstitialInletVelocity; inletVelocity uniform \(0 0 \$u0\); alpha voidage;", "fixedValue;")],
             "0/p": [("fixedFluxExtrapolatedPressure", "zeroGradient")],
             "system/controlDict": [("hotbedFoam", "rhoPimpleFoam"), (r"adjustTimeStep\s+yes", "adjustTimeStep no")],
             "system/fvSolution": [(r'"p\|pFinal"', '"p|pFinal|rho|rhoFinal"')],
             "system/fvSchemes": [(r"div\(\(muEff\*dev2\(T\(grad\(U\)\)\)\)\)",
                                   "div(phid,p) Gauss upwind; div(phi,K) Gauss linear; div(((rho*nuEff)*dev2(T(grad(U)))))")]}
    for name, changes in edits.items():
        for pattern, replacement in changes:
            edit(folder / name, pattern, replacement)
    with open(folder / "log.rhoPimpleFoam", "w") as out:
        subprocess.check_call(["rhoPimpleFoam"], cwd=folder, stdout=out, stderr=subprocess.STDOUT, env=environment())
    return results.seconds_a_step(folder / "log.rhoPimpleFoam", SKIP)


def hotbed(folder, steps, other=None):
    """@param other  pattern and replacement in system/fvSolution
    @return processor seconds a gas step, of the gas alone"""
    prepare(CASE, folder, settings(steps), overwrite=True)
    if other:
        edit(folder / "system/fvSolution", *other)
    run_case(folder)
    phases = results.timing(folder)
    return results.seconds_a_step(folder / "log.hotbedFoam", SKIP) * phases["gas"] / results.loop_time(phases)


def main():
    parser = argparse.ArgumentParser(prog="hotbed bench gas", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer and shorter runs, five minutes")
    options = parser.parse_args()
    figures = results.Figures("gas", verb="bench")
    folder = Path("results") / "gas" / "bench"
    repeats, steps = (3, 30) if options.quick else (5, 80)
    seconds = np.array([(rhoPimpleFoam(folder / "rhoPimpleFoam", steps),
                         *(hotbed(folder / "hotbedFoam", steps, other) for other in (None, *OTHERS.values())))
                        for _ in range(repeats)])
    ratio = seconds[:, 1] / seconds[:, 0]
    figures.note("rhoPimpleFoam, seconds a step", float(np.median(seconds[:, 0])))
    figures.note("gas of hotbedFoam, seconds a step", float(np.median(seconds[:, 1])))
    figures.note("spread of the ratio, largest less smallest", float(np.ptp(ratio)))
    for n, name in enumerate(OTHERS, 2):
        figures.note(f"gas step over that of the example's settings, {name}", float(np.median(seconds[:, n] / seconds[:, 1])))
    figures.add("the paper's grid: our gas step over rhoPimpleFoam's", np.median(ratio), 1.5)
    shutil.rmtree(folder / "hotbedFoam", ignore_errors=True)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
