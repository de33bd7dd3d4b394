"""fix nve/sphere/hotbed against LIGGGHTS' nve/sphere and gravity: the same motion, also of what is written in between, with
the force of the gas, of a group; what it cannot do is refused."""

import re
import tempfile
import unittest
from pathlib import Path

import numpy as np

from test_contact import HEAD, INTEGRATION, bed, difference, liggghts, model

OURS = "fix integrate all nve/sphere/hotbed gravity 9.81 vector 0 0 -1\n"
GAS = ("fix drag all hotbed/drag\nrun 0\nset group all property/atom gasForce 1e-6 -2e-6 4e-6\n")


def frames(integration, ranks=1, gas=GAS):
    """@return what is dumped every 50 steps: places, velocities, spins, forces, [frames, n, 4, 3]"""
    columns = "x y z vx vy vz omegax omegay omegaz fx fy fz"
    written = (f"dump frames all custom 50 frame.* id {columns}\n"
               f'dump_modify frames sort id format "%d {" ".join(["%.16g"] * 12)}"\n')
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        liggghts(folder, HEAD + "read_data data.bed\n" + model("", 0.1, integration) + gas + written + "run 300\n", ranks)
        return np.array([np.loadtxt(folder / f"frame.{step}", skiprows=9)[:, 1:].reshape(-1, 4, 3)
                         for step in range(0, 301, 50)])


class Integration(unittest.TestCase):
    def test_moves_as_nve_sphere_and_gravity_with_gas(self):
        stock = frames(INTEGRATION)
        self.assertGreater(difference(frames(INTEGRATION, gas="")[-1], stock[-1]), 1e-3)
        for ranks in (1, 2):
            for at, (ours, theirs) in enumerate(zip(frames(OURS, ranks), stock)):
                with self.subTest(ranks=ranks, step=50 * at):
                    self.assertLess(difference(ours, theirs), 1e-10)

    def test_who_looks_on_changes_nothing(self):
        alone, _ = bed("", integration=OURS)
        looks = {
            "output": dict(extra="thermo 7\ndump often all custom 3 often.* vx\n"),
            "a fix at the end of a step": dict(extra="variable ke equal ke\nfix look all print 5 '${ke}' file look.txt\n"),
            "runs that go on": dict(runs="run 123\nrun 377 pre no\n"),
            "run every": dict(runs="run 500 pre no every 10 'print here'\n"),
        }
        for name, options in looks.items():
            with self.subTest(name):
                np.testing.assert_array_equal(bed("", integration=OURS, **options)[0], alone)

    def test_neighbour_lists_are_built_when_stock_builds_them(self):
        def builds(integration, ranks=1, settings="", runs="run 250\nrun 250\n"):
            _, screen = bed("", ranks, integration=integration, extra=settings, runs=runs)
            return re.findall(r"(?:Neighbor list|Dangerous) builds = (\d+)", screen)

        often = builds(INTEGRATION)
        self.assertGreater(int(often[0]), 5)
        for ranks in (1, 2):
            self.assertEqual(builds(OURS, ranks), often)
        for settings in ("neigh_modify every 7\n", "neigh_modify delay 40\n", "neigh_modify check no every 3\n",
                         "group one id 1\nfix held one move linear 0 0 0\n"):
            with self.subTest(settings):
                self.assertEqual(builds(OURS, settings=settings), builds(INTEGRATION, settings=settings))

    def test_without_gravity_and_of_a_group(self):
        group = "group moving type 1\n"
        for ours, stock in (("fix integrate all nve/sphere/hotbed\n", "fix integrate all nve/sphere\n"),
                            (group + OURS.replace("all", "moving", 1),
                             group + INTEGRATION.replace("all nve", "moving nve"))):
            with self.subTest(ours):
                self.assertLess(difference(bed("", integration=ours)[0], bed("", integration=stock)[0]), 1e-10)

    def test_what_comes_after_the_forces_of_pairs_counts(self):
        wall = "fix x1 all wall/gran model hotbed tangential hotbed primitive type 1 xplane 0.012"
        for name, after in {"of all": "fix slow all viscous 1e-5\n",
                            "of a type": "group one type 1\nfix push one addforce 1e-5 0 0\n",
                            "a wall that moves": f"unfix x1\n{wall} shear y 0.1\n"}.items():
            for ranks in (1, 2):
                with self.subTest(name, ranks=ranks):
                    ours, stock = (bed("", ranks, integration=i, extra=after)[0] for i in (OURS, INTEGRATION))
                    self.assertLess(difference(ours, stock), 1e-10)
                    self.assertGreater(difference(stock, bed("", integration=INTEGRATION)[0]), 1e-4)

    def test_refused(self):
        for lines, message in (
            (OURS + "fix more all gravity 9.81 vector 0 0 -1\n", "has gravity, and so has fix gravity"),
            (OURS + "group one id 1\nfix hold one freeze\n", "adds gravity after fix freeze has seen the forces"),
            (OURS.replace("vector 0 0 -1", "vector 0 0 0"), "the vector of gravity has no length"),
            (OURS.replace("vector", "chute"), "expecting 'gravity g vector x y z' or nothing"),
        ):
            with self.subTest(message), self.assertRaisesRegex(RuntimeError, message):
                bed("", integration=lines)


if __name__ == "__main__":
    unittest.main(verbosity=2)
