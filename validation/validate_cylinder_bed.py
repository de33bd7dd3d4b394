"""A bed in a cylinder, whose cells are no boxes and whose wall is an STL surface, to the bounds of the beds in boxes.
`./hotbed validate cylinder_bed [--quick]`: --quick takes two velocities of the fixed bed and a shorter fluidised one.

Fixed: particles that fill the cylinder evenly at a voidage of 0.4, without contacts; the pressure gradient over the middle of
the bed against Beetstra's correlation; hot gas from below for the energy budget. Fluidised:
examples/cylinder_bed, the mean pressure drop over the cross-section of the gas mesh and what floor and wall carry, by LIGGGHTS' own
account, against the weight of particles and gas and what the particles gain of momentum.
"""

import argparse
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "cylinder_bed"
sys.path[:0] = [str(ROOT / "cfd_solver"), str(ROOT / "examples")]
import campaign
import results
from bed_pictures import Run
from run import prepare, run_case, tool
from stability_scenes import beetstra

VISCOSITY, DENSITY, DIAMETER = 1.8e-5, 300.0, 5e-4  # gas of constant density
COLD, HOT, GRAVITY = 293.15, 363.15, 9.81
WINDOW = 0.5  # of the mean of the fluidised bed [s]
AVERAGED = 1000  # DEM steps that a line of the forces of floor and wall is the mean of
RADIUS, SIDES, HEIGHT, CELLS = 0.008, 24, 0.03, 22
AREA = SIDES / 2 * np.sin(2 * np.pi / SIDES) * RADIUS**2  # the gas mesh is a prism
COARSE, SOLIDS = 2 * DIAMETER, 0.6


def packing():
    """Particles that fill the cylinder evenly, in layers on a golden spiral: lines of a LIGGGHTS script."""
    volume = np.pi / 6 * COARSE**3
    layer = round(AREA * (SOLIDS / volume)**(2 / 3))
    spacing = layer * volume / (AREA * SOLIDS)
    k = np.arange(layer)
    r, angle = np.sqrt(AREA / np.pi * (k + 0.5) / layer), np.pi * (3 - np.sqrt(5)) * k
    lines = [f"create_atoms 1 single {x:.9g} {y:.9g} {(n + 0.5) * spacing:.9g} units box" for n in range(int(HEIGHT / spacing + 1e-6))
             for x, y in zip(r * np.cos(angle + n), r * np.sin(angle + n))]
    return "\n".join([*lines, f"set group all diameter {COARSE} density 1040", ""])


def gradient(voidage, u0):
    """-dp/dz for a superficial velocity [Pa/m], see validate_bed_pressure.py."""
    beta = beetstra(voidage, DENSITY * u0 * DIAMETER / VISCOSITY)
    return 18 * VISCOSITY * (1 - voidage) * beta * u0 / voidage / DIAMETER**2


def at_the_end(run, *names):
    """Fields that a run wrote last, or `Cz` and `V` of its cells."""
    last = max((p for p in run.iterdir() if (p / "p").is_file()), key=lambda p: float(p.name))
    for function in ("writeCellCentres", "writeCellVolumes"):
        tool(run, "postProcess", "-func", function, "-time", last.name)
    return [results.field(last / name) for name in names]


def fixed(folder, u0):
    """@return (pressure gradient [Pa/m] and mean voidage of the middle, bed.csv) of a run of the fixed bed"""
    run = folder / f"fixed,u0={u0}"
    step = 2.5e-4 / u0
    case = folder / f"case,u0={u0}"
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(CASE, case)
    script = case / "DEM/in.bed"
    for pattern, replacement in ((r"(?s)^# a lattice a little.*?(?=\nlabel +filled)", packing()), (r"^(fix +(integrate|gravity|zlow|zhigh|side|surface|drag|m\d)|pair_style|pair_coeff|newton|neigh_modify) .*\n", ""),
                                 (r"^timestep.*", "timestep ${deltaT}"), (r"^variable +every .*", "variable every equal 1000000"),
                                 (r"^boundary.*", "boundary f f f\nnewton off\natom_modify sort 0 0")):
        campaign.edit(script, pattern, replacement)
    campaign.edit(script, r"initial_temperature \S+", f"initial_temperature {COLD}")
    campaign.edit(case / "0/T", r"inlet .*", f"inlet {{ type fixedValue; value uniform {HOT}; }}")
    campaign.edit(case / "constant/thermophysicalProperties", r"perfectGas", "rhoConst")
    campaign.edit(case / "constant/thermophysicalProperties", r"^( *)thermodynamics", f"    equationOfState {{ rho {DENSITY}; }}\n    thermodynamics")
    campaign.edit(case / "constant/g", r"-9\.81", "0")
    campaign.edit(case / "constant/couplingProperties", r"^kernelWidth", "writeRestart no;\nbedInterval 1;\nkernelWidth")
    campaign.edit(case / "system/controlDict", r"^adjustTimeStep.*", "adjustTimeStep no;")
    prepare(case, run, {"u0": f"{u0}", "height": f"{HEIGHT}", "cellsHeight": f"{CELLS}", "deltaT": f"{step}",
                        "endTime": f"{40 * step}", "writeInterval": f"{40 * step}"}, overwrite=True)
    run_case(run)
    p, z, V, voidage = at_the_end(run, "p", "Cz", "V", "voidage")
    middle = (z > 0.2 * HEIGHT) & (z < 0.8 * HEIGHT)
    slope = np.polyfit(z[middle], p[middle], 1, w=np.sqrt(V[middle]))[0]
    return -slope, np.average(voidage[middle], weights=V[middle]), results.bed(run)


