"""Particles come and go during a coupled run, from none to none; the energy budget counts what they carry."""

import re
import shutil
import unittest

import numpy as np

from scenes import SlimBedTest, edit, run  # first: it finds the modules below
import results

C_P = {1: 779.0, 2: 450.0}
DENSITY, DIAMETER = {1: 1040.0, 2: 2500.0}, {1: 1.25e-3, 2: 1e-3}  # of the coarse particles, l = 2.5
T0 = 363.15

HEAD = """
units si
atom_style granular
boundary f f f
newton off
communicate single vel yes
{settings}
variable resume index 0
if "${{resume}} == 1" then "read_restart ${{restart}}" "jump SELF made"
region box block 0 ${{width}} 0 ${{depth}} {low} {high} units box
create_box 2 box
label made
neighbor 1e-4 bin
neigh_modify delay 0
fix cg all hotbed/coarsegrain ratio ${{l}}
fix m1 all property/global kn peratomtypepair 2 500 500 500 800
fix m2 all property/global coefficientRestitution peratomtypepair 2 0.74 0.8 0.8 0.9
fix m3 all property/global tangentialRestitution peratomtypepair 2 0.1 0.1 0.1 0.1
fix m4 all property/global coefficientFriction peratomtypepair 2 0.1 0.1 0.1 0.2
fix capacity all property/global thermalCapacity peratomtype 779 450
fix heat all hotbed/heat initial_temperature 363.15
fix drag all hotbed/drag
pair_style gran model hotbed tangential hotbed
pair_coeff * *
fix integrate all nve/sphere
fix one all particletemplate/sphere 15485863 atom_type 1 density constant 1040 radius constant 6.25e-4
fix two all particletemplate/sphere 15485867 atom_type 2 density constant 2500 radius constant 5e-4
fix both all particledistribution/discrete 32452843 2 one 0.5 two 0.5
{insertion}
shell mkdir DEM/post
variable every equal round(${{writeInterval}}/${{deltaTDEM}})
dump particles all custom ${{every}} DEM/post/particles*.txt id type x y z mass f_Temp
dump_modify particles sort id format "%d %d %.17g %.17g %.17g %.17g %.17g"
thermo 100
thermo_modify lost ignore norm no
timestep ${{deltaTDEM}}
"""
# shot upwards from the lower part of the column, out through its top
REGION = """region place block 0.001 0.009 0.001 0.009 0.001 0.008 units box
fix come all insert/rate/region seed 32452867 distributiontemplate both nparticles 60 particlerate 20000 insert_every 200 &
    overlapcheck yes {more} vel constant 0 0 8 region place"""
# a stream from above the mesh down through it
STREAM = """fix face all mesh/surface/planar file DEM/face.stl type 1
fix come all insert/stream seed 32452867 distributiontemplate both nparticles 40 particlerate 20000 &
    overlapcheck yes vel constant 0 0 -8 insertion_face face extrude_length 0.004"""
# once, on a floor; nothing leaves
PACK = """region place block 0 ${width} 0 ${depth} 0 0.01 units box
fix come all insert/pack seed 32452867 distributiontemplate both insert_every once overlapcheck yes all_in yes &
    volumefraction_region 0.3 region place
fix zlow all wall/gran model hotbed tangential hotbed primitive type 1 zplane 0"""
FACE = """solid face
facet normal 0 0 1
outer loop
vertex 0.002 0.002 0.0225
vertex 0.008 0.002 0.0225
vertex 0.008 0.008 0.0225
endloop
endfacet
facet normal 0 0 1
outer loop
vertex 0.002 0.002 0.0225
vertex 0.008 0.008 0.0225
vertex 0.002 0.008 0.0225
endloop
endfacet
endsolid face
"""
ACCOUNTED = 1e-8


