"""Exact solution of the one-dimensional fixed bed, paper eq 23-25 (Schumann 1929), and the numbers of Table 1.

With xi = h a z / (rho_g c_g u_0), tau = h a (t - z eps / u_0) / ((1 - eps) rho_p c_p) and independent Poisson variables
X of mean xi and Y of mean tau: theta_gas = P(X <= Y), theta_particle = P(X < Y). This equals the Bessel-integral form
of Bird, Stewart & Lightfoot, and does not overflow.
"""

import numpy as np
from scipy.stats import poisson

# Table 1; the paper gives neither voidage nor viscosity
VOIDAGE, VISCOSITY = 0.4, 1.8e-5
DIAMETER, SUPERFICIAL = 4.875e-4, 0.1
GAS_DENSITY, GAS_HEAT, CONDUCTIVITY = 300.0, 1000.0, 0.025
PARTICLE_DENSITY, PARTICLE_HEAT = 800.0, 1500.0


def nusselt():
    """Gunn's correlation (eq 9) for Table 1, written out here so that the comparison does not use Hotbed's own."""
    prandtl = VISCOSITY * GAS_HEAT / CONDUCTIVITY
    reynolds = GAS_DENSITY * SUPERFICIAL * DIAMETER / VISCOSITY  # eq 6: voidage times interstitial velocity
    e = VOIDAGE
    return (7 - 10 * e + 5 * e**2) * (1 + 0.7 * reynolds**0.2 * prandtl ** (1 / 3)) + (
        1.33 - 2.40 * e + 1.20 * e**2
    ) * reynolds**0.7 * prandtl ** (1 / 3)


def solution(z, t):
    """Dimensionless gas and particle temperature at heights z [m] at time t [s]; arrays of the shape of z."""
    z = np.atleast_1d(np.asarray(z, float))
    ha = nusselt() * CONDUCTIVITY / DIAMETER * 6 * (1 - VOIDAGE) / DIAMETER
    xi = ha * z / (GAS_DENSITY * GAS_HEAT * SUPERFICIAL)
    tau = ha * (t - z * VOIDAGE / SUPERFICIAL) / ((1 - VOIDAGE) * PARTICLE_DENSITY * PARTICLE_HEAT)
    return theta(xi, tau)


def theta(xi, tau):
    """(theta_gas, theta_particle) for arrays xi >= 0 and tau; both 0 ahead of the gas that came in (tau < 0)."""
    xi, tau = np.broadcast_arrays(np.atleast_1d(xi), np.atleast_1d(tau))
    gas, particle = np.zeros(xi.shape), np.zeros(xi.shape)
    for n in np.ndindex(xi.shape):
        if tau[n] < 0:
            continue
        spread = 40 + 12 * np.sqrt(tau[n])
        k = np.arange(max(0, int(tau[n] - spread)), int(tau[n] + spread) + 1)
        weight = poisson.pmf(k, tau[n])
        gas[n] = weight @ poisson.cdf(k, xi[n])
        particle[n] = weight @ poisson.cdf(k - 1, xi[n])
    return gas, particle
