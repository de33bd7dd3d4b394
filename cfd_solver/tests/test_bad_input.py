"""Bad input ends with an error that names file, key and mend, before anything is computed, and nothing is overwritten."""

import shutil
import subprocess
import sys
import unittest
import unittest.mock

from scenes import CoupledTest, FIXED_BED, SMALL, edit, run

PROPERTIES, SCRIPT = "constant/couplingProperties", "DEM/in.fixed_bed"
NAME = "couplingProperties"

# what is wrong: (file, pattern, replacement, all of this must stand in the error)
CASES = {
    "missing demScript": (PROPERTIES, r"^demScript.*", "", ["demScript", NAME]),
    "missing kernel": (PROPERTIES, r"^kernel\s.*", "", ["kernel", NAME]),
    "missing drag": (PROPERTIES, r"^drag.*", "", ["drag", NAME]),
    "missing heatTransfer": (PROPERTIES, r"^heatTransfer.*", "", ["heatTransfer", NAME]),
    "misspelt key": (PROPERTIES, r"^kernelWidth", "kernelWitdh", ["unknown key 'kernelWitdh'", "kernelWidth", NAME]),
    "unknown drag law": (PROPERTIES, r"Beetstra;", "Bestra;", ["drag must be one of", "Beetstra", NAME]),
    "unknown heat law": (PROPERTIES, r"Gunn;", "Gun;", ["heatTransfer must be one of", "Gunn", NAME]),
    "unknown kernel": (PROPERTIES, r"Deen;", "Dean;", ["kernel must be one of", "Deen", NAME]),
    "negative width": (PROPERTIES, r"kernelWidth.*", "kernelWidth -3;", ["kernelWidth must be a number > 0", NAME]),
    "zero width": (PROPERTIES, r"kernelWidth.*", "kernelWidth 0;", ["kernelWidth must be a number > 0", NAME]),
    "width is a word": (PROPERTIES, r"kernelWidth.*", "kernelWidth wide;", ["kernelWidth", NAME]),
    "two widths": (PROPERTIES, r"(kernelWidth.*)", r"\1\nwindowLength 1e-3;", ["kernelWidth and windowLength", NAME]),
    "negative window": (PROPERTIES, r"kernelWidth.*", "windowLength -1;", ["windowLength must be a number > 0", NAME]),
    "no samples": (PROPERTIES, r"(kernelWidth.*)", r"\1\nkernelSamples 0;", ["kernelSamples must be a whole number >= 1, <= 16", NAME]),
    "no interval": (PROPERTIES, r"^bedInterval.*", "bedInterval 0;", ["bedInterval must be a whole number", NAME]),
    "unknown exchange": (PROPERTIES, r"(kernelWidth.*)", r"\1\nexchange explicit;", ["exchange must be one of", "implicit", NAME]),
    "gradient neither on nor off": (PROPERTIES, r"(kernelWidth.*)", r"\1\ntemperatureGradient maybe;", ["temperatureGradient"]),
    "l of zero": ("settings", r"^l .*", "l 0;", ["ratio must be a number > 0, <= 1000 [-], not '0'", SCRIPT]),
    "negative l": ("settings", r"^l .*", "l -2;", ["ratio must be a number > 0, <= 1000 [-], not '-2'", SCRIPT]),
    "l given twice": (SCRIPT, r"^(fix\s+cg .*)", r"\1\nfix again all hotbed/coarsegrain ratio 2",
                      ["given already, by fix cg", SCRIPT]),
    "no heat capacity": (SCRIPT, r"^fix\s+capacity.*", "", ["heat capacity is missing: add", "thermalCapacity", SCRIPT]),
    "particles outside the mesh": ("system/blockMeshDict", r"0\.015", "0.012", ["outside the mesh", "blockMeshDict"]),
    "DEM script missing": (PROPERTIES, r"in\.fixed_bed", "in.nothing", ["cannot read the DEM script 'DEM/in.nothing'"]),
    "DEM script fails half-way": (SCRIPT, r"^set .*", "sett group all diameter 1", ["Unknown command", "sett", SCRIPT]),
    "DEM script without a box": (SCRIPT, r"[\s\S]*", "units si\n", ["makes no simulation box", SCRIPT]),
    "gas step no whole number of DEM steps": (SCRIPT, r"^timestep.*", "timestep 1e-3",
                                              ["whole number", "deltaT", "controlDict", "timestep", SCRIPT]),
    "gas step shorter than a DEM step": (SCRIPT, r"^timestep.*", "timestep 1", ["whole number", "deltaT"]),
    "restart": ("system/controlDict", r"^startTime.*", "startTime 1;", ["controlDict", "startTime 0", "holds no complete restart"]),
    "pressure over density": ("0/p", r"1 -1 -2", "0 2 -2", ["0/p: dimensions must be [1 -1 -2 0 0 0 0], not [0 2 -2 0 0 0 0]"]),
    "temperature of no kind": ("0/T", r"0 0 0 1", "0 0 1 1", ["0/T: dimensions must be [0 0 0 1 0 0 0], not [0 0 1 1 0 0 0]"]),
    "energy in e": ("constant/thermophysicalProperties", r"sensibleEnthalpy", "sensibleInternalEnergy", ["h"]),
}