class InAndOut(SlimBedTest):
    def prepared(self, name, insertion, ranks=1, low=0, high="${height}", settings="", split="1 1 $numberOfSubdomains",
                 endTime="0.005", writeInterval="0.001"):
        target = self.scene(name, ranks, [("system/decomposeParDict", r"n \(.*?\)", f"n ({split})"),
                                          ("constant/couplingProperties", r"^kernelWidth", "bedInterval 1;\nkernelWidth")],
                            l="2.5", width="0.01", height="0.02", cellsWidth="8", cellsHeight="16", maxDeltaT="2.5e-5",
                            endTime=endTime, writeInterval=writeInterval)
        (target / "DEM/in.bed").write_text(HEAD.format(insertion=insertion, low=low, high=high, settings=settings))
        (target / "DEM/face.stl").write_text(FACE)
        return target

    def solved(self, target, ranks=1):
        """@return rows of bed.csv, after the checks that hold for every run"""
        code, log = self.solve(target, ranks)
        self.assertEqual(code, 0, log[-2000:])
        self.assertIn("particle motion   on", log)
        bed = results.bed(target)
        print(f"{target.name}: up to {bed['particles'].max():.0f} particles, {bed['particles'][-1]:.0f} at the end; carried "
              f"{bed['carried_J'][-1]:.3g} J, not accounted for {np.abs(bed['budget_error']).max():.1e} of the exchange")
        self.assertLess(np.abs(bed["budget_error"]).max(), ACCOUNTED)
        self.assertLess(bed["mismatch"].max(), 1e-13)
        return bed

    def bounded(self, bed, highest=T0):
        self.assertGreaterEqual(bed["gas_T_min_K"].min(), 293.15 - 1e-9)
        self.assertLessEqual(bed["gas_T_max_K"].max(), highest + 1e-9)

    def test_from_none_to_none(self):
        for more, temperature in (("start 45", T0), ("start 45 set_property Temp 400", 400.0)):
            with self.subTest(temperature):
                bed = self.solved(self.prepared(f"region{temperature:.0f}", REGION.format(more=more)))
                self.bounded(bed, temperature)
                count = bed["particles"]
                self.assertEqual(count[-1], 0, "all must have left")
                self.assertGreater(count.max(), 20)
                empty = count == 0
                self.assertEqual(list(empty[:5]), [True] * 4 + [False], "the first come in the fifth gas step")
                for column in ("T_mean_K", "T_min_K", "T_max_K", "Nu_mean"):
                    self.assertTrue(np.isnan(bed[column][empty]).all(), "a mean over nothing stays empty")
                self.assertFalse(np.isnan(bed["T_mean_K"][~empty]).any())
                # what entered is known as long as nothing has left: particles of the temperature of insertion
                first = np.flatnonzero(~empty)[0]
                self.assertEqual(bed["T_max_K"][first], temperature)
                self.assertEqual(bed["T_min_K"][first], temperature)
                # at the end only the heat that they gave to the gas is left
                self.assertEqual(bed["particle_energy_J"][-1], 0.0)
                self.assertGreater(bed["carried_J"][-1], 0.0, "they left colder than they came")

    def test_momentum_is_accounted_for(self):
        # pressure and velocity solved for until they agree: what is left is not the splitting's
        target = self.prepared("momentum", REGION.format(more=""), endTime="0.0025")
        edit(target / "system/fvSolution", r"nOuterCorrectors +1", "nOuterCorrectors 20")
        edit(target / "system/fvSolution", r"relTol +0\.01", "relTol 1e-6")
        bed = self.solved(target)
        self.assertLess((bed["particles"][1:] - bed["particles"][:-1]).min(), 0, "some must have left")
        print(f"momentum not accounted for: {bed['momentum_error'].max():.1e} of the impulse")
        self.assertLess(bed["momentum_error"].max(), 1e-7)

    def test_removal_by_a_fix(self):
        # everything that passes a plane in the middle of the column is deleted
        plane = ("\nfix face all mesh/surface/planar file DEM/face.stl type 1\n"
                 "fix out all massflow/mesh mesh face vec_side 0 0 1 count once delete_atoms yes")
        target = self.prepared("removal", REGION.format(more="") + plane, settings="atom_modify map array")
        (target / "DEM/face.stl").write_text(
            FACE.replace("0.0225", "0.015").replace("0.002 ", "0 ").replace("0.008 ", "0.01 "))
        bed = self.solved(target)
        self.assertEqual(bed["particles"][-1], 0)
        self.assertLess(bed["particles"].max(), 40, "without the plane there are 46 at once")

    def test_what_came_in_is_the_energy_of_the_new_particles(self):
        target = self.prepared("pack", PACK, endTime="0.001")
        bed = self.solved(target)
        self.bounded(bed)
        rows = np.loadtxt(target / "DEM/post/particles400.txt", skiprows=9)
        kinds = rows[:, 1].astype(int)
        for kind in (1, 2):
            mass = DENSITY[kind] * np.pi / 6 * DIAMETER[kind] ** 3
            np.testing.assert_allclose(rows[kinds == kind, 5], mass, rtol=1e-12)
        energy = np.sum(rows[:, 5] * np.where(kinds == 1, C_P[1], C_P[2])) * T0
        self.assertEqual(len(rows), bed["particles"][-1])
        self.assertLess(abs(bed["carried_J"][-1] / energy - 1), 1e-12)

    def test_stream_from_outside_the_mesh_through_it(self):
        for ranks in (1, 2):
            target = self.prepared(f"stream{ranks}", STREAM, ranks, low=-0.004, high=0.028, endTime="0.006")
            bed = self.solved(target, ranks)
            self.bounded(bed)
            self.assertEqual(bed["particles"][-1], 0, "all must have left")
            outside = 0
            for step in (400, 800, 1200):
                rows = np.atleast_2d(np.loadtxt(target / f"DEM/post/particles{step}.txt", skiprows=9))
                above = rows[rows[:, 4] > 0.02 + 8 * 2.5e-5]  # not yet in the mesh at the start of the gas step
                outside += len(above)
                np.testing.assert_array_equal(above[:, 6], T0)
                inside = rows[(rows[:, 4] < 0.018) & (rows[:, 4] > 0)]
                self.assertTrue((inside[:, 6] < T0).all(), "hot particles in the mesh lose heat")
            self.assertGreater(outside, 0)

    def test_new_particles_start_clean(self):
        # dumped in the step of the last insertion, in places of the arrays that others have left
        fresh = "dump fresh all custom 1001 DEM/post/fresh*.txt id f_Temp f_Nusselt " + " ".join(
            [f"f_gasForce[{n}]" for n in range(1, 4)] + [f"f_gasAlone[{n}]" for n in range(1, 5)])
        target = self.prepared("fresh", REGION.format(more="") + f"\n{fresh}\ndump_modify fresh sort id", endTime="0.003")
        self.solved(target)
        rows = np.loadtxt(target / "DEM/post/fresh1001.txt", skiprows=9)
        self.assertLess(len(rows), 60, "some must have left before")
        new, old = rows[rows[:, 0] > 50], rows[rows[:, 0] <= 50]
        self.assertEqual(len(new), 10)
        np.testing.assert_array_equal(new[:, 1:], [[T0] + [0.0] * 8] * 10)
        self.assertTrue((old[:, 2] > 0).all() and (old[:, 9] == 1 / 2.5e-5).all())

    def test_new_particles_do_not_wait_for_closures(self):
        # slow ones, so that others still answer as they did in an earlier gas step
        target = self.prepared("wait", REGION.format(more="").replace("0 0 8 region", "0 0 0.2 region") +
                               "\ndump fresh all custom 215 DEM/post/fresh*.txt id f_Nusselt\ndump_modify fresh sort id", endTime="0.003")
        edit(target / "constant/couplingProperties", r"^kernelWidth", "closureCo 1;\nkernelWidth")
        self.solved(target)
        self.assertLess(results.evaluated((target / "log.hotbedFoam").read_text()), 0.7)
        # inserted in DEM step 201; the gas step in between begins at 210
        rows = np.loadtxt(target / "DEM/post/fresh215.txt", skiprows=9)
        self.assertGreater(rows[:, 0].max(), 10)
        self.assertTrue((rows[:, 1] > 0).all())

    def test_ranks_without_particles(self):
        for split, grid in (("1 1 4", "processors 1 1 4"), ("2 2 1", "processors 2 2 1")):
            bed = self.solved(self.prepared(f"ranks{grid[-5]}", REGION.format(more=""), 4, settings=grid, split=split,
                                            endTime="0.003"), 4)
            self.bounded(bed)

    def resumed(self, whole, name, ranks=1):
        """@return bed.csv of a run that goes on from 0.001 s on"""
        target = self.folder / name
        shutil.copytree(whole, target)
        for place in (target, target / "restart"):
            for folder in place.iterdir():
                if re.fullmatch(r"0\.\d+", folder.name) and folder.name != "0.001":
                    shutil.rmtree(folder)
        if ranks > 1:
            run.tool(target, "decomposePar", "-latestTime")
        return self.solved(target, ranks)

    def test_goes_on_from_a_restart(self):
        whole = self.prepared("whole", REGION.format(more=""), endTime="0.004")
        expected = self.solved(whole)
        for ranks in (1, 2):
            bed = self.resumed(whole, f"goes_on{ranks}", ranks)
            self.assertEqual(len(bed), len(expected))
            # LIGGGHTS puts as many and as heavy particles in as without a stop, at other random places
            self.assertEqual(self.inserted(self.folder / f"goes_on{ranks}"), self.inserted(whole))
            first = 40  # step after the restart, with particles inserted in it
            self.assertEqual(bed["particles"][first], expected["particles"][first])
            self.assertLess(abs(bed["carried_J"][first] / expected["carried_J"][first] - 1), 1e-12)

    def inserted(self, target):
        """What LIGGGHTS says of all it has inserted."""
        return re.findall(r"a total of .*", (target / "log.liggghts").read_text())[-1]

    def test_goes_on_with_particles_outside_the_mesh(self):
        whole = self.prepared("whole", STREAM, low=-0.004, high=0.028, endTime="0.002")
        self.solved(whole)
        rows = np.loadtxt(whole / "DEM/post/particles400.txt", skiprows=9)
        self.assertTrue((rows[:, 4] > 0.02).any())
        self.resumed(whole, "goes_on")

    def test_goes_on_from_an_empty_domain(self):
        whole = self.prepared("whole", REGION.format(more="start 445"), endTime="0.002")
        expected = self.solved(whole)
        self.assertEqual(expected["particles"][39], 0)
        bed = self.resumed(whole, "goes_on")
        np.testing.assert_array_equal(bed["particles"], expected["particles"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
