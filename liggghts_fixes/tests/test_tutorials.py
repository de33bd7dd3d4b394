"""LIGGGHTS' own tutorials under the unmodified `liggghts`: the same with and without our library, to the last digit."""

import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

LIBRARY = Path(os.environ["HOTBED_BUILD"]) / "liggghts_fixes" / "libhotbed_liggghts.so"
TUTORIALS = Path("/usr/share/doc/liggghts/examples/LIGGGHTS/Tutorials_public")

# steps each `run` of a tutorial is cut to: enough for the particles to meet each other or the walls
STEPS = {
    "chute_wear/in.chute_wear": 12000,
    "cohesion/in.cohesion": 4000,
    "contactModels/in.newModels": 6000,
    "conveyor/in.conveyor": 25000,
    "heatTransfer_1/in.heatGran": 5000,
    "hysteresis/in.hysteresis": 8000,
    "insert_stream/in.insert_stream": 12000,
    "meshGran/in.meshGran": 8000,
    "mesh_tet/in.mesh_tet": 1000,
    "movingMeshGran/in.movingMeshGran": 3000,
    "multisphere_stone_restitution/in.multisphere": 12000,
    "packing/in.packing": 8000,
    "sph_2/in.sph_2": 2000,
}
# what Debian's program has no style for fails in the same way
WITHOUT = {"contactModels/in.oldModels": "Invalid pair style", "superquadric/in.particle_particle": "Invalid atom style"}


def tutorial(name, steps=None, preload=None):
    """@return (exit status, screen output) of a tutorial whose runs are cut to `steps`, thermo printed in full"""
    folder, script = name.split("/")
    with tempfile.TemporaryDirectory() as place:
        case = Path(place) / folder
        shutil.copytree(TUTORIALS / folder, case)
        (case / "post").mkdir(exist_ok=True)
        text = (case / script).read_text()
        if steps:
            text, runs = re.subn(r"(?m)^(\s*run\s+)(?!1\s*$)\S.*$", rf"\g<1>{steps}", text)
            text, formats = re.subn(r"(?m)^(\s*thermo_modify\s.*)$", r"\1 format float %.17g", text)
            assert runs and formats, f"{name} has no run or no thermo_modify"
        (case / script).write_text(text)
        environment = dict(os.environ, **({"LD_PRELOAD": f"{os.environ.get('LD_PRELOAD', '')}:{preload}"} if preload else {}))
        done = subprocess.run(["liggghts", "-in", script, "-log", "none"], cwd=case, env=environment, timeout=120,
                              capture_output=True, text=True, errors="replace")
        return done.returncode, done.stdout + done.stderr


def thermo(output):
    """Rows of numbers under each thermo header, without the column of the CPU time."""
    rows, columns = [], None
    for line in output.splitlines():
        words = line.split()
        if words[:1] == ["Step"]:
            columns = [c for c, word in enumerate(words) if word != "CPU"]
        elif line.startswith("Loop time"):
            columns = None
        elif columns and words and words[0].isdigit() and len(words) > columns[-1]:
            rows.append([words[c] for c in columns])
    return rows


class Tutorials(unittest.TestCase):
    def test_same_thermo_with_and_without_the_library(self):
        self.assertTrue(TUTORIALS.is_dir(), f"{TUTORIALS} is missing: it is part of the Debian package liggghts-doc")
        for name, steps in STEPS.items():
            with self.subTest(name):
                code, plain = tutorial(name, steps)
                self.assertEqual(code, 0, plain[-2000:])
                code, preloaded = tutorial(name, steps, LIBRARY)
                self.assertEqual(code, 0, preloaded[-2000:])
                self.assertGreater(len(thermo(plain)), 1)
                self.assertGreater(int(thermo(plain)[-1][1]), 0, "a tutorial without particles shows nothing")
                self.assertEqual(thermo(plain), thermo(preloaded))
                print(f"{name}: {len(thermo(plain))} thermo lines, {thermo(plain)[-1][1]} particles at the end")

    def test_same_error_where_a_package_is_not_compiled_in(self):
        for name, error in WITHOUT.items():
            for preload in (None, LIBRARY):
                with self.subTest(name, preload=preload):
                    code, output = tutorial(name, preload=preload)
                    self.assertNotEqual(code, 0)
                    self.assertIn(error, output)


if __name__ == "__main__":
    unittest.main(verbosity=2)