def fluidised(folder, settings):
    """@return folders of runs of examples/cylinder_bed that write what floor and wall carry"""
    case = folder / "case"
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(CASE, case)
    script = case / "DEM/in.bed"
    campaign.edit(script, r"mesh/surface file", "mesh/surface/stress file")
    campaign.edit(script, r"^fix +zlow .*", r"\g<0> store_force yes")
    campaign.edit(script, r"^thermo .*", "compute floor all reduce sum f_force_zlow[3]\nfix carried all ave/time "
                  f"1 {AVERAGED} {AVERAGED} c_floor f_surface[3] file DEM/post/carried${{resume}}.txt\n\\g<0>")
    campaign.edit(case / "constant/couplingProperties", r"^kernelWidth", "bedInterval 1;\n\\g<0>")
    return campaign.run_all(case, folder, settings)


def balance(scene, start, end):
    """Means from `start` to `end` [s], over the weight of the particles: pressure drop and its standard error, what floor and wall
    carry, weight of the gas at the end, what the particles gain of momentum."""
    run = scene.folder
    drop, error = campaign.mean(scene.bed, "pressure_drop_Pa", start, end)
    lines = np.vstack([np.loadtxt(file) for file in sorted((run / "DEM/post").glob("carried?.txt"))])
    time = lines[:, 0] * float(scene.setting["deltaTDEM"])
    inside = (time > start) & (time <= end)
    if abs(np.ptp(time[inside]) - (end - start)) > 0.02 * (end - start):
        sys.exit(f"hotbed: {run}/DEM/post/carried*.txt does not reach from {start:g} to {end:g} s: remove {run} and run again")
    floor, wall = lines[inside, 1:].mean(axis=0) / scene.area
    mass, V = at_the_end(run, "gasMass", "V")
    gas = mass @ V * GRAVITY / scene.area
    return *(np.array([drop, error, floor, wall, gas]) / scene.weight()), campaign.acceleration(scene.bed, start, end) / GRAVITY


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate cylinder_bed", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="two velocities, shorter")
    options = parser.parse_args()
    figures = results.Figures("cylinder_bed")
    folder = Path("results") / "cylinder_bed" / ("validate-quick" if options.quick else "validate")
    velocities = (0.001, 0.1) if options.quick else (0.001, 0.01, 0.03, 0.1, 0.3)
    with ThreadPoolExecutor(2) as pool:
        for u0, (value, voidage, bed) in zip(velocities, pool.map(lambda u0: fixed(folder, u0), velocities)):
            figures.add(f"fixed bed, u0 = {u0} m/s: pressure gradient against eq 5, relative",
                        abs(value / gradient(1 - SOLIDS, u0) - 1), 1e-2, f"{value:.5g} Pa/m")
            figures.add(f"fixed bed, u0 = {u0} m/s: voidage of its middle, off", abs(voidage - 1 + SOLIDS), 2e-3)
            conservation(figures, f"fixed bed, u0 = {u0} m/s", bed, 1e-9)
    beds = [{"l": "2.5", "u0": "0.15", "endTime": "0.8"}] if options.quick else [
        {"l": l, "u0": u0, "endTime": "1"} for l, u0 in (("2.5", "0.15"), ("2.5", "0.2"), ("2", "0.15"))]
    softer = {"kn": "50", "deltaTDEM": "6.25e-6"}
    for run in fluidised(folder, [{**settings, **softer} for settings in beds]):
        scene = Run(run)
        end = scene.bed["time_s"][-1]
        drop, error, floor, wall, gas, gained = balance(scene, end - WINDOW, end)
        label = f"fluidised, l = {scene.l:g}, u0 = {scene.u0:g} m/s"
        figures.add(f"{label}: pressure drop, floor and wall less weight and momentum, {end - WINDOW:.3g} to {end:.3g} s, of the weight",
                    abs(drop + floor + wall - 1 - gas - gained), 0.005,
                    f"{drop:.2%} +- {error:.2%}, {floor:.2%}, {wall:.2%} less 100 % + {gas:.2%}, {gained:.2%}")
        figures.add(f"{label}: particles lost", np.ptp(scene.bed["particles"]), 0)
        conservation(figures, label, scene.bed, 1e-8)
    sys.exit(figures.close())


def conservation(figures, case, bed, budget):
    figures.add(f"{case}: energy not accounted for, of the exchange", np.abs(bed["budget_error"]).max(), budget)
    figures.add(f"{case}: taken from one phase less given to the other, worst step", bed["mismatch"].max(), 1e-12)
    figures.add(f"{case}: gas outside inlet and hottest particle [K]",
                max(COLD - bed["gas_T_min_K"].min(), bed["gas_T_max_K"].max() - HOT), 1e-9)


if __name__ == "__main__":
    main()
