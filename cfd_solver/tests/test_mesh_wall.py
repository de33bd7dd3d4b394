"""A bed that lands on a floor that is an STL mesh, on one and two ranks: the same as on the primitive wall z = 0."""

import unittest

import numpy as np

from scenes import CoupledTest, DUMP, SlimBedTest, TIGHT, edit  # first: it finds the modules below
import results

# four triangles over the column's 20 x 10 mm, about a point that is under no particle of the lattice
CORNERS = ["0 0 0", "0.02 0 0", "0.02 0.01 0", "0 0.01 0"]
FLOOR = "solid floor\n" + "".join(
    f"facet normal 0 0 1\nouter loop\nvertex {CORNERS[n]}\nvertex {CORNERS[(n + 1) % 4]}\nvertex 0.0123 0.0041 0\nendloop\nendfacet\n"
    for n in range(4)) + "endsolid floor\n"
MESH = [("DEM/in.bed", r"^fix +zlow .*", "fix floor all mesh/surface file DEM/floor.stl type 1\n"
         "fix zlow all wall/gran model hotbed tangential hotbed mesh n_meshes 1 meshes floor")]

LOW = [("DEM/in.bed", r"^variable +c equal .*", "variable c equal 1.001*${d}")]  # layers that soon lie on each other


class MeshWall(SlimBedTest):
    def landed(self, name, edits, ranks=1):
        """@return particles after they have met the floor, by their places at the start"""
        target = self.scene(name, ranks, TIGHT + DUMP + LOW + edits, l="2.5", wallSetback="0", height="0.05", cellsHeight="40",
                            maxDeltaT="2.5e-5", endTime="0.003", writeInterval="0.003")
        (target / "DEM/floor.stl").write_text(FLOOR)
        code, log = self.solve(target, ranks)
        self.assertEqual(code, 0, log[-2000:])
        self.assertLess(abs(results.bed(target)["budget_error"][-1]), 1e-8)
        start = np.loadtxt(target / "DEM/post/particles0.txt", skiprows=9)
        rows = np.loadtxt(target / "DEM/post/particles1200.txt", skiprows=9)
        return rows[np.lexsort(np.round(start[:, 1:4] * 1e6).T), 1:]

    def test_same_as_on_the_primitive_wall(self):
        for ranks in (1, 2):
            primitive = self.landed(f"primitive{ranks}", [], ranks)
            self.assertLess(primitive[:, 2].min(), 0.5 * 2.5 * 5e-4, "the lowest particles must touch the floor")
            scale = np.array([1e-3] * 3 + [np.abs(primitive[:, 3:6]).max()] * 3 + [363.15])
            off = np.max(np.abs(self.landed(f"mesh{ranks}", MESH, ranks) - primitive) / scale)
            print(f"mesh floor, {ranks} rank(s): off by {off:.1e} from the primitive wall")
            self.assertLess(off, 1e-8)


class FixedBed(CoupledTest):
    def test_a_mesh_moves_no_particle(self):
        target = self.scene()
        (target / "DEM/floor.stl").write_text(FLOOR)
        edit(target / "DEM/in.fixed_bed", r"^timestep.*", r"\g<0>\nfix floor all mesh/surface file DEM/floor.stl type 1 scale 0.5")
        code, log = self.solve(target)
        self.assertEqual(code, 0, log[-2000:])
        self.assertIn("weights are evaluated once", log)


if __name__ == "__main__":
    unittest.main(verbosity=2)
