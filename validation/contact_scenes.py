"""Beds in a box on which contacts, walls and integration are timed: LIGGGHTS scripts with our styles and with LIGGGHTS' own."""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
SLIM_BED = ROOT / "examples" / "slim_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import campaign
from run import LARGE_PAGES, read_settings

LIBRARY = Path(os.environ.get("HOTBED_BUILD", ROOT / "build")) / "liggghts_fixes" / "libhotbed_liggghts.so"
DIAMETER, DENSITY, KN, EN, ET, FRICTION = 5e-4, 1040.0, 500.0, 0.74, 0.1, 0.1  # of the original particles
GRAVITY, TIMESTEP = 9.81, 2.5e-6


@dataclass
class Bed:
    """Equal coarse particles in a box, one of LIGGGHTS' data files with positions and velocities.

    data    path of the data file
    size    of the box (width, depth, height) [m]
    ratio   coarse-graining ratio
    number  of particles
    skin    of the neighbour lists [m]
    force   on each particle [N], from files `<data>.force_x`, `_y`, `_z`, constant in time; else gravity and contacts alone
    """
    data: Path
    size: tuple
    ratio: float
    number: int
    skin: float = 1e-4
    force: bool = False

    @property
    def diameter(self):
        return self.ratio * DIAMETER


def stock(ratio, et):
    """LIGGGHTS' own law with the constants of the coarse particles: stiffnesses, dashpots over the effective mass of two."""
    m = DENSITY * np.pi / 6 * (ratio * DIAMETER)**3
    n, t = np.log(EN), np.log(et)
    kn = ratio**3 * KN
    kt = 2 / 7 * kn * (np.pi**2 + t**2) / (np.pi**2 + n**2)
    etan = -2 * n * np.sqrt(m / 2 * kn / (np.pi**2 + n**2))
    etat = -2 * t * np.sqrt(m / 7 * kt / (np.pi**2 + t**2))
    return "hooke/stiffness tangential history", {"kn": kn, "kt": kt, "gamman": etan / (m / 2), "gammat": etat / (m / 2),
                                                  "coefficientFriction": FRICTION}


def ours(ratio, et):
    """The law hotbed with the constants of the original particles, which need no `ratio`."""
    return "hotbed tangential hotbed", {"kn": KN, "coefficientRestitution": EN, "tangentialRestitution": et,
                                        "coefficientFriction": FRICTION}


def script(law, bed, steps, et=ET):
    """LIGGGHTS' script of a bed. @param law `stock` or `ours`. @param steps of each `run`. @param et tangential restitution"""
    model, values = law(bed.ratio, et)
    properties = "".join(f"fix {name} all property/global {name} peratomtypepair 1 {value:.15g}\n"
                         for name, value in values.items())
    walls = "".join(f"fix {axis}{n} all wall/gran model {model} primitive type 1 {axis}plane {at}\n"
                    for axis, high in zip("xyz", bed.size) for n, at in enumerate((0, high)))
    force = names = ""
    if bed.force:
        names = "atom_modify map array\n"
        # stock: what CFD-DEM with LIGGGHTS' own styles uses, a property of the particles that a loop adds
        name, fix = (("gasForce", "fix drag all hotbed/drag") if law is ours else
                     ("dragforce", "fix gas all couple/cfd mpi\nfix drag all couple/cfd/force"))
        read = "".join(f"variable f{axis} atomfile {bed.data}.force_{axis}\n" for axis in "xyz")
        force = f"{fix}\nrun 0\n{read}set group all property/atom {name} v_fx v_fy v_fz\n"
        force += "".join(f"variable f{axis} delete\n" for axis in "xyz")
    ratio = f"fix cg all hotbed/coarsegrain ratio {bed.ratio}\n" if law is ours else ""
    integration = (f"fix integrate all nve/sphere/hotbed gravity {GRAVITY} vector 0 0 -1\n" if law is ours else
                   f"fix gravity all gravity {GRAVITY} vector 0 0 -1\nfix integrate all nve/sphere\n")
    return f"""units si
atom_style granular
{names}boundary f f f
newton off
communicate single vel yes
processors * 1 1
read_data {bed.data}
neighbor {bed.skin} bin
neigh_modify delay 0
{ratio}{properties}pair_style gran model {model}
pair_coeff * *
{walls}{integration}timestep {TIMESTEP}
variable rise equal vcm(all,z)
thermo_style custom step v_rise
thermo 1000000
{force}""" + "".join(f"run {n}\n" for n in steps)


