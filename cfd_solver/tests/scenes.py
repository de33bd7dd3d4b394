"""Small coupled scenes for the tests, made from the fixed-bed example in a temporary folder."""

import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "cfd_solver"), str(ROOT / "validation")]
import run
from campaign import edit

FIXED_BED = ROOT / "examples" / "fixed_bed"
SLIM_BED = ROOT / "examples" / "slim_bed"
SMALL = {"l": "2.5", "height": "0.03", "cellsHeight": "20", "endTime": "0.1", "writeInterval": "0.1"}

# for the slim bed
TIGHT = [("system/fvSolution", r"tolerance\s+1e-\d+", "tolerance 1e-12"),
         ("system/fvSolution", r"relTol\s+\S+;", "relTol 0;\n        maxIter 60;"),
         ("system/controlDict", r"writePrecision\s+\d+", "writePrecision 16")]
DUMP = [("DEM/in.bed", r"^dump .*", "dump particles all custom ${every} DEM/post/particles*.txt id x y z vx vy vz f_Temp\n"
         'dump_modify particles sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g"')]


class CoupledTest(unittest.TestCase):
    """A test with a folder of its own for its runs."""

    example = FIXED_BED

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = Path(self._folder.name)

    def tearDown(self):
        self._folder.cleanup()

    def scene(self, name="scene", ranks=1, edits=(), **settings):
        """A prepared copy of the example, small in the case of the fixed bed. @param edits (file, pattern, replacement) made before the mesh"""
        case = self.folder / f"{name}-case"
        copy(self.example, case)
        for file, pattern, replacement in edits:
            edit(case / file, pattern, replacement)
        target = self.folder / name
        run.prepare(case, target, {**(SMALL if self.example == FIXED_BED else {}), **{k: str(v) for k, v in settings.items()}}, ranks=ranks)
        return target

    def solve(self, target, ranks=1):
        """@return (exit status, log)"""
        process = run.start(target, ranks)
        code = process.wait(timeout=300)
        return code, (target / "log.hotbedFoam").read_text()


class SlimBedTest(CoupledTest):
    """A test on slim beds with moving particles."""

    example = SLIM_BED

    def bed(self, name, ranks=1, edits=(), interval=1, **settings):
        """@param interval bedInterval. @return (run folder, log) of a slim bed with l = 2.5 that ran to its end"""
        edits = [("constant/couplingProperties", r"^kernelWidth", f"bedInterval {interval};\nkernelWidth"), *edits]
        small = {"l": "2.5", "height": "0.05", "cellsHeight": "40", "maxDeltaT": "2.5e-5",
                 "writeInterval": settings["endTime"], **settings}
        target = self.scene(name, ranks, edits, **small)
        code, log = self.solve(target, ranks)
        self.assertEqual(code, 0, log[-2000:])
        return target, log


def copy(source, target):
    import shutil

    shutil.copytree(source, target)
