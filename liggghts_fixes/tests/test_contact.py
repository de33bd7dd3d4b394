"""The contact law in its two forms, vectorised and plain: a lively bed of particles of several sizes and types moves the
same, also across ranks and restarts, and what only the plain form computes is there."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

LIBRARY = Path(os.environ["HOTBED_BUILD"]) / "liggghts_fixes" / "libhotbed_liggghts.so"
SIDE, SPACING, COUNT = 0.012, 1e-3, 12**3
HEAD = """
units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
processors * 1 1
"""


def data():
    """A LIGGGHTS data file: a lattice of particles of 0.85 to 1 mm and two types, with random velocities and spins."""
    random = np.random.default_rng(2)
    place = (np.stack(np.unravel_index(np.arange(COUNT), (12, 12, 12)), axis=1) + 0.5) * SPACING
    diameter = random.uniform(0.85e-3, 1e-3, COUNT)
    motion = np.concatenate([random.normal(0, 0.5, (COUNT, 3)), random.normal(0, 100, (COUNT, 3))], axis=1)
    atoms = "".join(f"{i + 1} {1 + i % 2} {diameter[i]:.8g} {1040 + 500 * (i % 2)} {x} {y} {z}\n"
                    for i, (x, y, z) in enumerate(place))
    velocities = "".join(f"{i + 1} " + " ".join(f"{v:.8g}" for v in row) + "\n" for i, row in enumerate(motion))
    sides = "".join(f"0 {SIDE} {a}lo {a}hi\n" for a in "xyz")
    return f"bed\n\n{COUNT} atoms\n2 atom types\n{sides}\nAtoms\n\n{atoms}\nVelocities\n\n{velocities}"


INTEGRATION = "fix gravity all gravity 9.81 vector 0 0 -1\nfix integrate all nve/sphere\n"


def model(vectorised, friction, integration=INTEGRATION):
    """From the properties to the integration; constants that differ between all pairs of types."""
    def pairs(name, a, b, c):
        return f"fix {name} all property/global {name} peratomtypepair 2 {a} {b} {b} {c}\n"
    walls = "".join(f"fix {axis}{n} all wall/gran model hotbed tangential hotbed primitive type 1 {axis}plane {at} {vectorised}\n"
                    for axis in "xyz" for n, at in enumerate((0, SIDE)))
    return ("neighbor 1e-4 bin\nneigh_modify delay 0\n" + pairs("kn", 500, 400, 700) +
            pairs("coefficientRestitution", 0.74, 0.8, 0.9) + pairs("tangentialRestitution", 0.1, 0.3, 0.5) +
            pairs("coefficientFriction", friction, 2 * friction, 0.5 * friction) +
            f"pair_style gran model hotbed tangential hotbed {vectorised}\npair_coeff * *\n{walls}"
            f"{integration}timestep 2.5e-6\nthermo 1000\nthermo_modify lost error\n")


def dump():
    return ("dump end all custom 500 end.* id x y z vx vy vz omegax omegay omegaz\n"
            f'dump_modify end sort id format "%d {" ".join(["%.16g"] * 9)}"\n')


def liggghts(folder, script, ranks=1):
    """Runs a script in a folder. @return screen output"""
    (folder / "data.bed").write_text(data())
    (folder / "in.test").write_text(script)
    command = ["liggghts", "-in", "in.test", "-log", "none"]
    if ranks > 1:
        command = ["mpirun", "-np", str(ranks), *command]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=120,
                          env=dict(os.environ, LD_PRELOAD=f"{os.environ.get('LD_PRELOAD', '')}:{LIBRARY}"))
    if done.returncode:
        raise RuntimeError(done.stdout[-2000:] + done.stderr)
    return done.stdout


def bed(vectorised, ranks=1, friction=0.1, runs="run 500\n", extra="", integration=INTEGRATION):
    """@return particles after 500 steps, and the screen output"""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        output = liggghts(folder, HEAD + "read_data data.bed\n" + model(vectorised, friction, integration) + extra + dump() + runs, ranks)
        return particles(folder), output


def particles(folder):
    """@return [n, (x y z) (vx vy vz) (wx wy wz)] at the end"""
    return np.loadtxt(folder / "end.500", skiprows=9)[:, 1:].reshape(-1, 3, 3)


def difference(a, b):
    """Largest difference of places, velocities and spins, over the largest value of each"""
    return np.max(np.abs(a - b) / np.max(np.abs(b), axis=(0, 2))[:, None])


class Contact(unittest.TestCase):
    def test_vectorised_is_plain_on_one_and_two_ranks(self):
        for friction in (0.1, 0.0):
            plain, _ = bed("vectorised off", friction=friction)
            for ranks in (1, 2):
                with self.subTest(friction=friction, ranks=ranks):
                    self.assertLess(difference(bed("", ranks, friction)[0], plain), 1e-10)

    def test_periodic_box_is_plain_on_any_ranks(self):
        # borders go to a rank itself, to the same rank on both sides, to others on each side
        def periodic(vectorised, ranks=1, integration=INTEGRATION):
            with tempfile.TemporaryDirectory() as folder:
                folder = Path(folder)
                walls = [line for line in model(vectorised, 0.1, integration).splitlines(True) if "xplane" not in line and "yplane" not in line]
                head = HEAD.replace("f f f", "p p f").replace("* 1 1", "* 1 1" if ranks == 3 else "* * 1")
                liggghts(folder, head + "read_data data.bed\n" + "".join(walls) + dump() + "run 500\n", ranks)
                return particles(folder)
        plain = periodic("vectorised off")
        for ranks in (1, 2, 3, 4):
            with self.subTest(ranks=ranks):
                self.assertLess(difference(periodic("", ranks), plain), 1e-10)
                self.assertLess(difference(periodic("", ranks, "fix integrate all nve/sphere/hotbed gravity 9.81 vector 0 0 -1\n"),
                                           plain), 1e-10)

    def test_restart_goes_on_with_the_other_form(self):
        # the first forces of a run take the velocities at the end of a step, all others those in its middle
        straight, _ = bed("vectorised off", runs="run 250\nrun 250\n")
        for first, second in (("", "vectorised off"), ("vectorised off", "")):
            with self.subTest(first or second), tempfile.TemporaryDirectory() as folder:
                folder = Path(folder)
                liggghts(folder, HEAD + "read_data data.bed\n" + model(first, 0.1) + "run 250\nwrite_restart half\n", 2)
                liggghts(folder, HEAD + "read_restart half\n" + model(second, 0.1) + dump() + "run 250\n", 2)
                self.assertLess(difference(particles(folder), straight), 1e-10)

    def test_what_only_the_plain_form_computes(self):
        extra = ("compute pairs all pair/gran/local id force history\ncompute contacts all reduce sum c_pairs[4] c_pairs[7]\n"
                 "compute kinetic all temp\ncompute virial all pressure kinetic virial\n"
                 "thermo_style custom step atoms ke c_virial\nthermo 100\n"
                 "dump pairs all local 100 pairs.* c_pairs[4] c_pairs[7]\n")
        plain, table = bed("vectorised off", extra=extra)
        ours, ourTable = bed("", extra=extra)
        self.assertLess(difference(ours, plain), 1e-10)
        rows = [[line for line in t.splitlines() if line.strip()[:1].isdigit()] for t in (table, ourTable)]
        self.assertGreater(len(rows[0]), 5)
        self.assertEqual(*rows)

    def test_short_contacts_are_refused(self):
        # the shortest one lasts 4.8e-5 s, at restitution 0.9
        with self.assertRaisesRegex(RuntimeError, r"ERROR: .* set timestep to at most 1\.\d+e-05 \(it is 1\.5e-05\), or kn to"):
            bed("", extra="timestep 1.5e-5\n")
        _, warned = bed("", extra="timestep 8e-6\n")
        self.assertRegex(warned, "WARNING: .* set timestep to at most")
        self.assertNotIn("time steps, few", bed("")[1])

    def test_keyword(self):
        with self.assertRaisesRegex(RuntimeError, "vectorised must be on or off, not 'perhaps'"):
            bed("vectorised perhaps")


if __name__ == "__main__":
    unittest.main(verbosity=2)
