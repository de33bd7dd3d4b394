#!/usr/bin/python3
"""Writes closures_reference.csv: drag and heat laws, k_eff and the contact formulas from the paper's equations in 50-digit
arithmetic (package python3-mpmath), independent of closures.cpp. Columns: function, three arguments, value."""

import csv
from pathlib import Path

from mpmath import log, mp, mpf, pi, sqrt

mp.dps = 50


def beetstra(e, re, _):
    re, e = mpf(re), mpf(e)
    first = 10 * (1 - e) / e**2 + e**2 * (1 + mpf("1.5") * sqrt(1 - e))
    if re == 0:
        return first
    top = 1 / e + 3 * e * (1 - e) + mpf("8.4") * re ** mpf("-0.343")
    bottom = 1 + 10 ** (3 * (1 - e)) * re ** (-mpf("0.5") - 2 * (1 - e))
    return first + mpf("0.413") * re / (24 * e**2) * top / bottom


def ergun_wen_yu(e, re, _):
    """K d^2 / (18 mu e (1 - e)), K in SI units with d = mu = rho = 1, so that slip = re / e"""
    e, u = mpf(e), mpf(re) / mpf(e)
    if e < mpf("0.8"):
        K = 150 * (1 - e) ** 2 / e + mpf("1.75") * (1 - e) * u
    else:
        re = mpf(re)
        # Cd re / 24, which has a limit for re -> 0
        cd_re = 24 * (1 + mpf("0.15") * re ** mpf("0.687")) if re < 1000 else mpf("0.44") * re
        K = mpf("0.75") * cd_re / e * e * (1 - e) * e ** mpf("-2.65")
    return K / (18 * e * (1 - e))


def gunn(e, re, pr):
    e, re, pr = mpf(e), mpf(re), mpf(pr)
    third = pr ** (mpf(1) / 3)
    return (7 - 10 * e + 5 * e**2) * (1 + mpf("0.7") * re ** mpf("0.2") * third) + (
        mpf("1.33") - mpf("2.40") * e + mpf("1.20") * e**2
    ) * re ** mpf("0.7") * third


def effective_conductivity(e, _, __):
    e = mpf(e)
    return (1 - sqrt(1 - e)) / e


def dashpot(e, k, m):
    e, k, m = mpf(e), mpf(k), mpf(m)
    return -2 * log(e) * sqrt(m * k) / sqrt(pi**2 + log(e) ** 2)


def tangential_stiffness(k, en, et):
    k, en, et = mpf(k), mpf(en), mpf(et)
    return mpf(2) / 7 * k * (pi**2 + log(et) ** 2) / (pi**2 + log(en) ** 2)


# by their names in couplingProperties
DRAG = {"Beetstra": beetstra, "ErgunWenYu": ergun_wen_yu}
HEAT = {"Gunn": gunn}
rows = []
for e in ("0.2", "0.35", "0.4", "0.55", "0.8", "0.99", "1"):
    rows.append(("effectiveConductivity", e, "0", "0", effective_conductivity(e, 0, 0)))
    for re in ("0", "1e-12", "1e-3", "0.5", "7", "120", "812.5", "1e5"):
        for name, law in DRAG.items():
            if e != "1" or name != "ErgunWenYu":  # which is K over 1 - e here
                rows.append((name, e, re, "0", law(e, re, 0)))
        for name, law in HEAT.items():
            for pr in ("1e-2", "0.72", "7", "1000"):
                rows.append((name, e, re, pr, law(e, re, pr)))
mass = mpf(1040) * pi / 6 * mpf("5e-4") ** 3
for e in ("1e-3", "0.1", "0.74", "0.97", "1"):
    for k in ("1", "500", "1e6"):
        rows.append(("dashpot", e, k, mp.nstr(mass, 20), dashpot(e, k, mp.nstr(mass, 20))))
        for et in ("0.1", "0.5", "1"):
            rows.append(("tangentialStiffness", k, e, et, tangential_stiffness(k, e, et)))

with open(Path(__file__).with_name("closures_reference.csv"), "w", newline="") as file:
    writer = csv.writer(file, lineterminator="\n")
    for function, a, b, c, value in rows:
        writer.writerow([function, a, b, c, mp.nstr(value, 20)])
