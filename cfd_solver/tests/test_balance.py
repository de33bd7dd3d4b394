"""How the particles are shared out among ranks: as the gas is where the script does not say, and anew as the bed moves."""

import re
import shutil
import unittest

import numpy as np

from scenes import DUMP, TIGHT, SLIM_BED, SlimBedTest, run  # first: it finds the modules below
import decompose

HEAP = ("DEM/in.bed", r"^(region\s+layers block 0) \$\{width\}", r"\1 0.01")  # in one half of the width
BALANCE = ("DEM/in.bed", r"^timestep", "fix balance all hotbed/balance every 20\ntimestep")
# Without exchange of heat, which amplifies round-off where a hot heap lies beside a cold jet. The particles' temperatures tell
# whether each keeps its own.
TWO_TEMPERATURES = [("constant/couplingProperties", r"heatTransfer\s+\S+;", "heatTransfer none;"),
                    ("DEM/in.bed", r"^label\s+filled", "run 0\nregion right block 0.005 INF INF INF INF INF units box\n"
                     r"set region right property/atom Temp 343.15\n\g<0>")]
END = {"endTime": "0.0005", "writeInterval": "0.0005"}  # 20 gas steps, 200 DEM steps


def gas(n):
    return "system/decomposeParDict", r"n \(.*?\)", f"n ({n})"


def imbalance(log, what):
    return float(re.search(rf"imbalance, {what}\s+(\S+) largest over mean, rank \d", log)[1])


def sent(log):
    return float(re.search(r"sent by a rank a step\s+(\S+) KiB", log)[1])


class Balance(SlimBedTest):
    def places(self, target):
        """Rows of x y z vx vy vz T at the end, in an order that does not depend on the ranks."""
        start, rows = (np.loadtxt(target / f"DEM/post/particles{step}.txt", skiprows=9) for step in (0, 200))
        order = start[np.lexsort(np.round(start[:, 1:4] * 1e6).T), 0].astype(int) - 1
        return rows[np.argsort(rows[:, 0])][order, 1:]

    def compare(self, name, target, expected):
        scale = np.array([1e-3] * 3 + [np.abs(expected[:, 3:6]).max()] * 3 + [363.15])
        off = np.max(np.abs(self.places(target) - expected) / scale)
        print(f"{name}: off by {off:.1e}")
        self.assertLess(off, 1e-8)

    def test_heap_on_one_side(self):
        edits = TIGHT + DUMP + TWO_TEMPERATURES + [HEAP]
        one, log = self.bed("one", 1, edits, **END)
        self.assertNotIn("imbalance", log)
        still, before = self.bed("still", 4, edits + [gas("4 1 1")], **END)
        moved, after = self.bed("moved", 4, edits + [gas("4 1 1"), BALANCE], **END)
        for name, log in (("as cut", before), ("with fix hotbed/balance", after)):
            print(f"{name}: particles, largest over mean of 4 ranks {imbalance(log, 'particles')}; a rank sends {sent(log)} KiB a step")
        self.assertGreater(imbalance(before, "particles"), 1.9, "two of four slices are empty")
        self.assertLess(imbalance(after, "particles"), 1.4, "the mean of the run, which begins as cut")
        expected = self.places(one)
        self.assertEqual(set(expected[:, 6]), {343.15, 363.15})
        self.compare("as cut", still, expected)
        self.compare("with fix hotbed/balance", moved, expected)

    def test_goes_on_from_a_restart(self):
        edits = TIGHT + DUMP + TWO_TEMPERATURES + [HEAP, BALANCE]
        half = {**END, "writeInterval": "0.00025"}
        whole, _ = self.bed("whole", 2, edits, **half)
        pieces, _ = self.bed("pieces", 2, edits, **{**half, "endTime": "0.00025"})
        run.resume(pieces, {"endTime": END["endTime"]}, ranks=2)
        code, log = self.solve(pieces, 2)
        self.assertEqual(code, 0, log[-2000:])
        self.compare("going on from a restart", pieces, self.places(whole))


class Cuts(SlimBedTest):
    def cut(self, name, edits):
        """@return (pieces of the particles' box, KiB sent a step) on 4 ranks"""
        target, log = self.bed(name, 4, edits, endTime="2.5e-5")
        grid = re.search(r"(\d) by (\d) by (\d) MPI processor grid", (target / "log.liggghts").read_text())
        return " ".join(grid.groups()), sent(log)

    def test_particles_are_cut_as_the_gas_is(self):
        scattered = ("system/decomposeParDict", r"method[\s\S]*", "method random;\n")
        chosen, few = self.cut("chosen", [("settings", r"^depth .*", "depth 0.02;"), gas("2 1 1")])
        self.assertEqual(chosen, "2 2 1", "by hotbed run, for a square")
        given, _ = self.cut("given", [gas("1 4 1")])
        self.assertEqual(given, "1 4 1")
        script, many = self.cut("script", [("settings", r"^depth .*", "depth 0.02;"), gas("2 2 1"),
                                           ("DEM/in.bed", r"^newton", "processors 1 1 4\nnewton")])
        self.assertEqual(script, "1 1 4")
        print(f"2 x 2: a rank sends {few} KiB a step, with particles cut otherwise {many}")
        self.assertLess(few, 0.5 * many)
        for up, axis in ((("constant/g", r"\(0 0 -9\.81\)", "(9.81 0 0)"), 0), (("constant/g", r"9\.81", "9.80"), 2)):
            pieces, _ = self.cut(f"scattered{axis}", [scattered, up])
            self.assertEqual(pieces.split()[axis], "1", "not across gravity")

    def test_without_a_dictionary(self):
        case = self.folder / "case"
        shutil.copytree(SLIM_BED, case)
        (case / "system/decomposeParDict").unlink()
        run.prepare(case, self.folder / "run", {"l": "2.5"}, ranks=4)
        self.assertIn("n (4 1 1)", (self.folder / "run/system/decomposeParDict").read_text())
        self.assertTrue((self.folder / "run/processor3").is_dir())

    def test_pieces(self):
        down = (0, 0, -9.81)
        for ranks, size, gravity, expected in (
                (4, (0.04, 0.025, 0.2), down, (2, 2, 1)), (8, (0.04, 0.025, 0.2), down, (4, 2, 1)),
                (4, (0.04, 0.01, 0.2), down, (4, 1, 1)), (7, (0.04, 0.025, 0.2), down, (7, 1, 1)),
                (4, (0.2, 0.02, 0.01), (9.81, 0.1, 0), (1, 4, 1)), (4, (0.015, 0.015, 0.15), (0, 0, 0), (1, 1, 4))):
            self.assertEqual(decompose.pieces(ranks, size, gravity), expected)


if __name__ == "__main__":
    unittest.main(verbosity=2)