class BadInput(CoupledTest):
    def test_errors(self):
        for name, (file, pattern, replacement, expected) in CASES.items():
            with self.subTest(name):
                target = self.scene(name.replace(" ", "_"), edits=[])
                edit(target / file, pattern, replacement)
                if file in ("system/blockMeshDict",):
                    run.tool(target, "blockMesh")
                if file == "system/controlDict":
                    (target / "1").mkdir()
                    for field in (target / "0").iterdir():
                        (target / "1" / field.name).write_text(field.read_text())
                before = {p: p.stat().st_mtime_ns for p in target.rglob("*") if p.is_file()}
                code, log = self.solve(target)
                self.assertNotEqual(code, 0)
                for text in expected:
                    self.assertIn(text, log)
                self.assertNotIn("Time = 0.", log, "something was computed")
                kept = {p: p.stat().st_mtime_ns for p in before if p.exists()}
                self.assertEqual(before, kept, "a file was changed")
                self.assertFalse((target / "0.1").exists())

    def test_errors_in_parallel(self):
        for name in ("l of zero", "misspelt key", "particles outside the mesh", "DEM script fails half-way"):
            with self.subTest(name):
                file, pattern, replacement, expected = CASES[name]
                target = self.scene(name.replace(" ", "_"), 2, [(file, pattern, replacement)],
                                    **({"l": -2 if "zero" in name else SMALL["l"]}))
                code, log = self.solve(target, 2)
                self.assertNotEqual(code, 0)
                for text in expected if "zero" not in name else ["ratio must be a number > 0, <= 1000 [-], not '-2'"]:
                    self.assertIn(text, log)

    def test_files_of_all_ranks_together(self):
        target = self.scene(ranks=2)
        with unittest.mock.patch.dict("os.environ", FOAM_FILEHANDLER="collated"):
            code, log = self.solve(target, 2)
        self.assertNotEqual(code, 0)
        self.assertIn("decompose and run with -fileHandler uncollated", log)
        self.assertNotIn("Time = 0.", log)

    def test_headers_of_another_version(self):
        # a library that says it is another version, put before the installed one
        source = self.folder / "other.cpp"
        source.write_text("#include <string>\nnamespace Foam { namespace foamVersion { extern const int api; "
                          "const int api = 1806; } }\n")
        subprocess.check_call(["g++", "-shared", "-fPIC", "-o", self.folder / "libother.so", source])
        target = self.scene()
        done = subprocess.run([run.SOLVER, "-case", target], capture_output=True, text=True,
                              env=dict(run.environment(), LD_PRELOAD=str(self.folder / "libother.so")))
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("built with the headers of OpenFOAM 1912", done.stdout + done.stderr)
        self.assertIn("the installed library is 1806", done.stdout + done.stderr)
        self.assertIn("remove the folder build", done.stdout + done.stderr)


