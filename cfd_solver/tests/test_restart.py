"""A run that stops and goes on gives what one without a stop gives: same ranks, other ranks, after a kill."""

import shutil
import signal
import time
import unittest

import numpy as np

from scenes import CoupledTest, run  # first: it finds the modules below
import results
from test_moving_bed import DUMP, SLIM_BED, TIGHT

SMALL = {"l": "2.5", "height": "0.05", "cellsHeight": "40", "endTime": "0.002", "writeInterval": "0.001"}


def particles(target, step):
    """x y z vx vy vz T by particle id"""
    rows = np.loadtxt(target / f"DEM/post/particles{step}.txt", skiprows=9)
    return rows[np.argsort(rows[:, 0]), 1:]


def difference(a, b):
    """Largest difference of positions [mm], velocities (of the largest) and temperatures (of themselves)."""
    scale = np.array([1e-3] * 3 + [np.abs(a[:, 3:6]).max()] * 3 + [363.15])
    return np.max(np.abs(a - b) / scale)


class RestartTest(CoupledTest):
    example = SLIM_BED

    def start(self, name, ranks=1):
        # steps enough that the bed is in contact and moving; the restart is in the middle
        return self.scene(name, ranks, TIGHT + DUMP, **SMALL)

    def go_on_from_the_middle(self, whole, name, ranks):
        target = self.folder / name
        shutil.copytree(whole, target)
        shutil.rmtree(target / "0.002")
        shutil.rmtree(target / "restart/0.002")
        (target / "DEM/post/particles800.txt").unlink()
        if ranks > 1:
            run.tool(target, "decomposePar", "-latestTime")
        code, log = self.solve(target, ranks)
        self.assertEqual(code, 0, log[-2000:])
        self.assertIn("Time = 0.001025", log)
        self.assertNotIn("Time = 0.001 ", log)
        return target

    def test_same_and_other_ranks(self):
        whole = self.start("whole")
        code, log = self.solve(whole)
        self.assertEqual(code, 0, log[-2000:])
        expected = particles(whole, 800)
        same = self.go_on_from_the_middle(whole, "same", 1)
        other = self.go_on_from_the_middle(whole, "other", 2)
        off = difference(expected, particles(same, 800)), difference(expected, particles(other, 800))
        print(f"400 DEM steps after the restart: one rank off by {off[0]:.1e}, two ranks instead of one by {off[1]:.1e}")
        # the stopped gas takes up to its last digit, from where the pressure solver's tolerance and the bed spread it
        self.assertLess(max(off), 1e-8)
        self.assertLess(abs(results.bed(same)["budget_error"][-1]), 1e-8)

    def test_killed_runs_go_on(self):
        target = self.start("killed")
        for _ in range(3):
            process = run.start(target)
            time.sleep(1.3)
            process.send_signal(signal.SIGKILL)
            process.wait()
        # what a killed write leaves: a time folder without its restart
        shutil.copytree(target / "0", target / "0.0015")
        (target / "0.0015" / "T").write_text("half a fi")
        code, log = self.solve(target)
        self.assertEqual(code, 0, log[-2000:])
        self.assertTrue((target / "restart/0.002/state").exists())

    def test_script_that_ignores_the_restart(self):
        target = self.start("ignores")
        self.assertEqual(self.solve(target)[0], 0)
        script = target / "DEM/in.bed"
        script.write_text(script.read_text().replace('"${resume} == 1"', '"${resume} == 7"'))
        control = target / "system/controlDict"
        control.write_text(control.read_text().replace("$endTime", "0.003"))
        code, log = self.solve(target)
        self.assertNotEqual(code, 0)
        self.assertIn("did not go on from the restart", log)


if __name__ == "__main__":
    unittest.main(verbosity=2)
