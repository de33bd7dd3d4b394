"""The contact law against closed forms and an independent integration: restitution head-on, rebound angle and spin over
all angles of impact, Coulomb's limit, independence of `l`. `./hotbed validate contact [--quick]`.

Runs examples/two_balls in the unmodified `liggghts` with the library preloaded; --quick takes fewer angles and ratios.
"""

import argparse
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
SCRIPT = ROOT / "examples" / "two_balls" / "in.two_balls"
LIBRARY = Path(os.environ.get("HOTBED_BUILD", ROOT / "build")) / "liggghts_fixes" / "libhotbed_liggghts.so"
import results

DIAMETER, DENSITY, KN, EN, ET = 5e-4, 1040.0, 500.0, 0.74, 0.1
STEPS, STEP = 4000, 2.5e-8


def constants(mass):
    """k_t, eta_n, eta_t of the original particle for an effective mass, written out here (Deen et al. 2007)."""
    n, t = np.log(EN), np.log(ET)
    kt = 2 / 7 * KN * (np.pi**2 + t**2) / (np.pi**2 + n**2)
    return (kt, -2 * n * np.sqrt(mass * KN / (np.pi**2 + n**2)),
            -2 * t * np.sqrt(2 / 7 * mass * kt / (np.pi**2 + t**2)))


def liggghts(folder, **variables):
    """Runs the example. @return (velocity and spin [balls, 6], contact forces [n, 6])"""
    run = folder / ",".join(f"{k}={v}" for k, v in variables.items())
    run.mkdir(parents=True, exist_ok=True)
    command = ["liggghts", "-in", str(SCRIPT), "-log", "none"]
    for name, value in {**variables, "steps": STEPS}.items():
        command += ["-var", name, f"{value}"]
    done = subprocess.run(command, cwd=run, capture_output=True, text=True, errors="replace",
                          env=dict(os.environ, LD_PRELOAD=str(LIBRARY)))
    if done.returncode:
        sys.exit(f"liggghts failed in {run}:\n{done.stdout[-2000:]}")
    balls = np.atleast_2d(np.loadtxt(run / f"balls{STEPS}.txt", skiprows=9))
    forces = [line.split()[2:8] for line in (run / "contacts.txt").read_text().splitlines()
              if len(line.split()) == 8 and line[0].isdigit()]
    return balls, np.array(forces, float).reshape(-1, 6)


def impact(angle, speed, friction, l=1.0, step=2e-9):
    """Independent integration of eq 18-20 for two equal balls in their plane, with l^3-scaled constants and the mass and
    inertia of the coarse balls: velocity Verlet, 12 times finer than the runs. @return (v1x, v1y, v2x, v2y, w1, w2)"""
    cube, d = l**3, l * DIAMETER
    m = DENSITY * np.pi / 6 * d**3
    inertia = 0.1 * m * d * d
    kt, etan, etat = (cube * c for c in constants(m / cube / 2))
    kn = cube * KN
    x, y = [d, 0.0], [0.0, 0.0]
    vx, vy = [-speed * np.cos(angle), 0.0], [speed * np.sin(angle), 0.0]
    w = [0.0, 0.0]
    spring = 0.0  # along the tangent, which turns with the balls
    force = (0.0, 0.0, 0.0)
    for n in range(int(STEPS * STEP / step)):
        for i, sign in ((0, 1.0), (1, -1.0)):
            vx[i] += 0.5 * step * sign * force[0] / m
            vy[i] += 0.5 * step * sign * force[1] / m
            w[i] += 0.5 * step * force[2] / inertia
            x[i] += step * vx[i]
            y[i] += step * vy[i]
        dx, dy = x[0] - x[1], y[0] - y[1]
        r = (dx * dx + dy * dy) ** 0.5
        overlap = d - r
        if overlap <= 0.0:
            force = (0.0, 0.0, 0.0)
            spring = 0.0
            if n * step > 1e-5:
                break
        else:
            nx, ny = dx / r, dy / r
            tx, ty = -ny, nx
            ux, uy = vx[0] - vx[1], vy[0] - vy[1]
            vn = ux * nx + uy * ny
            arm = d / 2 - overlap / 2
            vt = ux * tx + uy * ty - arm * (w[0] + w[1])
            fn = kn * overlap - etan * vn
            spring += vt * step
            ft = -kt * spring - etat * vt
            limit = friction * abs(fn)
            if abs(ft) > limit:
                ft = np.sign(ft) * limit
                spring = -(ft + etat * vt) / kt
            force = (fn * nx + ft * tx, fn * ny + ft * ty, -arm * ft)
        for i, sign in ((0, 1.0), (1, -1.0)):
            vx[i] += 0.5 * step * sign * force[0] / m
            vy[i] += 0.5 * step * sign * force[1] / m
            w[i] += 0.5 * step * force[2] / inertia
    return vx[0], vy[0], vx[1], vy[1], w[0], w[1]


