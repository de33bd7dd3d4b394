"""fix hotbed/balance under the unmodified liggghts: a heap at one end of a long box, on a floor that is a mesh, its contacts pressed
together. On four ranks with moving cuts the particles do what they do on one rank."""

import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

LIBRARY = Path(os.environ["HOTBED_BUILD"]) / "liggghts_fixes" / "libhotbed_liggghts.so"
STEPS = 400
SCRIPT = f"""
units si
atom_style granular
boundary f f f
newton off
communicate single vel yes
processors {{grid}}
region box block 0 0.06 0 0.006 -0.001 0.02 units box
create_box 1 box
neighbor 3e-4 bin
neigh_modify delay 0
fix cg all hotbed/coarsegrain ratio 2
fix m1 all property/global kn peratomtypepair 1 500
fix m2 all property/global coefficientRestitution peratomtypepair 1 0.7
fix m3 all property/global tangentialRestitution peratomtypepair 1 0.1
fix m4 all property/global coefficientFriction peratomtypepair 1 0.3
pair_style gran model hotbed tangential hotbed
pair_coeff * *
fix floor all mesh/surface file floor.stl type 1
fix bottom all wall/gran model hotbed tangential hotbed mesh n_meshes 1 meshes floor
fix left all wall/gran model hotbed tangential hotbed primitive type 1 xplane 0
fix front all wall/gran model hotbed tangential hotbed primitive type 1 yplane 0
fix back all wall/gran model hotbed tangential hotbed primitive type 1 yplane 0.006
fix integrate all nve/sphere/hotbed gravity 9.81 vector 0.5 0 -1
lattice custom 1 a1 1e-3 0 0 a2 0 9.99e-4 0 a3 4e-4 0 9.99e-4 basis 0.5 0.5 0.5
region heap block 4.9e-4 0.009 0 0.006 0 0.01 units box
create_atoms 1 region heap
set group all diameter 1e-3 density 1040
{{balance}}
timestep 5e-6
thermo 100
dump end all custom {STEPS} end*.txt id x y z vx vy vz omegax omegay omegaz
dump_modify end sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
run {STEPS}
"""


def floor(pieces=12, length=0.06, width=0.006):
    """A floor of pairs of triangles."""
    facets = []
    for low, high in zip(np.linspace(0, length, pieces + 1), np.linspace(0, length, pieces + 1)[1:]):
        for corners in (((low, 0), (high, 0), (high, width)), ((low, 0), (high, width), (low, width))):
            facets.append("facet normal 0 0 1\nouter loop\n" + "".join(f"vertex {x} {y} 0\n" for x, y in corners)
                          + "endloop\nendfacet\n")
    return "solid floor\n" + "".join(facets) + "endsolid floor\n"


class Balance(unittest.TestCase):
    def run_on(self, ranks, grid, balance=""):
        """@return (x y z v omega at the end, in an order that does not depend on the ranks; largest share of a rank over the mean)"""
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "floor.stl").write_text(floor())
            (Path(folder) / "in").write_text(SCRIPT.format(grid=grid, balance=balance))
            done = subprocess.run(["mpirun", "-np", str(ranks), "liggghts", "-in", "in", "-log", "none"], cwd=folder, text=True,
                                  capture_output=True, timeout=120, env=dict(os.environ, LD_PRELOAD=f"{os.environ.get('LD_PRELOAD', '')}:{LIBRARY}"))
            self.assertEqual(done.returncode, 0, done.stdout[-2000:] + done.stderr[-2000:])
            start, end = (np.loadtxt(Path(folder) / f"end{step}.txt", skiprows=9) for step in (0, STEPS))
            self.assertEqual(len(start), len(end), "particles were lost")
            mean, most = re.findall(r"Nlocal:\s+(\S+) ave (\S+) max", done.stdout)[-1]
            return end[np.lexsort(np.round(start[:, 1:4] * 1e6).T), 1:], float(most) / float(mean)

    def test_moving_cuts(self):
        one, _ = self.run_on(1, "1 1 1")
        scale = np.abs(one).max(axis=0)
        self.assertGreater(scale[3], 0.01, "the heap slides")
        for grid, bound in (("4 1 1", 1.2), ("2 1 2", 1.2)):
            still, before = self.run_on(4, grid)
            moved, after = self.run_on(4, grid, "fix balance all hotbed/balance every 20")
            off = [np.max(np.abs(other - one) / scale) for other in (still, moved)]
            print(f"{grid}: largest share over the mean {before:.2f}, moved {after:.2f}; off by {off[0]:.1e}, {off[1]:.1e}")
            self.assertGreater(before, 1.8)
            self.assertLess(after, bound)
            self.assertLess(max(off), 1e-9)


if __name__ == "__main__":
    unittest.main(verbosity=2)
