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

CASE, SLIM = (ROOT / "examples" / name for name in ("fluidized_bed", "slim_bed"))
LIBRARY = Path(os.environ["HOTBED_BUILD"]) / "liggghts_fixes" / "libhotbed_liggghts.so"


def in_liggghts(case, folder, settings, then):
    """Runs the script of a case in the unmodified LIGGGHTS with settings, and lines after it. @return folder of its dumps"""
    (Path(folder) / "DEM").mkdir()
    (Path(folder) / "in.bed").write_text(f"{(case / 'DEM/in.bed').read_text()}\n{then}\n")
    command = ["liggghts", "-in", "in.bed", "-log", "none"]
    for name, value in settings.items():
        command += ["-var", name, value]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace",
                          env=dict(os.environ, LD_PRELOAD=str(LIBRARY)))
    if done.returncode:
        raise AssertionError(done.stdout[-2000:])
    return Path(folder) / "DEM/post"


class FluidizedBed(unittest.TestCase):
    def test_particles_of_the_paper(self):
        for l, particles in ((1, 720000), (1.5, 213333), (2, 90000), (2.5, 46080)):
            settings = {**read_settings(CASE / "settings"), "l": str(l)}
            with self.subTest(l=l), tempfile.TemporaryDirectory() as folder:
                start = read_dump(in_liggghts(CASE, folder, settings, "run 0") / "particles0.txt")
                self.assertEqual(len(start["id"]), particles)
                places = np.array([start[c] for c in "xyz"]).T
                self.assertGreater(cKDTree(places).query(places, 2)[0][:, 1].min(), 1.01 * 5e-4 * l)
                size = [float(settings[n]) for n in ("width", "depth", "height")]
                self.assertGreater(np.min([places, size - places]), 0.5 * 5e-4 * l)

    def test_walls_stand_back(self):
        """How far particles come that fly into a corner: to where the walls are, and by their overlap further."""
        deepest = 1.05 * 0.5 * np.sqrt(np.pi / 6 * 5e-4**3 * 1040 / 500)  # of springs without dashpots, for any l; they also fall
        for setback, l in ((0.05, 2.5), (0.2, 2.5), (0, 2.5), (0.2, 1)):
            settings = {**read_settings(SLIM / "settings"), "l": f"{l}", "wallSetback": f"{setback}", "writeInterval": "1e-5",
                        "solids": "1e-7"}
            for sign in (-1, 1):
                with self.subTest(setback=setback, l=l, sign=sign), tempfile.TemporaryDirectory() as folder:
                    speed = f"{sign * 0.5}"
                    dumps = in_liggghts(SLIM, folder, settings, f"velocity all set {speed} {speed} -0.5 units box\nrun 400")
                    places = np.hstack([[rows[c] for c in "xyz"] for rows in map(read_dump, dumps.glob("particles*.txt"))])
                    radius, back = 0.5 * 5e-4 * l, setback * (l - 1) * 5e-4
                    size = np.array([float(settings[n]) for n in ("width", "depth")])
                    nearest = places.min(axis=1) if sign < 0 else [*(size - places[:2].max(axis=1)), places[2].min()]
                    for gap in np.array(nearest) - radius + back:
                        self.assertLess(gap, 0)
                        self.assertGreater(gap, -deepest)

    def test_the_table_of_the_paper(self):
        settings = read_settings(CASE / "settings")
        paper = {"width": 0.04, "depth": 0.025, "height": 0.2, "cellsWidth": 32, "cellsDepth": 20, "cellsHeight": 160,
                 "deltaT": 2.5e-5, "deltaTDEM": 2.5e-6, "endTime": 25}
        self.assertEqual({name: float(settings[name]) for name in paper}, paper)

    def test_differs_from_the_slim_bed_in_settings_only(self):
        files = [str(p.relative_to(CASE)) for p in CASE.rglob("*") if p.is_file()
                 and p.name not in ("settings", "README.md") and p.suffix != ".pyc"]
        self.assertEqual(filecmp.cmpfiles(CASE, SLIM, files, shallow=False)[1:], ([], []))
        self.assertEqual(set(read_settings(CASE / "settings")), set(read_settings(SLIM / "settings")))


if __name__ == "__main__":
    unittest.main(verbosity=2)
