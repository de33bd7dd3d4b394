"""`hotbed check`: examples are green and run; what it calls refused the solver refuses, and what it says instead works."""

import math
import re
import subprocess
import sys
import unittest

from scenes import CoupledTest, ROOT, SLIM_BED, copy, edit
import check
import check_rows
from test_in_and_out import HEAD, PACK, REGION

EXAMPLES = ROOT / "examples"
SMALL = {"l": 2.5, "width": 0.01, "depth": 0.005, "height": 0.03, "cellsWidth": 8, "cellsDepth": 4, "cellsHeight": 24, "solids": 2.75e-7}


def table(case, ranks=1, seconds=0.2, **settings):
    """@return (facts, rows by name)"""
    facts, control, peak, refused = check.measure(case, {k: str(v) for k, v in settings.items()}, ranks, seconds)
    return facts, {row.name: row for row in check.rows(facts, control, peak, refused, ranks)}


class Check(CoupledTest):
    example = SLIM_BED

    def refused(self, rows):
        return {name for name, row in rows.items() if row.level == check.REFUSED}

    def test_examples_are_green_and_their_first_steps_run(self):
        for case in ("slim_bed", "fixed_bed", "settling_particle", "cylinder_bed", "fluidized_bed"):
            with self.subTest(case):
                facts, rows = table(EXAMPLES / case)
                self.assertEqual(self.refused(rows), set(), rows)
                self.assertGreaterEqual(facts["steps"][3] / facts["demStep"], 10)
                self.assertIn("the case is set up", rows["solver"].text)

    def test_shares_of_the_ranks(self):
        settings = {"width": 0.02, "depth": 0.01, "solids": 1.6e-6}
        _, rows = table(SLIM_BED, ranks=2, **{**SMALL, **settings})
        self.assertEqual(rows["shares"].level, check.OK)
        case = self.folder / "case"
        copy(SLIM_BED, case)
        edit(case / "DEM/in.bed", r"^(region\s+layers block 0) \$\{width\}", r"\1 0.01")
        _, rows = table(case, ranks=2, **{**SMALL, **settings})
        self.assertEqual(rows["shares"].level, check.ADVICE)
        self.assertRegex(rows["shares"].text, r"particles has (1\.[89]\d*|2) times the mean, that with most cells 1 times")
        self.assertNotIn("shares", table(case, **{**SMALL, **settings})[1])

    def test_facts_are_those_of_table_2(self):
        # contact time 26.0 us, mass 6.807e-8 kg, weight over the cross-section, packing as many particles as there are
        facts, rows = table(SLIM_BED, ranks=2)
        self.assertEqual(facts["particles"], 6000)
        contact = facts["contact"]
        self.assertAlmostEqual(contact[2] * facts["demStep"], 26.0e-6, delta=0.1e-6)
        self.assertAlmostEqual(facts["mass"] / 48000 / 6.807e-8, 1, delta=1e-3)
        self.assertAlmostEqual(float(re.match(r"\S+", rows["pressure drop"].text)[0]), 3.14159265e-6 * 1040 * 9.81 / 2e-4, delta=0.5)
        self.assertAlmostEqual(facts["u0"], 0.2, delta=1e-9)
        # Stokes-like relaxation of the particles and the gas' share: their masses are as their times
        gas_mass = facts["gas"][0] * facts["voidage"][0] / (1 - facts["voidage"][0]) * facts["solids"]
        self.assertAlmostEqual(facts["dragTime"][0] / facts["dragTime"][1] / (facts["mass"] / gas_mass), 1, delta=1e-6)

    def test_stiff_contacts_are_refused_and_the_step_it_names_works(self):
        facts, rows = table(SLIM_BED, **SMALL, kn=50000)
        self.assertEqual(self.refused(rows), {"contact time 1-1", "solver"})
        step = float(re.search(r"DEM step to at most (\S+) s", rows["contact time 1-1"].text)[1])
        share = float(re.search(r"kn to at most (\S+) times", rows["contact time 1-1"].text)[1])
        for mend in ({"kn": 50000, "deltaTDEM": 0.99 * step, "deltaT": 9.9 * step}, {"kn": 0.99 * share * 50000}):
            _, rows = table(SLIM_BED, **{**SMALL, **mend})
            self.assertEqual(self.refused(rows), set(), rows)
            self.assertEqual(rows["contact time 1-1"].level, check.ADVICE, "stable, but not good")

    def test_a_gas_step_of_broken_dem_steps_is_refused_and_the_one_it_names_works(self):
        _, rows = table(SLIM_BED, **SMALL, deltaT=1.1e-5)
        self.assertEqual(self.refused(rows), {"gas step", "solver"})
        wanted = re.search(r"whole number of them, (\S+) s", rows["gas step"].text)[1]
        self.assertEqual(self.refused(table(SLIM_BED, **SMALL, deltaT=wanted)[1]), set())

    def test_what_only_the_solver_knows_is_refused_with_its_words(self):
        _, rows = table(SLIM_BED, **{**SMALL, "cellsWidth": 32, "cellsDepth": 16, "cellsHeight": 96}, windowLength=3e-4)
        self.assertEqual(self.refused(rows), {"solver"})
        self.assertIn("too narrow for the cells", rows["solver"].text)
        case = self.folder / "case"
        copy(SLIM_BED, case)
        edit(case / "constant/couplingProperties", r"^drag .*", "drag Bestra;")
        self.assertIn("drag must be one of", table(case)[1]["solver"].text)

    def test_several_types_and_an_empty_domain(self):
        case = self.folder / "case"
        copy(SLIM_BED, case)
        rows = {}
        for name, insertion, end in (("empty", REGION.format(more=""), ""), ("filled", PACK, "run 1\n")):
            (case / "DEM/in.bed").write_text(HEAD.format(insertion=insertion, low=0, high="${height}", settings="") + end)
            _, rows[name] = table(case, **{**SMALL, "depth": 0.01, "cellsDepth": 8})
            self.assertEqual(self.refused(rows[name]), set(), rows[name])
        self.assertIn("no particles yet", rows["empty"]["contact time"].text)
        pairs = {name for name in rows["filled"] if name.startswith("contact time")}
        self.assertEqual(pairs, {"contact time 1-1", "contact time 1-2", "contact time 2-2"})

    def test_contacts_of_another_model(self):
        case = self.folder / "case"
        copy(SLIM_BED, case)
        edit(case / "DEM/in.bed", r"gran model hotbed tangential hotbed", "gran model hertz tangential history")
        edit(case / "DEM/in.bed", r"^fix +m1 .*", "fix m1 all property/global youngsModulus peratomtype 5e6\n"
             "fix m0 all property/global poissonsRatio peratomtype 0.3")
        for l in ("1", "2.5"):
            _, rows = table(case, **{**SMALL, "l": l})
            self.assertEqual(rows["contact time"].level, check.ADVICE)
            self.assertEqual("nothing scales them" in rows["contact time"].text, l != "1")
            self.assertIn("contacts", rows["on"].text)
            self.assertNotIn("friction", rows["on"].text + rows["left out"].text)

    def test_gravity_of_gas_and_particles(self):
        for name, own in (("hotbed", "nve/sphere/hotbed gravity 9.81 vector 0 0 -1"),
                          ("stock", "nve/sphere\nfix g all gravity 9.81 vector 0 0 -2")):
            case = self.folder / name
            copy(SLIM_BED, case)
            edit(case / "DEM/in.bed", r"nve/sphere/hotbed gravity .*", own)
            self.assertNotIn("gravity", table(case, **SMALL)[1])
            edit(case / "constant/g", r"-9\.81", "9.81")
            self.assertIn("are 19.6 m/s2 apart", table(case, **SMALL)[1]["gravity"].text)
        target = self.scene(edits=[("constant/g", r"-9\.81", "0")], **{**SMALL, "endTime": 1e-4})
        code, log = self.solve(target)
        self.assertEqual(code, 0)
        self.assertRegex(log, r"gravity is \(0 0 0\) m/s2 in constant/g but \(0 0 -9.81\d*\) for the particles")

    def test_advice(self):
        def advised(**settings):
            return {name for name, row in table(SLIM_BED, **{**SMALL, **settings})[1].items() if row.level == check.ADVICE}

        self.assertEqual(advised(), {"column"})  # 4 particles across
        self.assertEqual(advised(l=1), set())
        self.assertEqual(advised(u0=0.02), {"fluidisation"})
        self.assertEqual(advised(u0=3), {"fluidisation"})
        self.assertEqual(advised(maxCo=4), {"gas step", "column"})
        self.assertEqual(advised(cellsWidth=16), {"cells", "column"})
        self.assertEqual(advised(kernelWidth=5), {"kernel", "column"})

    def test_room_for_coarse_particles(self):
        for l, level in ((2.5, check.OK), (4, check.ADVICE)):
            row = table(SLIM_BED, l=l)[1]["column"]  # 10 mm deep
            self.assertEqual(row.level, level, row)
            self.assertIn(f"10 mm across, {20 / l:g} coarse particles", row.text)
        self.assertIn("set l to at most 2.5,", row.text)

    def test_the_command(self):
        def command(case, *words):
            done = subprocess.run([sys.executable, check.__file__, str(case), "--seconds", "0.1", *words], capture_output=True, text=True)
            return done.returncode, done.stdout + done.stderr

        small = [f"{k}={v}" for k, v in SMALL.items()]
        code, text = command(SLIM_BED, "--set", *small)
        self.assertEqual(code, 0, text)
        self.assertNotIn("\033", text)
        self.assertRegex(text, r"(?m)^ok +contact time")
        code, text = command(SLIM_BED, "--set", *small, "kn=50000")
        self.assertEqual(code, 1, text)
        self.assertRegex(text, r"(?m)^refused +contact time")
        code, text = command(EXAMPLES / "two_balls")
        self.assertEqual(code, 1)
        self.assertIn("has no gas", text)
        self.assertIn("no setting 'knn'", command(SLIM_BED, "--set", "knn=1")[1])

    def test_time_is_that_of_the_steps_left(self):
        # a bed that has settled and costs what it did: steps of the whole run at the measured cost
        facts = check.Facts("fact steps 50 5000 0.01 0.02\nfact cost 1 2 0.5\nfact demStep 2e-6\nfact moving 0\nfact particles 10\nfact u0 1\n")
        control = {"endTime": "1", "startTime": "0", "deltaT": "2e-4", "adjustTimeStep": None, "maxCo": None, "maxDeltaT": None}
        seconds, gas, dem = check_rows.wall_time(facts, control)
        self.assertTrue(math.isclose(gas, 5000) and math.isclose(dem, 500000))
        self.assertTrue(math.isclose(seconds, 1 + 5000 * 1 / 50 + 500000 * 1 / 5000))

    def test_time_of_a_bed_that_has_not_settled(self):
        # bed 0.04905 m high: falls in 0.1 s; until then as measured, with the Courant number seen, then as a bubbling bed of so many
        # particles on a rank
        text = ("fact steps 50 5000 0.01 0.02\nfact cost 1 2 0.5\nfact demStep 2e-6\nfact moving 1\nfact particles {}\nfact u0 0.2\n"
                "fact voidage 0.5 0.4\nfact cell 1e-3 1e-3\nfact solids 2.4525e-5\nfact section 1e-3\nfact courantRate 100\n")
        control = {"endTime": "1", "startTime": "0", "deltaT": "2e-5", "adjustTimeStep": "yes", "maxCo": "0.8", "maxDeltaT": "1e-3"}
        for particles, ranks, dearer in ((6000, 1, 1.4), (100, 1, 1.4), (46000, 1, 1.8), (92000, 2, 1.8), (10**6, 1, 1.8)):
            facts = check.Facts(text.format(particles))
            self.assertFalse(check_rows.settled(facts))
            seconds, gas, dem = check_rows.wall_time(facts, control, ranks)
            self.assertAlmostEqual(gas, 0.1 / 1e-3 + 0.9 / 2e-4, delta=1)
            self.assertAlmostEqual(seconds, 1 + gas / 50 + 500000 / 5000 * (0.1 + 0.9 * dearer), delta=0.01)
        few, middle, many = (check_rows.dearer(n) for n in (6000, 16613, 46000))
        self.assertAlmostEqual(middle, (few + many) / 2, delta=1e-4)
        row = [r.text for r in check_rows.cost(facts, control, None, 1) if r.name == "time"][0]
        self.assertIn("with --seconds 41 it will have", row)


if __name__ == "__main__":
    unittest.main()