def liggghts(folder, name, text, ranks):
    """Runs a script. @return (seconds of each `run`, mean vertical velocity at its end)"""
    (folder / f"in.{name}").write_text(text)
    command = ["liggghts", "-in", f"in.{name}", "-log", f"log.{name}", "-screen", "none"]
    if ranks > 1:
        command = ["mpirun", "--allow-run-as-root", "-np", str(ranks), *command]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace",
                          env={**LARGE_PAGES, **os.environ, "LD_PRELOAD": str(LIBRARY)})
    log = (folder / f"log.{name}").read_text(errors="replace")
    if done.returncode:
        sys.exit(f"liggghts failed in {folder}:\n{log[-2000:]}{done.stderr[-2000:]}")
    return np.array(re.findall(r"(?m)^ *\d+ +(\S+) *\nLoop time of (\S+)", log), float)[:, ::-1].T


def write(bed, position, velocity, force=None):
    """The files of a bed. @param velocity with spin, [n, 6]"""
    atoms = "\n".join(f"{i + 1} 1 {bed.diameter:.6g} {DENSITY} {x:.10g} {y:.10g} {z:.10g}"
                      for i, (x, y, z) in enumerate(position))
    motion = "\n".join(f"{i + 1} " + " ".join(f"{c:.10g}" for c in v) for i, v in enumerate(velocity))
    box = "".join(f"0 {high} {axis}lo {axis}hi\n" for axis, high in zip("xyz", bed.size))
    for n, axis in enumerate("xyz" if bed.force else ""):
        values = "".join(f"{i + 1} {f[n]:.10g}\n" for i, f in enumerate(force))
        Path(f"{bed.data}.force_{axis}").write_text(f"{len(force)}\n{values}")
    bed.data.write_text(f"bed\n\n{bed.number} atoms\n1 atom types\n{box}\nAtoms\n\n{atoms}\n\nVelocities\n\n{motion}\n")


def settled(folder, layer, number, height=0.03, steps=8000):
    """A bed of `l` = 2.5 that settled from a lattice for some steps, and the same shaken, every particle at 0.2 m/s in some
    direction; kept for the next time.

    @param layer  particles along the width and the depth
    @return (settled, shaken)
    """
    folder.mkdir(parents=True, exist_ok=True)
    d = 2.5 * DIAMETER
    lattice, calm, shaken = (Bed(folder / f"data.{name}", (layer[0] * d, layer[1] * d, height), 2.5, number)
                             for name in ("lattice", "settled", "shaken"))
    if shaken.data.exists():
        return calm, shaken
    random = np.random.default_rng(1)
    k, row = np.divmod(np.arange(number), layer[0] * layer[1])
    j, i = np.divmod(row, layer[0])
    velocity = np.zeros((number, 6))
    velocity[:, :3] = random.normal(0, 0.05, (number, 3))
    write(lattice, np.stack([i + 0.5, j + 0.5, k + 0.5], axis=1) * d, velocity)
    dump = (f"dump bed all custom {steps} end.* x y z vx vy vz omegax omegay omegaz\n"
            f'dump_modify bed format "{" ".join(["%.10g"] * 9)}"\n')
    liggghts(folder, "settle", script(ours, lattice, [steps]).replace("timestep", dump + "timestep"), 2)
    end = np.loadtxt(folder / f"end.{steps}", skiprows=9)
    write(calm, end[:, :3], end[:, 3:])
    velocity[:, :3] *= 0.2 / np.sqrt(np.mean(np.sum(velocity[:, :3]**2, axis=1)))
    write(shaken, end[:, :3], velocity)
    return calm, shaken


def fluidised(folder, l, end=0.2):
    """The slim bed at 0.20 m/s after some time of a coupled run, with the force of the gas on each particle as it is then;
    kept for the next time. @param l as text, of the settings"""
    case = folder / "case"
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(SLIM_BED, case)
    columns = "x y z vx vy vz omegax omegay omegaz f_gasForce[1] f_gasForce[2] f_gasForce[3]"
    campaign.edit(case / "DEM/in.bed", r"^dump .*",
                  f"dump particles all custom ${{every}} DEM/post/particles*.txt {columns}\n"
                  f'dump_modify particles format "{" ".join(["%.10g"] * 12)}"')
    run, = campaign.run_all(case, folder, [{"l": l, "u0": "0.2", "endTime": f"{end}", "writeInterval": f"{end}"}], ranks=2)
    last = max((run / "DEM/post").glob("particles*.txt"), key=lambda path: int(path.stem[len("particles"):]))
    state = np.loadtxt(last, skiprows=9)
    size = tuple(float(read_settings(run / "settings")[name]) for name in ("width", "depth", "height"))
    bed = Bed(run / "data.fluidised", size, float(l), len(state), 0.3 * float(l) * DIAMETER, force=True)
    write(bed, state[:, :3], state[:, 3:9], state[:, 9:])
    return bed
