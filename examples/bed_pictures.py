"""Pictures of runs of a fluidised bed, for the plot.py of the cases: plot.py RUN [RUN ...].

particles_temperature.png  particles near the centre plane at several times, by temperature (Figs 2-4 of the paper)
particles_nusselt.png      the same by Nusselt number (Figs 8-10)
temperature.png            mean temperature in time, its PDF and axial profile at several times (Figs 5-7)
nusselt.png                mean Nusselt number in time and its PDF (Fig 12); of several runs its mean over `l` (Fig 11)
bed.png                    pressure drop, bed height and largest overlap in time

One run: in its folder. Several runs, of any `l` and `u0`: together, in the folder above the first one.
"""

import re
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from PIL import Image

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / folder) for folder in ("validation", "cfd_solver")]
import results
from paraview import read_dump
from run import read_settings

STYLES = ["-", "--", "-.", ":", (0, (1, 1, 4, 1)), (0, (6, 3))]
# even to the colour-blind, and without the yellow that is lost on white
WARMTH = ListedColormap(plt.cm.plasma(np.linspace(0, 0.87, 256)))
TEMPERATURE, NUSSELT = ("f_Temp", "particle temperature [K]", WARMTH), ("f_Nusselt", "Nusselt number", "viridis")


class Run:
    """A run's settings, bed.csv and dumps; a dump is read when it is asked for, and kept."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.setting = read_settings(self.folder / "settings")
        self.l, self.u0 = float(self.setting["l"]), float(self.setting["u0"])
        self.height = float(self.setting["height"])
        if "radius" in self.setting:  # a cylinder about the z axis; that of the gas is a prism
            radius, sides = float(self.setting["radius"]), 4 * int(self.setting["cellsCore"])
            self.low, self.width, self.middle = -radius, 2 * radius, 0.0
            self.area = sides / 2 * np.sin(2 * np.pi / sides) * radius**2
        else:
            self.low, self.width, depth = 0.0, float(self.setting["width"]), float(self.setting["depth"])
            self.middle, self.area = depth / 2, self.width * depth
        self.bed = results.bed(self.folder)
        step = float(self.setting["deltaTDEM"])
        self.dumps = {round(int(p.stem[9:]) * step, 9): p for p in self.folder.glob("DEM/post/particles*.txt")}
        self.read = {}

    def particles(self, time):
        if time not in self.read:
            self.read[time] = read_dump(self.dumps[time])
        return self.read[time]

    def layers(self):
        """Edges of layers two cells high [m]."""
        return np.linspace(0, self.height, int(self.setting["cellsHeight"]) // 2 + 1)

    def weight(self):
        """Weight of the particles over the cross-section [Pa]."""
        script = dict(zip(("diameter", "density"), re.search(
            r"(?m)^fix\s+\S+\s+all\s+hotbed/coarsegrain.*diameter\s+(\S+)\s+density\s+(\S+)",
            (self.folder / "DEM/in.bed").read_text()).groups()))
        diameter, density = (float(self.setting.get(name, script[name])) for name in script)
        g = re.search(r"value\s*\(([^)]*)\)", (self.folder / "constant/g").read_text())[1]
        solids = self.bed["particles"][0] * np.pi / 6 * (self.l * diameter)**3
        return solids * density * np.linalg.norm([float(x) for x in g.split()]) / self.area


def times_to_show(runs, count):
    """Those of the paper where all runs have them, else `count` times evenly up to the last that all have."""
    common = sorted(set.intersection(*(set(r.dumps) for r in runs)))
    if not common:
        sys.exit("these runs have no dump of the particles at a common time")
    if common[-1] > 0:
        common = [t for t in common if t > 0]
    paper = [t for t in (5.0, 15.0, 25.0) if t in common]
    if len(paper) > 1:
        return paper
    return sorted({min(common, key=lambda t: abs(t - common[-1] * k / count)) for k in range(1, count + 1)})


def after_start(run):
    """From when on means in time are taken: 2.5 s as in the paper, in a short run a fifth of it."""
    return min(2.5, 0.2 * run.bed["time_s"][-1])


def top_of(runs, times):
    """Height of pictures that show all but a few particles of the runs [m]."""
    return min(max(r.height for r in runs), 1.1 * max(np.percentile(r.particles(t)["z"], 99.9) for r in runs for t in times))


def cut(axis, run, time, top, column, **look):
    """Particles near the centre plane as circles of their size, coloured by a column of the dump."""
    p = run.particles(time)
    away = np.abs(p["y"] - run.middle)
    near = np.flatnonzero(away < 2 * p["radius"])
    near = near[np.argsort(-away[near])]  # the nearest on top
    size = 2e3 * p["radius"][near]
    circles = axis.add_collection(EllipseCollection(
        size, size, np.zeros(len(near)), units="xy", array=p[column][near], offsets=1e3 * np.c_[p["x"], p["z"]][near],
        offset_transform=axis.transData, linewidths=0, **look))
    axis.set_aspect("equal")
    axis.set_xlim(1e3 * run.low, 1e3 * (run.low + run.width))
    axis.set_ylim(0, 1e3 * top)
    axis.xaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
    return circles


def colouring(runs, times, quantity):
    """Colours of a quantity for `cut`, the same for all runs and times: all but the outermost hundredths differ in colour.
    @return (look, what Figure.colorbar is told)"""
    column, label, cmap = quantity
    values = np.concatenate([r.particles(t)[column] for r in runs for t in times])
    low, high = np.percentile(values, [1, 99])
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    return (dict(column=column, cmap=cmap, clim=(low, high)),
            dict(label=label, aspect=25, extend=extend[values.min() < low, values.max() > high]))


def configurations(runs, times, quantity):
    """Particles near the centre plane: a row a run, a column a time."""
    look, bar = colouring(runs, times, quantity)
    top = top_of(runs, times)
    wide = 1.9
    tall = wide * top / max(r.width for r in runs)
    figure, axes = plt.subplots(len(runs), len(times), squeeze=False, sharex=True, sharey=True, layout="compressed",
                                figsize=(wide * len(times) + 1.6, (tall + 0.4) * len(runs) + 0.7))
    for run, row in zip(runs, axes):
        for axis, time in zip(row, times):
            circles = cut(axis, run, time, top, **look)
            axis.set_title(f"{time:g} s", fontsize=10)
    for axis in axes[-1]:
        axis.set_xlabel("x [mm]")
    for run, axis in zip(runs, axes[:, 0]):
        axis.set_ylabel("height [mm]")
        if len(runs) > 1:
            axis.set_title(f"$l$ = {run.l:g}, $u_0$ = {run.u0:g} m/s\n{times[0]:g} s", fontsize=10, loc="left")
            axis.set_title("")
    figure.colorbar(circles, ax=axes, shrink=0.8 if len(runs) == 1 else 0.5, **bar)
    return figure


def pdf(axis, values, **look):
    """Probability density, over the range that holds all but the farthest two thousandths on either side."""
    low, high = np.percentile(values, [0.2, 99.8])
    edge = 0.05 * (high - low)
    density, edges = np.histogram(values, bins=80, range=(low - edge, high + edge), density=True)
    axis.plot((edges[1:] + edges[:-1]) / 2, density, **look)


def profile(axis, run, particles, **look):
    """Mean temperature of layers of the bed."""
    edges = run.layers()
    mean, count = results.layer_means(particles["z"], particles["f_Temp"], edges)
    filled = count >= 5
    axis.plot(1e3 * (edges[1:] + edges[:-1])[filled] / 2, mean[filled], **look)


def groups(runs):
    """[(u0, its runs)]"""
    return [(u0, [r for r in runs if r.u0 == u0]) for u0 in sorted({r.u0 for r in runs})]


def panels(rows, columns):
    figure, axes = plt.subplots(rows, columns, squeeze=False, sharex="col", sharey="col", layout="constrained",
                                figsize=(4.2 * columns, 3.5 * rows + 0.5))
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.08)
    return figure, axes


def explain(axis, looks, **place):
    """A legend of lines: label -> colour and style."""
    axis.legend(handles=[Line2D([], [], label=label, **look) for label, look in looks.items()], frameon=False, **place)


def title(figure, runs):
    """What all runs have in common; line styles tell the rest."""
    common = [f"${name}$ = {values.pop():g}{unit}" for name, values, unit in
              (("l", {r.l for r in runs}, ""), ("u_0", {r.u0 for r in runs}, " m/s")) if len(values) == 1]
    figure.suptitle(", ".join(common), fontsize=11)


def ratios(axis, style, **place):
    """Legend of the line styles, where there is more than one."""
    if len(style) > 1:
        explain(axis, {f"$l$ = {l:g}": dict(color="0.2", ls=s) for l, s in style.items()}, **place)


def temperature(runs, times, style):
    rows = groups(runs)
    figure, axes = panels(len(rows), 3)
    colour = dict(zip(times, plt.cm.viridis(np.linspace(0, 0.8, len(times)))))
    for (u0, members), (mean, density, axial) in zip(rows, axes):
        for run in members:
            mean.plot(run.bed["time_s"], run.bed["T_mean_K"], color="k", ls=style[run.l])
            for t in times:
                look = dict(color=colour[t], ls=style[run.l])
                pdf(density, run.particles(t)["f_Temp"], **look)
                profile(axial, run, run.particles(t), **look)
        mean.set(xlabel="time [s]", ylabel="mean particle temperature [K]")
        density.set(xlabel="particle temperature [K]", ylabel="PDF [1/K]", ylim=(0, None))
        axial.set(xlabel="height [mm]", ylabel="particle temperature [K]")
        if len(rows) > 1:
            mean.set_title(f"$u_0$ = {u0:g} m/s", fontsize=10)
    explain(axes[0, 1], {f"{t:g} s": dict(color=c) for t, c in colour.items()})
    ratios(axes[0, 0], style)
    title(figure, runs)
    return figure


def nusselt(runs, style):
    rows = groups(runs)
    figure, axes = panels(1, 3 if len(runs) > 1 else 2)
    series, density = axes[0, :2]
    colours = dict(zip([u0 for u0, _ in rows], plt.cm.plasma(np.linspace(0, 0.75, len(rows)))))
    for u0, members in rows:
        means = []
        for run in members:
            look = dict(color=colours[u0], ls=style[run.l])
            t, Nu, start = run.bed["time_s"], run.bed["Nu_mean"], after_start(run)
            series.plot(t[t >= start], Nu[t >= start], lw=1, **look)
            late = [time for time in run.dumps if time >= start] or [max(run.dumps)]
            pdf(density, np.concatenate([read_dump(run.dumps[time])["f_Nusselt"] for time in late]), **look)
            means.append(Nu[t >= start].mean())
        if len(runs) > 1:
            axes[0, 2].plot([r.l for r in members], means, "o-", color=colours[u0], label=f"$u_0$ = {u0:g} m/s")
    series.set(xlabel="time [s]", ylabel="mean Nusselt number")
    density.set(xlabel="Nusselt number", ylabel=f"PDF, from {after_start(runs[0]):g} s on", ylim=(0, None))
    if len(runs) > 1:
        axes[0, 2].set(xlabel="coarse-graining ratio $l$", ylabel=f"mean Nusselt number, from {after_start(runs[0]):g} s on")
        low, high = axes[0, 2].get_ylim()
        axes[0, 2].set(xticks=list(style), ylim=(0.97 * low, 1.03 * high))
        if len(rows) > 1:
            axes[0, 2].legend(frameon=False)
    ratios(density, style)
    title(figure, runs)
    return figure


def bed(runs, style):
    rows = groups(runs)
    figure, axes = panels(1, 3)
    drop, height, overlap = axes[0]
    colours = dict(zip([u0 for u0, _ in rows], plt.cm.plasma(np.linspace(0, 0.75, len(rows)))))
    values = np.concatenate([r.bed["pressure_drop_Pa"] for r in runs])
    for u0, members in rows:
        for run in members:
            look = dict(color=colours[u0], ls=style[run.l], lw=0.9)
            t = run.bed["time_s"]
            drop.plot(t, run.bed["pressure_drop_Pa"], **look)
            height.plot(t, 1e3 * run.bed["height_m"], **look)
            spans = np.array_split(np.arange(len(t)), min(100, len(t)))  # it jumps: the largest of each hundredth
            overlap.plot([t[s].mean() for s in spans], [100 * run.bed["overlap_max"][s].max() for s in spans], **look)
    weight = runs[0].weight()
    drop.axhline(weight, color="0.4", lw=1, label="weight of the bed")
    drop.legend(frameon=False, loc="lower right")
    low, high = np.percentile(values, [2, 98])  # without the kick of the start
    drop.set(xlabel="time [s]", ylabel="pressure drop [Pa]", ylim=(min(0, low), 1.2 * max(high, weight)))
    height.set(xlabel="time [s]", ylabel="bed height [mm]", ylim=(0, None))
    overlap.set(xlabel="time [s]", ylabel="largest overlap [% of a diameter]")
    overlap.set_ylim(0, 1.25 * overlap.get_ylim()[1])
    ratios(overlap, style, loc="upper left", ncols=2)
    title(figure, runs)
    if len(rows) > 1:
        explain(height, {f"$u_0$ = {u0:g} m/s": dict(color=c) for u0, c in colours.items()}, loc="lower right")
    return figure


def save(figure, path, dpi=150):
    """Writes a picture with a palette of 256 colours, a third of the size, and closes it."""
    figure.savefig(path, dpi=dpi, bbox_inches="tight")
    plt.close(figure)
    Image.open(path).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    runs = sorted((Run(folder) for folder in sys.argv[1:]), key=lambda r: (r.u0, r.l))
    place = Path(sys.argv[1]) if len(runs) == 1 else Path(sys.argv[1]).parent
    few, many = times_to_show(runs, 3), times_to_show(runs, 4)
    style = dict(zip(sorted({r.l for r in runs}), STYLES))
    pictures = {"particles_temperature": configurations(runs, many, TEMPERATURE),
                "particles_nusselt": configurations(runs, many, NUSSELT),
                "temperature": temperature(runs, few, style), "nusselt": nusselt(runs, style), "bed": bed(runs, style)}
    for name, figure in pictures.items():
        if name.startswith("particles") and len(runs) == 1:
            title(figure, runs)
        for axis in figure.axes:
            if name in ("temperature", "nusselt", "bed"):
                axis.grid(alpha=0.25)
        save(figure, place / f"{name}.png")
    print(f"pictures: {place}/{{{','.join(pictures)}}}.png")