class RunCommand(CoupledTest):
    def command(self, *arguments):
        return subprocess.run([sys.executable, run.__file__, *map(str, arguments), "--results", self.folder / "results"],
                              capture_output=True, text=True)

    def test_refusals(self):
        for arguments, expected in {
            (self.folder,): "is not a Hotbed case: system/controlDict is missing",
            (FIXED_BED, "--set", "ratio=2"): "no setting 'ratio'; known are l, height",
            (FIXED_BED, "--set", "l"): "write name=value",
            (FIXED_BED, "-np", "0"): "-np must be at least 1",
        }.items():
            with self.subTest(expected):
                done = self.command(*arguments)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn(expected, done.stderr)

    def test_results_are_not_overwritten(self):
        small = ["--set", *(f"{k}={v}" for k, v in SMALL.items())]
        self.assertEqual(self.command(FIXED_BED, *small).returncode, 0)
        written = {p: p.stat().st_mtime_ns for p in (self.folder / "results").rglob("*")}
        again = self.command(FIXED_BED, *small)
        self.assertNotEqual(again.returncode, 0)
        self.assertIn("or --overwrite to make it anew", again.stderr)
        self.assertEqual(written, {p: p.stat().st_mtime_ns for p in (self.folder / "results").rglob("*")})
        self.assertEqual(self.command(FIXED_BED, *small, "--overwrite").returncode, 0)

    def test_a_failed_preparation_is_no_run(self):
        case, small = self.folder / "case", [f"{k}={v}" for k, v in SMALL.items()]
        shutil.copytree(FIXED_BED, case)
        mesh = (case / "system/blockMeshDict").read_text()
        edit(case / "system/blockMeshDict", r"hex", "hexx")
        self.assertIn("blockMesh failed", self.command(case, "--set", *small).stderr)
        (case / "system/blockMeshDict").write_text(mesh)
        self.assertEqual(self.command(case, "--set", *small).returncode, 0)
        self.assertTrue((self.folder / "results/case/temperature.png").exists(), "the picture of a copied case")

    def test_a_picture_that_fails_is_told_after_the_run(self):
        case = self.folder / "case"
        shutil.copytree(FIXED_BED, case)
        (case / "plot.py").write_text("import sys\nsys.exit('no ink')\n")
        done = self.command(case, "--set", *(f"{k}={v}" for k, v in SMALL.items()))
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("no ink\nhotbed: ", done.stderr)
        self.assertIn("plot.py failed (exit status 1)", done.stderr)
        self.assertIn("Timing (1 rank", done.stdout)

    def test_words_of_openfoam_are_shown_not_its_stack(self):
        case = self.folder / "case"
        shutil.copytree(FIXED_BED, case)
        edit(case / "constant/turbulenceProperties", r"laminar;", "LES;\nLES { LESModel none; turbulence on; }")
        done = self.command(case, "-np", "2", "--set", *(f"{k}={v}" for k, v in SMALL.items()))
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("FOAM FATAL", done.stderr)
        self.assertIn("Unknown LESModel", done.stderr)
        self.assertNotIn("Foam::error::printStack", done.stderr)

    def test_a_path_that_openfoam_cannot_use(self):
        case = self.folder / "my case"
        shutil.copytree(FIXED_BED, case)
        done = self.command(case)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("my case/default: OpenFOAM takes no folder with ' ' in its path: rename that folder", done.stderr)
        self.assertFalse((self.folder / "results").exists())

    def test_run_on_two_and_three_ranks(self):
        for ranks in ("2", "3"):
            small = ["-np", ranks, "--overwrite", "--set", *(f"{k}={v}" for k, v in SMALL.items())]
            done = self.command(FIXED_BED, *small)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"Timing ({ranks} ranks", done.stdout)
            self.assertIn("not accounted for", done.stdout)
            self.assertTrue((self.folder / "results/fixed_bed/temperature.png").exists())


if __name__ == "__main__":
    unittest.main(verbosity=2)
