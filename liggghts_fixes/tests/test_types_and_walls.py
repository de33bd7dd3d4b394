"""Contacts have the constants of their pair of types; a wall that is a mesh is as good as a primitive one."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

LIBRARY = Path(os.environ["HOTBED_BUILD"]) / "liggghts_fixes" / "libhotbed_liggghts.so"
D, SPEED = 1e-3, 0.1  # coarse particle, l = 2
TOLERANCE = 1e-3  # a contact ends within a step, up to eta dt / m = 0.6e-3 off here
E_N = {1: 0.9, 2: 0.6}  # of the ball's type with the wall, type 3

HEAD = """
units si
atom_style granular
boundary f f f
newton off
communicate single vel yes
region box block -0.01 0.01 -0.01 0.01 -0.01 0.01 units box
create_box 3 box
neighbor 1e-4 bin
neigh_modify delay 0
fix cg all hotbed/coarsegrain ratio 2
fix m1 all property/global kn peratomtypepair 3 500 600 400  600 700 800  400 800 500
fix m2 all property/global coefficientRestitution peratomtypepair 3 0.7 0.8 0.9  0.8 0.5 0.6  0.9 0.6 0.7
fix m3 all property/global tangentialRestitution peratomtypepair 3 0.1 0.1 0.1  0.1 0.1 0.3  0.1 0.3 0.1
fix m4 all property/global coefficientFriction peratomtypepair 3 0.1 0.1 0.3  0.1 0.1 0.2  0.3 0.2 0.1
pair_style gran model hotbed tangential hotbed
pair_coeff * *
fix integrate all nve/sphere
timestep 1e-8
"""
BALL = HEAD + """
variable x equal 0.51*{d}
# LIGGGHTS wants a particle of type 1
create_atoms 1 single 0.005 0.005 0.005 units box
create_atoms {type} single $x {y} {z} units box
set group all diameter {d} density 1040
group ball id 2
velocity ball set {vx} {vy} 0 units box
{wall}
"""
PAIR = HEAD + """
create_atoms {a} single -5.1e-4 0 0 units box
create_atoms {b} single 4.1e-4 0 0 units box
{spectator}
group one id 1
group two id 2
set group all diameter 0.8e-3 density 2500
set group one diameter 1e-3 density 1040
velocity one set 0.04 0 0 units box
velocity two set -0.06 0 0 units box
group ball union one two
"""
RUN = """
run 60000
dump ball ball custom 1 ball.txt vx vy vz omegax omegay omegaz mass
dump_modify ball sort id format "%.16g %.16g %.16g %.16g %.16g %.16g %.16g"
run 0
"""
MODEL = "wall/gran model hotbed tangential hotbed"
WALLS = {
    "primitive": f"fix wall all {MODEL} primitive type 3 xplane 0.",
    "mesh": f"fix plane all mesh/surface file plane.stl type 3\nfix wall all {MODEL} mesh n_meshes 1 meshes plane",
}
SIDE = 5e-3  # of the square in x = 0 that two triangles make, parted by the diagonal y = z


def stl(triangles, normal):
    """ASCII STL"""
    lines = ["solid wall"]
    for triangle in triangles:
        lines += [f"facet normal {normal}", "outer loop", *(f"vertex {a:g} {b:g} {c:g}" for a, b, c in triangle),
                  "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid wall", ""])


SQUARE = [[(0, -SIDE, -SIDE), (0, SIDE, -SIDE), (0, SIDE, SIDE)], [(0, -SIDE, -SIDE), (0, SIDE, SIDE), (0, -SIDE, SIDE)]]


def after(script):
    """@return velocity, angular velocity and mass of the dumped balls after the contact"""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "in.test").write_text(script + RUN)
        (Path(folder) / "plane.stl").write_text(stl(SQUARE, "1 0 0"))
        done = subprocess.run(["liggghts", "-in", "in.test", "-log", "none"], cwd=folder, capture_output=True, text=True,
                              errors="replace", timeout=120, env=dict(os.environ, LD_PRELOAD=f"{os.environ.get('LD_PRELOAD', '')}:{LIBRARY}"))
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr
        return np.loadtxt(Path(folder) / "ball.txt", skiprows=9)


def bounce(wall, kind, angle, y=0.0, z=0.0):
    """@return velocity and angular velocity after a bounce; `angle` from the wall's normal [degrees]"""
    angle = np.radians(angle)
    return after(BALL.format(d=D, type=kind, y=y, z=z, vx=-SPEED * np.cos(angle), vy=SPEED * np.sin(angle), wall=WALLS[wall]))[:6]


class Pairs(unittest.TestCase):
    def test_each_pair_of_types_has_its_restitution(self):
        # balls of different size and density meet at 0.1 m/s
        for a, b, expected in ((1, 1, 0.7), (1, 2, 0.8), (2, 1, 0.8), (2, 2, 0.5)):
            spectator = "create_atoms 1 single 0.005 0.005 0.005 units box" if a == b == 2 else ""
            one, two = after(PAIR.format(a=a, b=b, spectator=spectator))
            restitution = (two[0] - one[0]) / 0.1
            print(f"types {a} and {b}: restitution {restitution:.5f}, given {expected}")
            self.assertLess(abs(restitution / expected - 1), TOLERANCE)
            momentum = 0.04 * one[6] - 0.06 * two[6]
            self.assertLess(abs(one[0] * one[6] + two[0] * two[6] - momentum), 1e-12 * 0.1 * one[6])


class Walls(unittest.TestCase):
    def test_mesh_is_as_good_as_a_primitive_wall(self):
        for kind, angle, y, z in [(1, 0, 1e-3, -1e-3), (1, 40, 1e-3, -1e-3), (2, 70, 1e-3, -1e-3), (2, 40, 1e-3, 1e-3)]:
            with self.subTest(type=kind, angle=angle, on_the_edge=y == z):
                primitive, mesh = bounce("primitive", kind, angle, y, z), bounce("mesh", kind, angle, y, z)
                off = np.max(np.abs(mesh - primitive) / np.array([SPEED] * 3 + [2 * SPEED / D] * 3))
                print(f"type {kind}, {angle} degrees: mesh and primitive wall differ by {off:.1e}")
                self.assertLess(off, 1e-12)
                self.assertGreater(primitive[0], 0.0, "the ball must have bounced")

    def test_each_type_has_its_restitution(self):
        for wall in WALLS:
            for kind, expected in E_N.items():
                restitution = bounce(wall, kind, 0)[0] / SPEED
                print(f"{wall}, type {kind}: restitution {restitution:.5f}, given {expected}")
                self.assertLess(abs(restitution / expected - 1), TOLERANCE)


if __name__ == "__main__":
    unittest.main(verbosity=2)
