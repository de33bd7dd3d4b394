"""What a scene switches off is left out; OpenFOAM's own controls work; odd but legal scenes run."""

import re
import unittest

import numpy as np

from scenes import CoupledTest
import results

NO_HEAT = ("DEM/in.fixed_bed", r"^fix\s+(heat|layers) .*", "")


class LeftOut(CoupledTest):
    def test_no_heat(self):
        target = self.scene(edits=[NO_HEAT])
        code, log = self.solve(target)
        self.assertEqual(code, 0, log[-2000:])
        self.assertIn("left out: no energy equation", log)
        self.assertNotIn("Solving for h", log)
        self.assertEqual(results.bed(target).dtype.names, ("time_s", "particles", "pressure_drop_Pa", "mismatch"))

    def test_no_drag(self):
        target = self.scene(edits=[("constant/couplingProperties", "Beetstra;", "none;"), NO_HEAT])
        code, log = self.solve(target)
        self.assertEqual(code, 0, log[-2000:])
        p = results.field(target / "0.1" / "p") if "nonuniform" in (target / "0.1" / "p").read_text() else np.zeros(1)
        self.assertLess(np.ptp(p), 100.0, "without drag nothing holds the gas back")

    def test_fixed_bed_moves_nothing_and_maps_once(self):
        target = self.scene()
        code, log = self.solve(target)
        self.assertEqual(code, 0, log[-2000:])
        self.assertIn("weights are evaluated once", log)


class OpenFoamControls(CoupledTest):
    def test_adjust_time_step_in_whole_dem_steps(self):
        target = self.scene(edits=[
            ("system/controlDict", r"^deltaT.*", "deltaT $deltaT;\nadjustTimeStep yes;\nmaxCo 0.7;\nmaxDeltaT 1;"),
            ("DEM/in.fixed_bed", r"^timestep.*", "timestep 5e-4"),
            ("DEM/in.fixed_bed", r"^variable\s+every.*", "variable every equal 100")])
        code, log = self.solve(target)
        self.assertEqual(code, 0, log[-2000:])
        steps = [int(s) for s in re.findall(r"DEM steps (\d+)", log)]
        self.assertGreater(max(steps), steps[0], "the step must grow towards the Courant number")
        courant = [float(c) for c in re.findall(r"Courant (\S+)", log)]
        self.assertLess(max(courant), 0.72)
        self.assertLess(abs(results.bed(target)["budget_error"][-1]), 1e-9)

    def test_function_objects_and_write_control(self):
        target = self.scene(edits=[
            ("system/controlDict", r"^writeControl.*", "writeControl timeStep;"),
            ("system/controlDict", r"^writeInterval.*", "writeInterval 10;\nfunctions\n{\n    range\n    {\n        "
             "type fieldMinMax;\n        libs (fieldFunctionObjects);\n        fields (T voidage);\n    }\n}")])
        code, log = self.solve(target)
        self.assertEqual(code, 0, log[-2000:])
        self.assertTrue((target / "0.025" / "T").exists())
        self.assertTrue((target / "postProcessing/range/0/fieldMinMax.dat").exists())


class PlainExchange(CoupledTest):
    def test_plain_exchange_conserves_and_differs_in_the_step(self):
        heat = {}
        for exchange in ("linear", "implicit"):
            target = self.scene(exchange, deltaT=5e-3, exchange=exchange)
            code, log = self.solve(target)
            self.assertEqual(code, 0, log[-2000:])
            bed = results.bed(target)
            self.assertLess(abs(bed["budget_error"][-1]), 1e-9)
            self.assertLess(bed["mismatch"].max(), 1e-12)
            heat[exchange] = bed["T_mean_K"][-1] - 293
        self.assertNotEqual(heat["implicit"], heat["linear"])
        self.assertAlmostEqual(heat["implicit"] / heat["linear"], 1, delta=0.01)


class OddScenes(CoupledTest):
    def test_kernel_wider_than_the_domain_is_a_warning(self):
        target = self.scene(edits=[("constant/couplingProperties", "kernelWidth.*", "windowLength 0.05;")])
        code, log = self.solve(target)
        self.assertEqual(code, 0, log[-2000:])
        self.assertIn("wider than the domain", log)
        self.assertLess(abs(results.bed(target)["budget_error"][-1]), 1e-9)

    def test_ranks_without_particles(self):
        low = ("DEM/in.fixed_bed", r"^region\s+bed.*", "region bed block 0 0.015 0 0.015 0 0.006 units box")
        along = ("DEM/in.fixed_bed", r"^newton", "processors 1 1 4\nnewton")
        target = self.scene(ranks=4, edits=[low, along, ("system/decomposeParDict", r"method[\s\S]*",
                                                         "method simple;\nsimpleCoeffs { n (1 1 4); delta 0.001; }")])
        code, log = self.solve(target, 4)
        self.assertEqual(code, 0, log[-2000:])
        self.assertLess(abs(results.bed(target)["budget_error"][-1]), 1e-9)

    def test_cells_that_are_not_boxes(self):
        # the top shifted sideways: parallelepipeds, wide enough to hold the bed
        sheared = [("system/blockMeshDict", r"^    \(0 0 0\).*", "    (-0.004 0 0) (0.016 0 0) (0.016 0.015 0) (-0.004 0.015 0)"),
                   ("system/blockMeshDict", r"^    \(0 0 \$height\).*",
                    "    (-0.001 0 $height) (0.019 0 $height) (0.019 0.015 $height) (-0.001 0.015 $height)")]
        for ranks in (1, 2):
            target = self.scene(f"sheared{ranks}", ranks, sheared)
            code, log = self.solve(target, ranks)
            self.assertEqual(code, 0, log[-2000:])
            self.assertIn("cells of any shape", log)
            bed = results.bed(target)
            self.assertLess(abs(bed["budget_error"][-1]), 1e-9)
            # cells at the sides hold gas only and let hot gas past; it must stay in its bounds all the same
            self.assertLess(bed["gas_T_max_K"].max(), 393 + 1e-6)

    def test_no_coarse_graining_fix_means_original_particles(self):
        target = self.scene(edits=[("DEM/in.fixed_bed", r"^fix\s+cg .*", "fix cg all property/global d scalar 4.875e-4"),
                                   ("DEM/in.fixed_bed", r"f_cg\[3\]", "1.21875e-3")])
        code, log = self.solve(target)
        self.assertEqual(code, 0, log[-2000:])
        self.assertIn("ratio l = 1,", log)


if __name__ == "__main__":
    unittest.main(verbosity=2)
