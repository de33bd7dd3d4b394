"""The bed in a cylinder, whose cells are no boxes: wall surface from the gas mesh, on one and two ranks, from a mesh that the
case brings."""

import re
import shutil
import unittest

import numpy as np

from scenes import CoupledTest, ROOT, TIGHT, run  # first: it finds the modules below
import results

# the slices of two ranks cut the bed across the kernels of many particles
SMALL = {"l": "2.5", "height": "0.02", "cellsHeight": "14", "filled": "0.012", "endTime": "0.0005", "writeInterval": "0.0005"}
EDITS = TIGHT + [("constant/couplingProperties", r"^kernelWidth", "bedInterval 1;\nwriteRestart no;\nkernelWidth")]


class Cylinder(CoupledTest):
    example = ROOT / "examples" / "cylinder_bed"

    def bed(self, target, ranks=1):
        code, log = self.solve(target, ranks)
        self.assertEqual(code, 0, log[-2000:])
        self.assertIn("through a lattice", log)
        return results.bed(target)

    def test_two_ranks_give_what_one_does(self):
        along_z = [("system/decomposeParDict", r"n \(.*?\)", "n (1 1 2)"), ("DEM/in.bed", r"^newton", "processors 2 1 1\nnewton")]
        one, two, other = (self.bed(self.scene(f"{n}{len(more)}", n, EDITS + more, **SMALL), n) for n, more in ((1, []), (2, []), (2, along_z)))
        for bed in (one, two, other):
            self.assertLess(np.abs(bed["budget_error"]).max(), 1e-8)
            self.assertLess(bed["mismatch"].max(), 1e-12)
            self.assertLess(bed["momentum_error"][-1], 1e-2)
            self.assertGreaterEqual(bed["gas_T_min_K"].min(), 293.15 - 1e-9)
            self.assertLessEqual(bed["gas_T_max_K"].max(), 363.15 + 1e-9)
        for column, scale in (("T_mean_K", 70), ("Nu_mean", 10), ("z_mean_m", 0.01), ("pressure_drop_Pa", 100)):
            off = max(np.abs(one[column] - bed[column]).max() for bed in (two, other)) / scale
            print(f"cylinder, {column}: two ranks off by {off:.1e}")
            self.assertLess(off, 1e-9)

    def test_restart_goes_on_to_the_last_digit(self):
        edits = [("constant/couplingProperties", r"^kernelWidth", "bedInterval 1;\nkernelWidth")]
        interval = {**SMALL, "writeInterval": "0.00025"}
        whole = self.bed(self.scene("whole", edits=edits, **interval))
        target = self.scene("pieces", edits=edits, **{**interval, "endTime": "0.00025"})
        self.bed(target)
        run.resume(target, {"endTime": SMALL["endTime"]})
        np.testing.assert_array_equal(self.bed(target), whole)

    def test_wall_surface_is_the_patch(self):
        target = self.scene(**SMALL)
        corners = np.array(re.findall(r"vertex\s+(\S+)\s+(\S+)\s+(\S+)", (target / "constant/triSurface/walls.stl").read_text()), float)
        a, b, c = corners.reshape(-1, 3, 3).transpose(1, 0, 2)
        area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
        self.assertAlmostEqual(area / (24 * 2 * 0.008 * np.sin(np.pi / 24) * 0.02), 1, places=9)  # a prism of 24 sides
        self.assertLess(np.abs(np.hypot(*corners[:, :2].T) - 0.008).max(), 1e-9)

    def test_a_mesh_that_the_case_brings(self):
        made = self.scene("made", edits=EDITS, **SMALL)
        case = self.folder / "own"
        shutil.copytree(made, case, ignore=shutil.ignore_patterns("triSurface"))
        (case / "system/blockMeshDict").unlink()
        own = self.folder / "own-run"
        run.prepare(case, own)
        self.assertTrue((own / "constant/triSurface/walls.stl").is_file())
        np.testing.assert_array_equal(self.bed(own)["T_mean_K"], self.bed(made)["T_mean_K"])
        shutil.rmtree(case / "constant/polyMesh")
        with self.assertRaisesRegex(run.CaseError, "blockMeshDict into system, or the mesh itself into constant/polyMesh"):
            run.prepare(case, self.folder / "none")

    def test_a_surface_of_no_patch_is_refused(self):
        with self.assertRaisesRegex(run.CaseError, r"side.stl.*\(inlet, outlet, walls\)"):
            self.scene(edits=[("DEM/in.bed", r"triSurface/walls", "triSurface/side")], **SMALL)

    def test_particles_beyond_the_wall_are_refused(self):
        target = self.scene(edits=[("DEM/in.bed", r"^variable +clear .*", "variable clear equal 1.2*${radius}")], **SMALL)
        code, log = self.solve(target)
        self.assertNotEqual(code, 0)
        self.assertIn("lie outside the mesh", log)


if __name__ == "__main__":
    unittest.main(verbosity=2)
