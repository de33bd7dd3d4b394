#!/usr/bin/python3
"""Draws gas and particle temperature against height like Fig 1 of the paper: plot.py RUN [RUN ...].

Exact solution as lines, every run as symbols. With one run of a results folder its neighbours of the same column are
drawn too, so that each `l` shows. Writes temperature.png and temperature.svg into the folder above the first run.
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "validation"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "cfd_solver"))
import results
import schumann
from run import read_settings

COLD, HOT = 293.0, 393.0


def profiles(run):
    """(times, z_gas, {t: theta_gas}, {t: (z, theta_particle)}) of a run: cross-section means."""
    setting = read_settings(Path(run) / "settings")
    rows = int(setting["cellsHeight"])
    z = (np.arange(rows) + 0.5) * float(setting["height"]) / rows
    layers = results.layers(Path(run) / "DEM/post/layers.txt")
    times = sorted(float(p.name) for p in Path(run).iterdir() if p.name.replace(".", "", 1).isdigit() and p.name != "0")
    gas, particle = {}, {}
    for t in times:
        T = results.field(Path(run) / f"{t:g}" / "T").reshape(rows, -1)
        gas[t] = (T.mean(axis=1) - COLD) / (HOT - COLD)
        step = round(t / float(setting["deltaT"]))
        profile = layers[min(layers, key=lambda s: abs(s - step))]
        particle[t] = profile[:, 0], (profile[:, 2] - COLD) / (HOT - COLD)
    return times, z, gas, particle


def draw(runs, path):
    """One panel for the gas, one for the particles. @param runs l -> run folder"""
    figure, panels = plt.subplots(2, 1, figsize=(7.2, 7.2), sharex=True, constrained_layout=True)
    marker = dict(zip(sorted(runs, key=float), "os^Dv<>"))
    height = 0.0
    for l, run in sorted(runs.items(), key=lambda item: float(item[0])):
        times, z, gas, particle = profiles(run)
        height = max(height, z[-1] + z[0])
        color = dict(zip(times, plt.cm.viridis(np.linspace(0.05, 0.85, len(times)))))
        for t in times:
            for panel, (zt, theta) in zip(panels, ((z, gas[t]), particle[t])):
                # about 16 symbols over the front, each l shifted so that none hides another
                front = np.flatnonzero((theta > 0.003) & (theta < 0.997))
                every = max(1, len(front) // 16)
                some = front[(list(marker).index(l) * every // max(1, len(runs)))::every]
                panel.plot(zt[some], theta[some], marker[l], color=color[t], mfc="none", ms=5.5, mew=1.1)
    fine = np.linspace(0, height, 600)
    for t in times:
        for panel, theta in zip(panels, schumann.solution(fine, t)):
            panel.plot(fine, theta, "-", color=color[t], lw=1.4, label=f"{t:g} s, exact")
    for l in marker:
        panels[0].plot([], [], marker[l], color="0.3", mfc="none", label=f"l = {l}")
    panels[0].set_ylabel("gas, $(T_g - T_0)/(T_{in} - T_0)$")
    panels[1].set_ylabel("particles, $(T_p - T_0)/(T_{in} - T_0)$")
    panels[1].set_xlabel("height [m]")
    panels[0].legend(fontsize=9, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    for panel in panels:
        panel.set_xlim(0, height)
        panel.set_ylim(-0.03, 1.03)
        panel.grid(alpha=0.25)
    for suffix in (".png", ".svg"):
        figure.savefig(Path(path).with_suffix(suffix), dpi=150)
    plt.close(figure)


def main():
    runs = [Path(a) for a in sys.argv[1:]]
    if not runs:
        sys.exit(__doc__)
    if len(runs) == 1:
        def column(run):
            setting = read_settings(run / "settings")
            return {k: v for k, v in setting.items() if k != "l"}

        mine = column(runs[0])
        runs += [r for r in sorted(runs[0].parent.iterdir())
                 if (r / "settings").is_file() and r.resolve() != runs[0].resolve() and column(r) == mine
                 and (r / "DEM/post/layers.txt").is_file()]
    chosen = {}
    for run in runs:
        chosen.setdefault(read_settings(run / "settings")["l"], run)
    path = runs[0].parent / "temperature.png"
    draw(chosen, path)
    print(f"picture: {path}")


if __name__ == "__main__":
    main()
