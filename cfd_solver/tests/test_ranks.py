"""The answer does not depend on the number of ranks nor on how gas and particles are split (tight solver tolerances)."""

import unittest

import numpy as np

from scenes import CoupledTest, run  # first: it finds the modules below
import results

TIGHT = [("system/fvSolution", r"tolerance\s+1e-\d+", "tolerance 1e-15"), ("system/fvSolution", r"relTol\s+\S+;", "relTol 0;"),
         ("system/controlDict", r"writePrecision\s+\d+", "writePrecision 16")]


def split(text):
    """edit of the gas decomposition"""
    return [("system/decomposeParDict", r"method[\s\S]*", text)]


SIMPLE = "method simple;\nsimpleCoeffs {{ n ({}); delta 0.001; }}\n"
SPLITS = {  # ranks, gas decomposition, DEM processor grid
    "2 ranks, gas along z, DEM along x": (2, SIMPLE.format("1 1 2"), "2 1 1"),
    "2 ranks, gas along y, DEM along z": (2, SIMPLE.format("1 2 1"), "1 1 2"),
    "4 ranks, gas along z, DEM 2 x 2": (4, SIMPLE.format("1 1 4"), "2 2 1"),
    "4 ranks, gas 2 x 2, DEM along z": (4, SIMPLE.format("2 2 1"), "1 1 4"),
    "4 ranks, gas scattered, DEM as LIGGGHTS likes": (4, "method random;\n", "* * *"),
}


class Ranks(CoupledTest):
    def temperatures(self, name, ranks, edits):
        target = self.scene(name.replace(" ", "_"), ranks, TIGHT + edits, endTime=0.05, writeInterval=0.05)
        code, log = self.solve(target, ranks)
        self.assertEqual(code, 0, log[-2000:])
        if ranks > 1:
            run.tool(target, "reconstructPar")
        gas = results.field(target / "0.05" / "T")
        particles = np.loadtxt(target / "DEM/post/particles20.txt", skiprows=9)
        order = np.lexsort(np.round(particles[:, :3] * 1e6).T)  # ids depend on the ranks, places do not
        return gas, particles[order, 3], results.bed(target)

    def test_same_temperatures(self):
        dump = [("DEM/in.fixed_bed", r"^timestep.*", r"\g<0>\ndump end all custom 20 DEM/post/particles*.txt x y z f_Temp\n"
                 r'dump_modify end format "%.17g %.17g %.17g %.17g"')]
        gas, particles, bed = self.temperatures("one", 1, dump)
        self.assertGreater(np.ptp(gas), 50.0, "the scene must have a front in it")
        for name, (ranks, text, grid) in SPLITS.items():
            dem = dump + [("DEM/in.fixed_bed", r"^newton", f"processors {grid}\nnewton")]
            with self.subTest(name):
                g, p, b = self.temperatures(name, ranks, split(text) + dem)
                self.assertLess(np.max(np.abs(g / gas - 1)), 1e-9)
                self.assertLess(np.max(np.abs(p / particles - 1)), 1e-9)
                self.assertLess(abs(b["budget_error"][-1]), 1e-9)
                print(f"{name}: gas within {np.max(np.abs(g / gas - 1)):.1e}, particles within "
                      f"{np.max(np.abs(p / particles - 1)):.1e}")


if __name__ == "__main__":
    unittest.main(verbosity=2)
