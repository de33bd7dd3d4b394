"""`hotbed new`: cases from random sensible numbers pass `hotbed check`, with nothing to advise on stability, and run."""

import math
import random
import subprocess
import sys
import unittest

import numpy as np

from scenes import CoupledTest, run
import check
import new

G, R = 9.81, 8.314462618


def minimum_fluidisation(diameter, density, gas_density, viscosity):
    """Wen and Yu (1966) [m/s]."""
    archimedes = gas_density * (density - gas_density) * G * diameter**3 / viscosity**2
    return (math.sqrt(33.7**2 + 0.0408 * archimedes) - 33.7) * viscosity / (gas_density * diameter)


def numbers(dice):
    """A bed of some hundred coarse particles that bubbles."""
    def between(low, high):
        return math.exp(dice.uniform(math.log(low), math.log(high)))

    diameter, density, ratio, inlet = between(1e-4, 3e-3), between(400, 8000), dice.choice([1, 1.5, 2, 2.5, 3]), dice.uniform(280, 500)
    coarse = ratio * diameter
    static = dice.uniform(4, 10) * coarse
    u_mf = minimum_fluidisation(diameter, density, 101325 * 0.0285 / (R * inlet), 1.7e-5 * (inlet / 273) ** 0.7)
    return {"size": [dice.uniform(6, 15) * coarse, dice.uniform(4, 8) * coarse, 5 * static], "diameter": diameter, "density": density,
            "static-height": static, "gas": dice.choice(["air", "nitrogen"]), "u0": dice.uniform(1.5, 4) * u_mf, "l": ratio,
            "temperature": dice.uniform(280, 1100), "inlet-temperature": inlet, "heat-capacity": between(300, 2000),
            "restitution": dice.uniform(0.5, 0.99), "friction": dice.uniform(0, 0.6)}


def words(values):
    return [text for name, value in values.items()
            for text in (f"--{name}", *map(str, value if isinstance(value, list) else [value]))]


def rounded(values):
    """Numbers as one types them."""
    return {name: [float(f"{v:.4g}") for v in value] if isinstance(value, list) else value if isinstance(value, str)
            else float(f"{value:.4g}") for name, value in values.items()}


class New(CoupledTest):
    def make(self, name, **values):
        case = self.folder / name
        done = subprocess.run([sys.executable, new.__file__, str(case), *words(values)], capture_output=True, text=True)
        return case, done

    def test_ten_random_beds_pass_the_check_and_run_a_hundred_steps(self):
        dice = random.Random(20)
        for n in range(10):
            values = rounded(numbers(dice))
            with self.subTest(n, **values):
                case, done = self.make(f"bed{n}", **values)
                self.assertEqual(done.returncode, 0, done.stderr)
                facts, control, peak, refused = check.measure(case, {}, 1, 0.2)
                rows = {row.name: row for row in check.rows(facts, control, peak, refused, 1)}
                for name, row in rows.items():
                    self.assertNotEqual(row.level, check.REFUSED, row)
                    if "stiffness" not in name and name != "column":  # these beds are narrow
                        self.assertNotEqual(row.level, check.ADVICE, row)
                wanted = values["static-height"] * 0.6 * facts["section"] / (math.pi / 6 * (values["l"] * values["diameter"])**3)
                self.assertAlmostEqual(facts["particles"], wanted, delta=0.51)
                self.assertAlmostEqual(facts["u0"] / values["u0"], 1, delta=1e-6)

                target = self.folder / f"run{n}"
                end = 100 * float(control["maxDeltaT"])  # the first steps are shorter
                run.prepare(case, target, {"endTime": f"{end:.9g}", "writeInterval": f"{end:.9g}"})
                code, log = self.solve(target)
                self.assertEqual(code, 0, log[-2000:])
                self.assertGreaterEqual(log.count("\nTime = "), 100)
                bed = np.genfromtxt(next(target.glob("postProcessing/hotbed/*/bed.csv")), delimiter=",", names=True)
                self.assertTrue((bed["particles"] == facts["particles"]).all())
                self.assertLess(bed["overlap_max"].max(), 0.02)
                low, high = sorted([values["temperature"], values["inlet-temperature"]])
                self.assertGreater(min(bed["T_min_K"].min(), bed["gas_T_min_K"].min()), low * (1 - 1e-9))
                self.assertLess(max(bed["T_max_K"].max(), bed["gas_T_max_K"].max()), high * (1 + 1e-9))

    def test_the_ratio_that_is_chosen(self):
        def ratio(**values):
            options = new.parser().parse_args(["bed", "--u0", "0.2", *words(values)])
            return new.design(options)["l"]

        for size, l in (([0.02, 0.01, 0.1], 1.5), ([0.04, 0.025, 0.2], 3), ([0.2, 0.005, 0.2], 1), ([0.2, 0.01, 0.2], 2.5),
                        ([0.2, 0.004, 0.2], 1)):  # the last three: no fewer than eight particles across, if the original has them
            with self.subTest(size):
                self.assertEqual(ratio(size=size), l)

    def test_what_does_not_go_together_is_refused(self):
        for values, text in (({"l": 10}, "set --l to at most 6.67"), ({"static-height": 0.09}, "greater height"),
                             ({"solids": 1e-12}, "less than one coarse particle"), ({"diameter": 0}, "must be a number >= 1e-12"),
                             ({"gas": "helium"}, "invalid choice"), ({"restitution": 1.2}, "must be a number >= 1e-12, <= 1,"),
                             ({"friction": "nan"}, "must be a number >= 0,")):
            with self.subTest(text):
                case, done = self.make("bad", u0=0.2, **values)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn(text, done.stderr)
                self.assertFalse(case.exists())
        case, _ = self.make("twice", u0=0.2)
        self.assertIn("exists already", self.make("twice", u0=0.2)[1].stderr)

    def test_viscosity_is_that_of_tables(self):
        # Lemmon & Jacobsen (2004), at 300 K and atmospheric pressure: nitrogen 17.9, air 18.5 uPa s; air at 800 K 37.0
        self.assertAlmostEqual(new.viscosity("nitrogen", 300), 17.9e-6, delta=0.2e-6)
        self.assertAlmostEqual(new.viscosity("air", 300), 18.5e-6, delta=0.2e-6)
        self.assertAlmostEqual(new.viscosity("air", 800), 37.0e-6, delta=0.8e-6)


if __name__ == "__main__":
    unittest.main()
