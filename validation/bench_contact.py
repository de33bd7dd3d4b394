"""Speed of the contact law, walls and integration against LIGGGHTS' own `hooke/stiffness tangential history`, `nve/sphere` and
`gravity`, on the same bed with the same constants and neighbour lists. `./hotbed bench contact [--quick]`.

A settled bed of 46,080 particles (the paper's at l = 2.5) and the same bed shaken, every particle at 0.2 m/s in some
direction, on one and two ranks. Stock and ours run in turn in the unmodified `liggghts`; the first steps are left out. A
figure is the median of the ratios of runs that followed each other.
"""

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

import results

ROOT = Path(__file__).resolve().parent.parent
LIBRARY = Path(os.environ.get("HOTBED_BUILD", ROOT / "build")) / "liggghts_fixes" / "libhotbed_liggghts.so"
WIDTH, DEPTH, HEIGHT = 0.2, 0.04, 0.03
RATIO, DIAMETER, DENSITY, KN, EN, ET, FRICTION = 2.5, 5e-4, 1040.0, 500.0, 0.74, 0.1, 0.1
D = RATIO * DIAMETER
LAYER, NUMBER = (160, 32), 46080


def constants():
    """LIGGGHTS' constants of the coarse particles: stiffnesses, dashpots over the effective mass of two particles"""
    m = DENSITY * np.pi / 6 * D**3
    n, t = np.log(EN), np.log(ET)
    kn = RATIO**3 * KN
    kt = 2 / 7 * kn * (np.pi**2 + t**2) / (np.pi**2 + n**2)
    etan = -2 * n * np.sqrt(m / 2 * kn / (np.pi**2 + n**2))
    etat = -2 * t * np.sqrt(m / 7 * kt / (np.pi**2 + t**2))
    return {"kn": kn, "kt": kt, "gamman": etan / (m / 2), "gammat": etat / (m / 2)}


STOCK = ("hooke/stiffness tangential history", {**constants(), "coefficientFriction": FRICTION})
OURS = ("hotbed tangential hotbed", {"kn": KN, "coefficientRestitution": EN, "tangentialRestitution": ET,
                                     "coefficientFriction": FRICTION})


def script(law, data, steps):
    model, values = law
    properties = "".join(f"fix {name} all property/global {name} peratomtypepair 1 {value:.15g}\n"
                         for name, value in values.items())
    walls = "".join(f"fix {axis}{n} all wall/gran model {model} primitive type 1 {axis}plane {at}\n"
                    for axis, high in (("x", WIDTH), ("y", DEPTH), ("z", HEIGHT)) for n, at in enumerate((0, high)))
    integration = ("fix integrate all nve/sphere/hotbed gravity 9.81 vector 0 0 -1" if law is OURS else
                   "fix gravity all gravity 9.81 vector 0 0 -1\nfix integrate all nve/sphere")
    ratio = f"fix cg all hotbed/coarsegrain ratio {RATIO}\n" if law is OURS else ""
    return f"""units si
atom_style granular
boundary f f f
newton off
communicate single vel yes
processors * 1 1
read_data {data}
neighbor 1e-4 bin
neigh_modify delay 0
{ratio}{properties}pair_style gran model {model}
pair_coeff * *
{walls}{integration}
timestep 2.5e-6
thermo 1000000
""" + "".join(f"run {n}\n" for n in steps)


def liggghts(folder, name, text, ranks):
    """Runs a script. @return seconds of each `run`"""
    (folder / f"in.{name}").write_text(text)
    command = ["liggghts", "-in", f"in.{name}", "-log", f"log.{name}", "-screen", "none"]
    if ranks > 1:
        command = ["mpirun", "--allow-run-as-root", "-np", str(ranks), *command]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace",
                          env=dict(os.environ, LD_PRELOAD=str(LIBRARY)))
    log = (folder / f"log.{name}").read_text(errors="replace")
    if done.returncode:
        sys.exit(f"liggghts failed in {folder}:\n{log[-2000:]}{done.stderr[-2000:]}")
    return [float(t) for t in re.findall(r"Loop time of (\S+)", log)]


def write(path, position, velocity):
    """A LIGGGHTS data file of equal particles; velocity with spin, [n, 6]"""
    n = len(position)
    atoms = "\n".join(f"{i + 1} 1 {D:.6g} {DENSITY} {x:.10g} {y:.10g} {z:.10g}" for i, (x, y, z) in enumerate(position))
    motion = "\n".join(f"{i + 1} " + " ".join(f"{c:.10g}" for c in v) for i, v in enumerate(velocity))
    path.write_text(f"bed\n\n{n} atoms\n1 atom types\n0 {WIDTH} xlo xhi\n0 {DEPTH} ylo yhi\n0 {HEIGHT} zlo zhi\n\n"
                    f"Atoms\n\n{atoms}\n\nVelocities\n\n{motion}\n")


def settle(folder, steps=8000):
    """Writes the bed settled for some steps and the shaken one as data files; kept for the next time."""
    if (folder / "data.shaken").exists():
        return
    random = np.random.default_rng(1)
    k, row = np.divmod(np.arange(NUMBER), LAYER[0] * LAYER[1])
    j, i = np.divmod(row, LAYER[0])
    velocity = np.zeros((NUMBER, 6))
    velocity[:, :3] = random.normal(0, 0.05, (NUMBER, 3))
    write(folder / "data.lattice", np.stack([i + 0.5, j + 0.5, k + 0.5], axis=1) * D, velocity)
    dump = (f"dump bed all custom {steps} end.* x y z vx vy vz omegax omegay omegaz\n"
            f'dump_modify bed format "{" ".join(["%.10g"] * 9)}"\n')
    text = script(OURS, "data.lattice", [steps])
    liggghts(folder, "settle", text.replace("timestep", dump + "timestep"), 2)
    end = np.loadtxt(folder / f"end.{steps}", skiprows=9)
    write(folder / "data.settled", end[:, :3], end[:, 3:])
    velocity[:, :3] *= 0.2 / np.sqrt(np.mean(np.sum(velocity[:, :3]**2, axis=1)))
    write(folder / "data.shaken", end[:, :3], velocity)


def main():
    parser = argparse.ArgumentParser(prog="hotbed bench contact", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer and shorter runs")
    options = parser.parse_args()
    figures = results.Figures("contact", verb="bench")
    folder = (Path("results") / "contact" / "bench").resolve()
    folder.mkdir(parents=True, exist_ok=True)
    settle(folder)
    repeats, steps = (3, 200) if options.quick else (5, 400)
    bounds = {("settled", 1): 2.3, ("settled", 2): 2.0, ("shaken", 1): 2.0, ("shaken", 2): 2.0}
    for (bed, ranks), bound in bounds.items():
        seconds = {"stock": [], "ours": []}
        for _ in range(repeats):
            for name, law in (("stock", STOCK), ("ours", OURS)):
                text = script(law, f"data.{bed}", [100, steps])
                seconds[name].append(liggghts(folder, f"{bed}.{name}", text, ranks)[1])
        ratio = np.array(seconds["stock"]) / seconds["ours"]
        where = f"{bed} bed, {ranks} rank{'s' if ranks > 1 else ''}"
        for name, times in seconds.items():
            figures.note(f"{where}: {name}, million particle-steps a second", NUMBER * steps / np.median(times) / 1e6)
        figures.note(f"{where}: spread of the ratio, largest less smallest", float(np.ptp(ratio)))
        figures.add(f"{where}: stock's time over ours", np.median(ratio), bound, least=True)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
