#!/usr/bin/python3
"""One-dimensional study of the fixed bed behind docs/theory.md: how the heat exchange over a step and the reading of the
gas temperature change the error. Table 1 of the paper at 400 cells; a mean difference to the exact solution at 12 s a row.

    /usr/bin/python3 validation/studies/exchange_1d.py

Exchange: `effective` reproduces a closed gas-particle pair, `plain` takes h A with the end of the step, `linear` is what
Hotbed does. Reading: `mean` of the cells that the kernel covers, or at the `place` of the particle.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.linalg import solve_banded
from scipy.sparse import csr_matrix

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import schumann as bed

HEIGHT, CELLS, WIDTH, END = 0.6, 400, 0.015, 12.0


def kernel_mass(x):
    """Deen's kernel below x (in half widths)."""
    x = np.clip(x, -1, 1)
    return 0.5 + 15 / 16 * (x - 2 / 3 * x**3 + x**5 / 5)


def van_leer(T, inlet):
    """Face values, from the inlet face on."""
    padded = np.concatenate([[2 * inlet - T[0]], T, [T[-1]]])
    step = np.diff(padded)
    ratio = np.divide(step[:-1], step[1:], out=np.zeros(len(T)), where=step[1:] != 0)
    limiter = (ratio + np.abs(ratio)) / (1 + np.abs(ratio))
    face = np.empty(len(T) + 1)
    face[0], face[1:] = inlet, T + 0.5 * limiter * step[1:]
    face[-1] = T[-1]
    return face


def error(l, courant, exchange, reading):
    """Mean difference of the gas to the exact solution at END, per unit cross-section."""
    dz = HEIGHT / CELLS
    faces, centre = np.linspace(0, HEIGHT, CELLS + 1), (np.arange(CELLS) + 0.5) * dz
    volume = np.pi / 6 * (l * bed.DIAMETER) ** 3
    across = round(WIDTH / (volume / (1 - bed.VOIDAGE)) ** (1 / 3))
    layers = round(HEIGHT * WIDTH**2 * (1 - bed.VOIDAGE) / volume / across**2)
    z = (np.arange(layers) + 0.5) * HEIGHT / layers
    half = 1.5 * l * bed.DIAMETER
    W = kernel_mass((faces[None, 1:] - z[:, None]) / half) - kernel_mass((faces[None, :-1] - z[:, None]) / half)
    W = csr_matrix(W / W.sum(1, keepdims=True))

    dt = courant * dz * bed.VOIDAGE / bed.SUPERFICIAL
    ha = bed.nusselt() * bed.CONDUCTIVITY / bed.DIAMETER * 6 * (1 - bed.VOIDAGE) / bed.DIAMETER
    H = ha * HEIGHT / layers * dt
    mc = (1 - bed.VOIDAGE) * bed.PARTICLE_DENSITY * bed.PARTICLE_HEAT * HEIGHT / layers
    C = bed.VOIDAGE * bed.GAS_DENSITY * bed.GAS_HEAT * dz
    flow = bed.GAS_DENSITY * bed.GAS_HEAT * bed.SUPERFICIAL * dt
    one = np.ones(layers)
    b = H / mc
    gain, early = -np.expm1(-b), -np.expm1(-b) / b - np.exp(-b)
    if exchange == "plain":
        give, first, passes = H * one, 0 * one, 1
    elif exchange == "effective":
        a = W @ (W.T @ (H * one) / C)
        phi = -np.expm1(-(a + b)) / (a + b)
        give, first, passes = H * phi / (1 - a * phi), 0 * one, 1
    else:
        give, first, passes = mc * gain * one, mc * early * one, 2
    G, X, middle = W.T @ give, W.T @ first, (W.T @ (give * z)) / (W.T @ give)

    T, Tp = np.zeros(CELLS), np.zeros(layers)
    before = van_leer(T, 1.0)
    for _ in range(round(END / dt)):
        matrix = np.zeros((3, CELLS))
        matrix[1], matrix[2, :-1] = C + G - X + flow, -flow
        source = (C - X) * T + W.T @ (give * Tp)
        source[0] += flow
        new = solve_banded((1, 1), matrix, source)
        used = np.concatenate([[1.0], new])
        for _ in range(passes):
            wanted = van_leer(new, 1.0)
            if exchange == "linear":
                wanted = 0.5 * (wanted + before)
            new = new - flow * np.diff(wanted - used) / (C + G - X)
            used = wanted
        before = van_leer(new, 1.0)
        gradient = np.gradient(new, dz) if reading == "place" else np.zeros(CELLS)
        read = W @ (new - gradient * middle) + (W @ gradient) * z
        Tp = Tp + (give * (read - Tp) + first * (W @ (T - new))) / mc
        T = new
    return np.abs(T - bed.solution(centre, round(END / dt) * dt)[0]).mean()


def main():
    print("  l   Courant   exchange    reading   mean difference to exact")
    for l in (1, 1.5, 2, 2.5):
        print(f"{l:5} {0.4:8}   effective   mean      {error(l, 0.4, 'effective', 'mean'):.2e}", flush=True)
    for l in (1, 2.5):
        for exchange in ("effective", "plain", "linear"):
            print(f"{l:5} {0.4:8}   {exchange:9s}   place     {error(l, 0.4, exchange, 'place'):.2e}", flush=True)
    for courant in (0.8, 0.2):
        for exchange in ("effective", "plain", "linear"):
            print(f"{1:5} {courant:8}   {exchange:9s}   place     {error(1, courant, exchange, 'place'):.2e}", flush=True)


if __name__ == "__main__":
    main()
