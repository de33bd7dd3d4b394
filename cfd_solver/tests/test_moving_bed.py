"""A bed whose particles move: uniform temperature stays uniform, energy is conserved, ranks agree."""

import unittest

import numpy as np
from scipy.spatial import cKDTree

from scenes import DUMP, SlimBedTest, TIGHT  # first: it finds the modules below
import results

class MovingBed(SlimBedTest):
    def test_uniform_temperature_stays_uniform(self):
        same = [("0/T", r"293\.15", "363.15")]
        target, _ = self.bed("uniform", edits=TIGHT[:1] + same, endTime="0.025")
        bed = results.bed(target)
        self.assertEqual(len(bed), 1000)
        off = max(np.max(np.abs(bed[name] / 363.15 - 1)) for name in ("T_min_K", "T_max_K", "gas_T_min_K", "gas_T_max_K"))
        print(f"uniform temperature, 1000 steps: off by {off:.1e}")
        self.assertLess(off, 1e-9)

    def test_energy_is_conserved_and_gas_bounded(self):
        for l in ("1.5", "2.5", "5"):
            target, log = self.bed(f"energy{l}", edits=TIGHT[2:], endTime="0.01", l=l)
            bed = results.bed(target)
            print(f"l = {l}: energy not accounted for {bed['budget_error'][-1]:.1e} of the exchange")
            self.assertLess(abs(bed["budget_error"][-1]), 1e-8)
            self.assertGreaterEqual(bed["gas_T_min_K"].min(), 293.15 - 1e-9)
            self.assertLessEqual(bed["gas_T_max_K"].max(), 363.15 + 1e-9)
            self.assertIn("particle motion   on", log)

    def test_heights_and_overlap(self):
        """Columns of bed.csv against the particles themselves; lines at the interval, sums over every step."""
        end = {"endTime": "0.00215", "writeInterval": "0.00215"}
        every, _ = self.bed("every", edits=TIGHT + DUMP, **end)
        tenth, _ = self.bed("tenth", edits=TIGHT + DUMP, interval=10, **end)
        rows, few = results.bed(every), results.bed(tenth)
        np.testing.assert_allclose(few["time_s"], [*np.arange(1, 9) * 2.5e-4, 0.00215], rtol=1e-12)
        for name in ("z_mean_m", "overlap_max", "inflow_J", "exchanged_J", "budget_error"):
            np.testing.assert_array_equal(few[name], rows[name][[*range(9, 80, 10), 85]], name)
        two = results.bed(self.bed("two", 2, TIGHT + DUMP, 10, **end)[0])
        for name in ("z_mean_m", "height_m", "overlap_max"):
            np.testing.assert_allclose(two[name], few[name], rtol=0, atol=2e-6, err_msg=name)

        last = np.loadtxt(every / "DEM/post/particles860.txt", skiprows=9)
        x, d = last[:, 1:4], 2.5 * 5e-4
        near = cKDTree(x).query_pairs(d, output_type="ndarray")
        gap = np.r_[np.linalg.norm(x[near[:, 0]] - x[near[:, 1]], axis=1) - d, x.min() - d / 2,
                    [size - x[:, axis].max() - d / 2 for axis, size in enumerate((0.02, 0.01, 0.05))]]
        self.assertGreater(-gap.min(), 0, "something touches")
        self.assertAlmostEqual(rows["overlap_max"][-1], -gap.min() / d, delta=1e-9)
        self.assertAlmostEqual(rows["z_mean_m"][-1], x[:, 2].mean(), delta=1e-12)
        # Table 2: 1040 kg/m3 of 3.14e-6 m3 on 20 mm x 10 mm
        self.assertAlmostEqual(rows["weight_Pa"][-1], 1040 * len(x) * np.pi / 6 * d**3 * 9.81 / 2e-4, delta=1e-6)
        # a layer of the histogram is a thousandth of the mesh's height
        self.assertAlmostEqual(rows["height_m"][-1], np.quantile(x[:, 2], 0.99), delta=1.5e-4)

        sideways = [("constant/g", r"\(0 0 -9\.81\)", "(9.81 0 0)"), ("DEM/in.bed", r"vector 0 0 -1", "vector 1 0 0")]
        other, _ = self.bed("sideways", edits=DUMP + sideways, endTime="0.0001")
        x = np.loadtxt(other / "DEM/post/particles40.txt", skiprows=9)[:, 1]
        self.assertAlmostEqual(results.bed(other)["z_mean_m"][-1], 0.02 - x.mean(), delta=1e-12)

    def test_ranks_and_integrations_agree(self):
        stock = ("DEM/in.bed", r"^fix\s+integrate .*", "fix gravity all gravity 9.81 vector 0 0 -1\nfix integrate all nve/sphere")
        kept = ("constant/couplingProperties", r"^kernelWidth", "closureCo 1;\nkernelWidth")  # in several steps
        end = "0.0005"  # 20 gas steps, 200 DEM steps
        places = {}
        runs = {"one": (1, "1 1 1", []), "two": (2, "1 1 2", []), "four": (4, "2 2 1", []), "nve/sphere": (1, "1 1 1", [stock])}
        for name, (ranks, grid, edits) in runs.items():
            target, log = self.bed(name.replace("/", "_"), ranks, [*TIGHT, *DUMP, *edits, kept,
                ("DEM/in.bed", r"^newton", f"processors {grid}\nnewton")], endTime=end)
            self.assertLess(results.evaluated(log), 0.7)
            rows = np.loadtxt(target / "DEM/post/particles200.txt", skiprows=9)
            start = np.loadtxt(target / "DEM/post/particles0.txt", skiprows=9)
            order = start[np.lexsort(np.round(start[:, 1:4] * 1e6).T), 0].astype(int) - 1  # ids depend on the ranks
            places[name] = rows[np.argsort(rows[:, 0])][order, 1:]
        one = places.pop("one")
        scale = np.array([1e-3] * 3 + [np.abs(one[:, 3:6]).max()] * 3 + [363.15])
        for name, other in places.items():
            off = np.max(np.abs(other - one) / scale, axis=0)
            print(f"{name}: positions off by {off[:3].max():.1e} mm, velocities {off[3:6].max():.1e}, "
                  f"temperatures {off[6]:.1e}")
            self.assertLess(off.max(), 1e-8)


if __name__ == "__main__":
    unittest.main(verbosity=2)
