"""The exact solution used in the validation, against the values of the model description and the Bessel integral."""

import sys
import unittest
from pathlib import Path

import numpy as np
from scipy.integrate import quad
from scipy.special import ive

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import schumann


class Schumann(unittest.TestCase):
    def test_reference_values(self):
        for (xi, tau), expected in {(1, 1): (0.654254, 0.345746), (2, 5): (0.913934, 0.831431),
                                    (5, 2): (0.168569, 0.086066), (10, 10): (0.544890, 0.455110)}.items():
            gas, particle = schumann.theta(xi, tau)
            np.testing.assert_allclose([gas[0], particle[0]], expected, atol=5e-7)

    def test_bessel_integral(self):
        # theta_gas = 1 - int_0^xi e^-(tau + x) I0(2 sqrt(tau x)) dx; with ive(0, y) = e^-y I0(y) nothing overflows
        for xi, tau in ((0.5, 3.0), (4.0, 4.0), (20.0, 15.0)):
            integrand = lambda x: np.exp(-((np.sqrt(tau) - np.sqrt(x)) ** 2)) * ive(0, 2 * np.sqrt(tau * x))
            expected = 1 - quad(integrand, 0, xi, limit=200)[0]
            self.assertAlmostEqual(schumann.theta(xi, tau)[0][0], expected, places=7)

    def test_nusselt_of_table_1(self):
        self.assertAlmostEqual(schumann.nusselt(), 67.74, places=2)

    def test_nothing_ahead_of_the_gas(self):
        gas, particle = schumann.solution([0.59], 0.5)
        self.assertEqual((gas[0], particle[0]), (0.0, 0.0))


if __name__ == "__main__":
    unittest.main(verbosity=2)
