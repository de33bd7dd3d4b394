#!/usr/bin/python3
"""Pictures of a bed run: plot.py RUN.

particles.png  particles near the centre plane at the last time, coloured by temperature and by Nusselt number (Figs 2-4
               and 8-10 of the paper)
bed.png        mean temperature with its least and largest value, pressure drop and mean Nusselt number in time; PDFs of
               temperature and Nusselt number at the last time (Figs 5, 6, 11, 12)
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
from run import read_settings


def dump(path):
    """A LIGGGHTS text dump. @return dict of columns"""
    lines = Path(path).read_text().splitlines()
    columns = lines[8].split()[2:]
    values = np.array([line.split() for line in lines[9:]], float).reshape(-1, len(columns))
    return dict(zip(columns, values.T))


def temperature_and_nusselt(axes, particles, setting):
    """Particles near the centre plane, as circles of their size."""
    radius = particles["radius"]
    middle = float(setting["depth"]) / 2
    near = np.abs(particles["y"] - middle) < 2 * radius
    for axis, column, label in zip(axes, ("f_Temp", "f_Nusselt"), ("temperature [K]", "Nusselt number")):
        circles = matplotlib.collections.EllipseCollection(
            2e3 * radius[near], 2e3 * radius[near], np.zeros(near.sum()), units="xy",
            offsets=np.c_[particles["x"][near], particles["z"][near]] * 1e3, offset_transform=axis.transData,
            array=particles[column][near], cmap="inferno" if column == "f_Temp" else "viridis")
        values = particles[column]
        circles.set_clim(np.percentile(values, 0.5), np.percentile(values, 99.5))
        axis.add_collection(circles)
        axis.set_aspect("equal")
        axis.set_xlim(0, 1e3 * float(setting["width"]))
        axis.set_ylim(0, 1e3 * min(float(setting["height"]), 1.15 * particles["z"].max()))
        axis.set_xlabel("x [mm]")
        plt.colorbar(circles, ax=axis, label=label, shrink=0.85)
    axes[0].set_ylabel("height [mm]")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    run = Path(sys.argv[1])
    setting = read_settings(run / "settings")
    last = max(run.glob("DEM/post/particles*.txt"), key=lambda p: int(p.stem[9:]))
    time = int(last.stem[9:]) * float(setting["deltaTDEM"])
    particles = dump(last)
    title = f"l = {setting['l']}, u0 = {setting['u0']} m/s"

    figure, axes = plt.subplots(1, 2, figsize=(8, 5.2), constrained_layout=True)
    temperature_and_nusselt(axes, particles, setting)
    figure.suptitle(f"{title}, {time:g} s")
    figure.savefig(run / "particles.png", dpi=150)

    bed = results.bed(run)
    figure, axes = plt.subplots(2, 3, figsize=(11, 6), constrained_layout=True)
    t = bed["time_s"]
    axes[0, 0].fill_between(t, bed["T_min_K"], bed["T_max_K"], alpha=0.2, label="least to largest")
    axes[0, 0].plot(t, bed["T_mean_K"], label="mean")
    axes[0, 0].legend(frameon=False)
    axes[0, 0].set_ylabel("particle temperature [K]")
    weight = float(setting["solids"]) * 1040 * 9.81 / (float(setting["width"]) * float(setting["depth"]))
    axes[0, 1].plot(t, bed["pressure_drop_Pa"], lw=0.8)
    axes[0, 1].axhline(weight, color="k", ls="--", lw=1, label="weight of the bed")
    low, high = np.percentile(bed["pressure_drop_Pa"], [2, 98])  # without the kick of the start
    axes[0, 1].set_ylim(min(0, low), 1.2 * max(high, weight))
    axes[0, 1].legend(frameon=False)
    axes[0, 1].set_ylabel("pressure drop [Pa]")
    axes[0, 2].plot(t, bed["Nu_mean"])
    axes[0, 2].set_ylim(0, 1.5 * np.percentile(bed["Nu_mean"], 98))
    axes[0, 2].set_ylabel("mean Nusselt number")
    for axis in axes[0]:
        axis.set_xlabel("time [s]")
    axes[1, 0].hist(particles["f_Temp"], bins=60, density=True, histtype="step")
    axes[1, 0].set_xlabel("particle temperature [K]")
    axes[1, 1].hist(particles["f_Nusselt"], bins=60, density=True, histtype="step")
    axes[1, 1].set_xlabel("Nusselt number")
    for axis in axes[1, :2]:
        axis.set_ylabel(f"PDF at {time:g} s")
    bins = np.linspace(0, particles["z"].max(), 25)
    layer = np.digitize(particles["z"], bins)
    filled = [k for k in range(1, len(bins) + 1) if np.any(layer == k)]
    axes[1, 2].plot([particles["f_Temp"][layer == k].mean() for k in filled],
                    [1e3 * particles["z"][layer == k].mean() for k in filled], "o-", ms=3)
    axes[1, 2].set_xlabel(f"temperature at {time:g} s [K]")
    axes[1, 2].set_ylabel("height [mm]")
    for axis in axes.flat:
        axis.grid(alpha=0.25)
    figure.suptitle(title)
    figure.savefig(run / "bed.png", dpi=150)
    print(f"pictures: {run}/particles.png, {run}/bed.png")


if __name__ == "__main__":
    main()
