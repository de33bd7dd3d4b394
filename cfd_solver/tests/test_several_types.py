"""Two particle types with constants of their own and three diameters in one bed: energy, bounds, ranks."""

import unittest

import numpy as np

from scenes import DUMP, SlimBedTest, TIGHT  # first: it finds the modules below
import results

SCRIPT = "DEM/in.bed"
# type 2: heavier grains, stiffer, more elastic and rougher, 20 K colder; a third of the bed is of smaller grains
TYPES = [
    (SCRIPT, r"^create_box .*", "create_box 2 column"),
    (SCRIPT, r"kn peratomtypepair 1 \$\{kn\}", "kn peratomtypepair 2 500 600 600 900"),
    (SCRIPT, r"coefficientRestitution peratomtypepair 1 0.74", "coefficientRestitution peratomtypepair 2 0.74 0.8 0.8 0.9"),
    (SCRIPT, r"tangentialRestitution peratomtypepair 1 0.1", "tangentialRestitution peratomtypepair 2 0.1 0.2 0.2 0.3"),
    (SCRIPT, r"coefficientFriction peratomtypepair 1 0.1", "coefficientFriction peratomtypepair 2 0.1 0.2 0.2 0.4"),
    (SCRIPT, r"thermalCapacity peratomtype 779", "thermalCapacity peratomtype 779 450"),
    (SCRIPT, r"^set .*", """
variable middle equal 0.8*${d}
variable small equal 0.6*${d}
region third block 0 ${width} 0 ${depth} 0.002 0.005 units box
set group all type/fraction 2 0.4 12345
set type 1 diameter ${d}
set type 2 diameter ${middle}
set region third diameter ${small}
set type 1 density 1040
set type 2 density 2500
run 0
set type 2 property/atom Temp 343.15"""),
]


class SeveralTypes(SlimBedTest):
    def test_energy_bounds_and_constants(self):
        shown = [(SCRIPT, r"^dump .*", "dump particles all custom ${every} DEM/post/particles*.txt id type radius mass f_Temp")]
        target, _ = self.bed("energy", edits=TYPES + TIGHT[2:] + shown, endTime="0.01")
        bed = results.bed(target)
        start = np.loadtxt(target / "DEM/post/particles0.txt", skiprows=9)
        kinds = {tuple(k) for k in np.round(np.column_stack([start[:, 1], start[:, 2] * 1e6]), 3)}
        self.assertEqual(len(kinds), 4, "two types, the small diameter in both")
        self.assertEqual(len({radius for _, radius in kinds}), 3)
        # the energy that the budget starts from, from each particle's own mass and heat capacity
        energy = np.sum(start[:, 3] * np.where(start[:, 1] == 1, 779, 450) * start[:, 4])
        first = bed["particle_energy_J"][0]
        self.assertLess(abs(first / energy - 1), 1e-3)
        print(f"two types, three diameters: energy not accounted for {bed['budget_error'][-1]:.1e} of the exchange")
        self.assertLess(abs(bed["budget_error"][-1]), 1e-8)
        self.assertGreaterEqual(bed["gas_T_min_K"].min(), 293.15 - 1e-9)
        self.assertLessEqual(bed["gas_T_max_K"].max(), 363.15 + 1e-9)
        self.assertGreaterEqual(bed["T_min_K"].min(), 293.15)
        self.assertLessEqual(bed["T_max_K"].max(), 363.15 + 1e-9)

    def test_uniform_temperature_stays_uniform(self):
        same = [("0/T", r"293\.15", "363.15"), (SCRIPT, r"Temp 343\.15", "Temp 363.15")]
        target, _ = self.bed("uniform", edits=TYPES + TIGHT[:1] + same, endTime="0.005")
        bed = results.bed(target)
        off = max(np.max(np.abs(bed[name] / 363.15 - 1)) for name in ("T_min_K", "T_max_K", "gas_T_min_K", "gas_T_max_K"))
        print(f"uniform temperature, {len(bed)} steps: off by {off:.1e}")
        self.assertLess(off, 1e-9)

    def test_ranks_agree(self):
        places = {}
        for ranks, grid in ((1, "1 1 1"), (2, "1 2 1")):
            target, _ = self.bed(f"ranks{ranks}", ranks, TYPES + TIGHT + DUMP + [
                (SCRIPT, r"^newton", f"processors {grid}\nnewton")], endTime="0.0005")
            start = np.loadtxt(target / "DEM/post/particles0.txt", skiprows=9)
            rows = np.loadtxt(target / "DEM/post/particles200.txt", skiprows=9)
            order = np.lexsort(np.round(start[:, 1:4] * 1e6).T)  # ids depend on the ranks
            places[ranks] = rows[order, 1:]
        scale = np.array([1e-3] * 3 + [np.abs(places[1][:, 3:6]).max()] * 3 + [363.15])
        off = np.max(np.abs(places[2] - places[1]) / scale)
        print(f"2 ranks off by {off:.1e}")
        self.assertLess(off, 1e-8)


if __name__ == "__main__":
    unittest.main(verbosity=2)
