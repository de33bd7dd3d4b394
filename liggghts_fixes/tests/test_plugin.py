"""The styles under the unmodified `liggghts`, preloaded: derived constants, `clear`, errors that name the mend."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

LIBRARY = Path(os.environ["HOTBED_BUILD"]) / "liggghts_fixes" / "libhotbed_liggghts.so"

BOX = """
units si
atom_style granular
atom_modify sort 0 0
boundary f f f
newton off
communicate single vel yes
region box block 0 1 0 1 0 1 units box
create_box 1 box
neighbor 1e-3 bin
"""
PARTICLE = """
create_atoms 1 single 0.5 0.5 0.5 units box
set group all diameter 1e-3 density 800
timestep 1e-3
"""
CAPACITY = "fix capacity all property/global thermalCapacity peratomtype 1500\n"
HEAT = "fix heat all hotbed/heat initial_temperature 363.15\n"
TABLE2 = "diameter 5e-4 density 1040 stiffness 500 restitution 0.74 0.1"
SHOW = "".join(f'variable v{n} equal f_cg[{n}]\nprint "value {n} ${{v{n}}}"\n' for n in range(1, 8))


def liggghts(script, ranks=1):
    """Runs a script. @return (exit status, screen output)"""
    command = ["liggghts", "-in", "in.test", "-log", "none"]
    if ranks > 1:
        command = ["mpirun", "-np", str(ranks), *command]
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "in.test").write_text(script)
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=120,
                              env=dict(os.environ, LD_PRELOAD=f"{os.environ.get('LD_PRELOAD', '')}:{LIBRARY}"))
        return done.returncode, done.stdout + done.stderr


def values(output):
    return {int(line.split()[1]): float(line.split()[2]) for line in output.splitlines() if line.startswith("value ")}


class Coarsegrain(unittest.TestCase):
    def test_table_2_of_the_paper_at_every_ratio(self):
        for l in (1, 1.5, 2, 2.5):
            code, output = liggghts(BOX + f"fix cg all hotbed/coarsegrain ratio {l} {TABLE2}\n" + SHOW)
            self.assertEqual(code, 0, output)
            v = values(output)
            self.assertEqual(v[1], l)
            np.testing.assert_allclose([v[2], v[3], v[4]], [l**3, l * 5e-4, l**3 * 500], rtol=1e-5)
            # printed with three to five digits in the paper
            np.testing.assert_allclose(np.array([v[5], v[6], v[7]]) / l**3, [217.60, 7.87e-4, 1.72e-3], rtol=2e-3)

    def test_survives_clear(self):
        half = BOX + f"fix cg all hotbed/coarsegrain ratio 2 {TABLE2}\n" + CAPACITY + HEAT + PARTICLE
        code, output = liggghts(half + "run 0\nclear\n" + half + "run 0\n" + SHOW)
        self.assertEqual(code, 0, output)
        self.assertEqual(values(output)[2], 8)

    def test_errors_name_the_mend(self):
        for arguments, expected in {
            "ratio 0": "ratio must be a number > 0, <= 1000 [-], not '0'",
            "ratio -2": "ratio must be a number > 0, <= 1000 [-], not '-2'",
            "ratio two": "ratio must be a number > 0, <= 1000 [-], not 'two'",
            "ratio nan": "ratio must be a number > 0, <= 1000 [-], not 'nan'",
            "ratio 2x": "ratio must be a number > 0, <= 1000 [-], not '2x'",
            "ratio": "keyword ratio wants a value",
            "ratio 2 ratio 2": "keyword ratio is given twice",
            "ratio 2 diametr 1e-3": "unknown keyword diametr; known are ratio, diameter",
            "diameter 1e-3": "keyword ratio is missing: add 'ratio L'",
            "ratio 2 restitution 0.9": "keyword restitution wants two values",
            "ratio 2 restitution 1.2 0.5": "restitution must be a number > 0, <= 1 [-], not '1.2'",
            "ratio 2 diameter -1": "diameter must be a number > 0",
        }.items():
            with self.subTest(arguments):
                code, output = liggghts(BOX + f"fix cg all hotbed/coarsegrain {arguments}\n")
                self.assertNotEqual(code, 0)
                self.assertIn(expected, output)

    def test_ratio_given_by_two_fixes(self):
        code, output = liggghts(BOX + "fix a all hotbed/coarsegrain ratio 2\nfix b all hotbed/coarsegrain ratio 2\n")
        self.assertNotEqual(code, 0)
        self.assertIn("given already, by fix a", output)

    def test_value_that_was_not_given(self):
        code, output = liggghts(BOX + "fix cg all hotbed/coarsegrain ratio 2\n" + SHOW)
        self.assertNotEqual(code, 0)
        self.assertIn("needs the keyword diameter", output)


class Heat(unittest.TestCase):
    def test_energy_on_one_and_two_ranks(self):
        show = 'variable e equal f_heat\nprint "value 0 ${e}"\n'
        for ranks in (1, 2):
            code, output = liggghts(BOX + CAPACITY + HEAT + PARTICLE + "run 0\n" + show, ranks)
            self.assertEqual(code, 0, output)
            np.testing.assert_allclose(values(output)[0], 800 * np.pi / 6 * 1e-9 * 1500 * 363.15, rtol=1e-5)

    def test_errors_name_the_mend(self):
        for script, expected in {
            BOX + HEAT + PARTICLE + "run 0\n": "heat capacity is missing: add 'fix ID all property/global thermalCapacity",
            BOX + CAPACITY + HEAT.replace("363.15", "-1"): "initial_temperature must be a number > 0, <= 100000 [K], not '-1'",
            BOX + CAPACITY + HEAT.replace("363.15", "hot"): "initial_temperature must be a number > 0, <= 100000 [K], not 'hot'",
            BOX + CAPACITY + HEAT.replace("initial_temperature", "T0"): "expecting 'initial_temperature T0'",
            BOX + CAPACITY + HEAT + HEAT.replace("fix heat", "fix more"): "held already by another fix",
            BOX + CAPACITY.replace("1500", "-5") + HEAT + PARTICLE + "run 0\n": "thermalCapacity must be > 0",
            BOX.replace("granular", "atomic") + HEAT: "use 'atom_style granular'",
        }.items():
            with self.subTest(expected):
                code, output = liggghts(script)
                self.assertNotEqual(code, 0)
                self.assertIn(expected, output)


if __name__ == "__main__":
    unittest.main(verbosity=2)
