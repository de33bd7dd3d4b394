"""A bed whose particles move: uniform temperature stays uniform, energy is conserved, ranks agree."""

import unittest

import numpy as np

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

    def test_ranks_agree(self):
        end = "0.0005"  # 20 gas steps, 200 DEM steps
        places = {}
        for ranks, grid in ((1, "1 1 1"), (2, "1 1 2"), (4, "2 2 1")):
            target, _ = self.bed(f"ranks{ranks}", ranks, TIGHT + DUMP + [
                ("DEM/in.bed", r"^newton", f"processors {grid}\nnewton")], endTime=end)
            rows = np.loadtxt(target / "DEM/post/particles200.txt", skiprows=9)
            start = np.loadtxt(target / "DEM/post/particles0.txt", skiprows=9)
            order = start[np.lexsort(np.round(start[:, 1:4] * 1e6).T), 0].astype(int) - 1  # ids depend on the ranks
            places[ranks] = rows[np.argsort(rows[:, 0])][order, 1:]
        one = places[1]
        scale = np.array([1e-3] * 3 + [np.abs(one[:, 3:6]).max()] * 3 + [363.15])
        for ranks in (2, 4):
            off = np.max(np.abs(places[ranks] - one) / scale, axis=0)
            print(f"{ranks} ranks: positions off by {off[:3].max():.1e} mm, velocities {off[3:6].max():.1e}, "
                  f"temperatures {off[6]:.1e}")
            self.assertLess(off.max(), 1e-8)


if __name__ == "__main__":
    unittest.main(verbosity=2)