def surface(balls, l):
    """Velocity of the two surfaces against each other along the plane of contact, after the impact [m/s]."""
    return balls[0, 1] - balls[1, 1] - l * DIAMETER / 2 * (balls[0, 5] + balls[1, 5])


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate contact", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer angles and ratios")
    options = parser.parse_args()
    figures = results.Figures("contact")
    folder = (Path("results") / "contact" / ("validate-quick" if options.quick else "validate")).resolve()
    ratios = (1, 2.5) if options.quick else (1, 1.5, 2, 2.5, 5)
    angles = (10, 45, 80) if options.quick else (5, 15, 25, 35, 45, 55, 65, 75, 85)

    restitution = {}
    for l in ratios:
        for wall in (0, 1):
            balls, _ = liggghts(folder, l=l, wall=wall, dt=STEP)
            restitution[l, wall] = (balls[0, 0] - (0 if wall else balls[1, 0])) / 0.1
            figures.add(f"l = {l}, {'wall' if wall else 'two balls'}: restitution against {EN}, relative",
                        abs(restitution[l, wall] / EN - 1), 1e-3, f"{restitution[l, wall]:.6f}")
    for wall in (0, 1):
        values = [restitution[l, wall] for l in ratios]
        figures.add(f"{'wall' if wall else 'two balls'}: restitution, spread over l", max(values) - min(values), 1e-6)

    with ThreadPoolExecutor(2) as pool:
        friction = 0.1
        runs = dict(zip(angles, pool.map(lambda a: liggghts(folder, l=1, angle=a, dt=STEP, friction=friction), angles)))
        for angle, (balls, forces) in runs.items():
            v1x, v1y, v2x, v2y, w1, w2 = impact(np.radians(angle), 0.1, friction)
            rebound = np.degrees(np.arctan2(balls[0, 1] - balls[1, 1], balls[0, 0] - balls[1, 0]))
            expected = np.degrees(np.arctan2(v1y - v2y, v1x - v2x))
            figures.add(f"{angle} degrees: rebound angle against the fine integration, relative",
                        abs(rebound / expected - 1), 1e-2, f"{rebound:.3f} degrees")
            figures.add(f"{angle} degrees: spin against the fine integration, relative",
                        abs(balls[0, 5] / w1 - 1), 1e-2, f"{balls[0, 5]:.3f} 1/s")
            normal = np.linalg.norm(forces[:, :3], axis=1)
            tangential = np.linalg.norm(forces[:, 3:], axis=1)
            figures.add(f"{angle} degrees: largest tangential over mu times normal force, less 1",
                        np.max(tangential / (friction * normal)) - 1, 1e-5)
        # gentle, so that overlap and turning are nothing against the diameter: what is left is the scaling itself
        for angle in angles:
            gentle = {l: liggghts(folder, l=l, angle=angle, dt=STEP, friction=friction, speed=1e-5)[0] for l in ratios}
            values = [surface(balls, l) / 1e-5 for l, balls in gentle.items()]
            figures.add(f"{angle} degrees: surface velocity after impact, spread over l, of the speed",
                        max(values) - min(values), 1e-6)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
