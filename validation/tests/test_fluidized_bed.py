"""The example of Table 2: as many particles as the paper for each ratio, none in another's place, and the slim bed's files."""

import filecmp
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "cfd_solver"))
from paraview import read_dump
from run import read_settings

CASE = ROOT / "examples" / "fluidized_bed"
LIBRARY = Path(os.environ["HOTBED_BUILD"]) / "liggghts_fixes" / "libhotbed_liggghts.so"


class FluidizedBed(unittest.TestCase):
    def test_particles_of_the_paper(self):
        """The case's script in the unmodified LIGGGHTS, no step."""
        for l, particles in ((1, 720000), (1.5, 213333), (2, 90000), (2.5, 46080)):
            settings = {**read_settings(CASE / "settings"), "l": str(l)}
            with self.subTest(l=l), tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "DEM").mkdir()
                (Path(folder) / "in.bed").write_text((CASE / "DEM/in.bed").read_text() + "\nrun 0\n")
                command = ["liggghts", "-in", "in.bed", "-log", "none"]
                for name, value in settings.items():
                    command += ["-var", name, value]
                done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace",
                                      env=dict(os.environ, LD_PRELOAD=str(LIBRARY)))
                self.assertEqual(done.returncode, 0, done.stdout[-2000:])
                start = read_dump(Path(folder) / "DEM/post/particles0.txt")
                self.assertEqual(len(start["id"]), particles)
                places = np.array([start[c] for c in "xyz"]).T
                self.assertGreater(cKDTree(places).query(places, 2)[0][:, 1].min(), 1.01 * 5e-4 * l)
                size = [float(settings[n]) for n in ("width", "depth", "height")]
                self.assertGreater(np.min([places, size - places]), 0.5 * 5e-4 * l)

    def test_the_table_of_the_paper(self):
        settings = read_settings(CASE / "settings")
        paper = {"width": 0.04, "depth": 0.025, "height": 0.2, "cellsWidth": 32, "cellsDepth": 20, "cellsHeight": 160,
                 "deltaT": 2.5e-5, "deltaTDEM": 2.5e-6, "endTime": 25}
        self.assertEqual({name: float(settings[name]) for name in paper}, paper)

    def test_differs_from_the_slim_bed_in_settings_only(self):
        other = CASE.parent / "slim_bed"
        files = [str(p.relative_to(CASE)) for p in CASE.rglob("*") if p.is_file()
                 and p.name not in ("settings", "README.md") and p.suffix != ".pyc"]
        self.assertEqual(filecmp.cmpfiles(CASE, other, files, shallow=False)[1:], ([], []))
        self.assertEqual(set(read_settings(CASE / "settings")), set(read_settings(other / "settings")))


if __name__ == "__main__":
    unittest.main(verbosity=2)
