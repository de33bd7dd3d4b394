"""How the particles are shared out among ranks: as the gas is where the script does not say, and anew as the bed moves."""

import re
import unittest

import numpy as np

from scenes import DUMP, TIGHT, SlimBedTest, run  # first: it finds the modules below

FREE = ("DEM/in.bed", r"^processors .*\n", "")  # nothing is said of the particles
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
        edits = TIGHT + DUMP + TWO_TEMPERATURES + [FREE, HEAP]
        one, log = self.bed("one", 1, edits, **END)
        self.assertNotIn("imbalance", log)
        still, before = self.bed("still", 4, edits + [gas("4 1 1")], **END)
        moved, after = self.bed("moved", 4, edits + [gas("4 1 1"), BALANCE], **END)
        print(f"particles, largest over mean of 4 ranks: {imbalance(before, 'particles')} as cut, "
              f"{imbalance(after, 'particles')} with fix hotbed/balance")
        self.assertGreater(imbalance(before, "particles"), 1.9, "two of four slices are empty")
        self.assertLess(imbalance(after, "particles"), 1.4, "the mean of the run, which begins as cut")
        expected = self.places(one)
        self.assertEqual(set(expected[:, 6]), {343.15, 363.15})
        self.compare("as cut", still, expected)
        self.compare("with fix hotbed/balance", moved, expected)


if __name__ == "__main__":
    unittest.main(verbosity=2)
