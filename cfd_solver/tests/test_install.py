"""An installed Hotbed, moved away from where it was put: runs an example as the built one does, and knows that it is installed."""

import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from scenes import CoupledTest, ROOT, SLIM_BED
from fault_scenes import SMALL


class Install(CoupledTest):
    example = SLIM_BED

    def setUp(self):
        super().setUp()
        first, self.prefix = self.folder / "first", self.folder / "moved"
        build = os.environ.get("HOTBED_BUILD", ROOT / "build")
        subprocess.run(["cmake", "--install", build, "--prefix", first], check=True, stdout=subprocess.DEVNULL)
        first.rename(self.prefix)

    def hotbed(self, *words):
        """The installed command in the test's folder, with an environment of its own."""
        path = {"PATH": "/usr/bin:/bin"}
        return subprocess.run([self.prefix / "bin/hotbed", *words], cwd=self.folder, env=path, capture_output=True, text=True)

    def test_runs_an_example_as_the_built_one(self):
        settings = {**SMALL, "endTime": "0.002", "writeInterval": "0.002"}
        done = self.hotbed("run", self.prefix / "share/hotbed/examples/slim_bed", "--set",
                           *(f"{name}={value}" for name, value in settings.items()))
        self.assertEqual(done.returncode, 0, done.stderr)
        installed, = (self.folder / "results/slim_bed").iterdir()
        self.assertTrue((installed / "temperature.png").is_file())
        built = self.scene("built", **settings)
        self.assertEqual(self.solve(built)[0], 0)
        self.assertEqual(*((folder / "0.002/T").read_text() for folder in (installed, built)))
        head = (installed / "log.hotbedFoam").read_text().split("Case\n")[0]
        self.assertIn(str(self.prefix), head)
        for name in ("Hotbed 0.", "OpenFOAM          1912.", "LIGGGHTS-PUBLIC 3.", "Open MPI v"):
            self.assertIn(name, head)
        done = self.hotbed("report", installed)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("Finished: 0.002 s", (installed / "report.html").read_text())
        self.assertEqual(list(self.prefix.rglob("__pycache__")), [])

    def test_verbs_of_the_source_tree(self):
        for verb in ("test", "validate", "bench"):
            done = self.hotbed(verb)
            self.assertEqual(done.returncode, 2)
            self.assertIn("needs the source tree", done.stderr)

    def test_version(self):
        done = self.hotbed("--version")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"^Hotbed \d+\.\d+\.\d+")


class Packages(unittest.TestCase):
    def test_missing_ones_are_named_where_nobody_may_install_them(self):
        with tempfile.TemporaryDirectory() as folder:
            programs = Path(folder)
            for name in ("bash", "awk", "sort", "comm", "dirname", "readlink"):
                (programs / name).symlink_to(shutil.which(name))
            for name, words in {"id": "echo 1000", "dpkg-query": "echo 'ii  cmake'"}.items():
                (programs / name).write_text(f"#!/bin/sh\n{words}\n")
                (programs / name).chmod(0o755)
            done = subprocess.run([ROOT / "hotbed", "--version"], env={"PATH": folder}, capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, "^hotbed: Debian packages are missing; as root: apt-get install .* liggghts .*openfoam")
        self.assertNotIn("cmake", done.stderr)


if __name__ == "__main__":
    unittest.main()
