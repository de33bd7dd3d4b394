"""Restarts that cannot be taken: unfinished ones, scripts that ignore them. That a restart goes on as if nothing had happened is
validation/validate_restart.py."""

import shutil
import unittest

from scenes import CoupledTest, SLIM_BED, run

SMALL = {"l": "2.5", "height": "0.05", "cellsHeight": "40", "maxDeltaT": "2.5e-5", "endTime": "0.002", "writeInterval": "0.001"}


class RestartTest(CoupledTest):
    example = SLIM_BED

    def start(self, name):
        return self.scene(name, **SMALL)

    def test_unfinished_write(self):
        target = self.start("unfinished")
        self.assertEqual(self.solve(target)[0], 0)
        # what a killed write leaves: a time folder without its restart
        shutil.copytree(target / "0", target / "0.0025")
        (target / "0.0025" / "T").write_text("half a fi")
        run.change_settings(target / "settings", {"endTime": "0.003"})
        code, log = self.solve(target)
        self.assertEqual(code, 0, log[-2000:])
        self.assertIn('0.0025" was left unfinished', log)
        self.assertTrue((target / "restart/0.003/state").exists())

    def test_purge(self):
        target = self.scene("purge", **{**SMALL, "writeInterval": "0.0005"})
        with open(target / "system/controlDict", "a") as control:
            control.write("purgeWrite 2;\n")
        self.assertEqual(self.solve(target)[0], 0)
        self.assertEqual(sorted(folder.name for folder in (target / "restart").iterdir()), ["0.0015", "0.002"])

    def test_script_that_ignores_the_restart(self):
        target = self.start("ignores")
        self.assertEqual(self.solve(target)[0], 0)
        script = target / "DEM/in.bed"
        script.write_text(script.read_text().replace('"${resume} == 1"', '"${resume} == 7"'))
        run.change_settings(target / "settings", {"endTime": "0.003"})
        code, log = self.solve(target)
        self.assertNotEqual(code, 0)
        self.assertIn("did not go on from the restart", log)


if __name__ == "__main__":
    unittest.main(verbosity=2)
