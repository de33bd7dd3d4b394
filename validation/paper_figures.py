"""The paper's figures 2 to 12 drawn from our campaign: FOLDER/NAME_fig*.png, NAME that of the tables.

From the runs, where they are there: particles near the centre plane by temperature (Figs 2-4) and by Nusselt number (8-10).
From the tables of paper_tables.py: all others. Repeats of a run are lines of the same colour, or their mean with a band or bar.
"""

from pathlib import Path

import numpy as np

from campaign import bar, spread
from paper_tables import Table, mean_density
from bed_pictures import NUSSELT, TEMPERATURE, colouring, cut, plt, save, top_of


def shades(ratios):
    """Colour of each coarse-graining ratio, dark to light."""
    return dict(zip(ratios, plt.cm.viridis(np.linspace(0, 0.87, len(ratios)))))


def widths(l, ratios):
    """The finest below all others, wide enough to be seen beside them."""
    return dict(lw=2.6 if l == ratios[0] else 1.3, zorder=2 if l == ratios[0] else 3)


def panels(rows, columns, high=2.9, **shared):
    return plt.subplots(rows, columns, squeeze=False, layout="constrained",
                        figsize=(9.2 if columns > 1 else 5.6, high * rows + 0.5), **shared)


def legend(figure, handles):
    """Below the panels."""
    figure.legend(handles=handles, loc="lower center", ncols=len(handles), frameon=False)
    room = 0.3 / figure.get_figheight()
    figure.get_layout_engine().set(rect=(0, room, 1, 1 - room))


def ratio_lines(colour):
    return [plt.Line2D([], [], color=c, lw=widths(l, list(colour))["lw"], label=f"$l$ = {l:g}") for l, c in colour.items()]


def configurations(runs, times, quantity):
    """A row a time, a column for the finest ratio and for `l` = 2 (else the coarsest) at each velocity."""
    first = {}  # of the repeats of a run, as far as they are there
    for (l, u0, _), run in runs.items():
        first.setdefault((float(l), float(u0)), run)
    ratios = sorted({l for l, _ in first})
    pair = [ratios[0], 2.0 if 2.0 in ratios[1:] else ratios[-1]]
    columns = [(l, u0) for u0 in sorted({u0 for _, u0 in first}) for l in dict.fromkeys(pair) if (l, u0) in first]
    shown = [first[c] for c in columns]
    look, colours = colouring(shown, times, quantity)
    top = top_of(shown, times)
    wide = min(8.2 / len(columns), 2.1)
    figure, axes = plt.subplots(len(times), len(columns), squeeze=False, sharex=True, sharey=True, layout="compressed",
                                figsize=(wide * len(columns) + 1, (wide * top / shown[0].width + 0.35) * len(times) + 0.5))
    for row, time in zip(axes, times):
        for axis, run, (l, u0) in zip(row, shown, columns):
            circles = cut(axis, run, time, top, **look)
            axis.set_title((f"$u_0$ = {u0:g} m/s\n" if time == times[0] else "") + f"$l$ = {l:g}, {time:g} s", fontsize=9)
        row[0].set_ylabel("height [mm]")
    for axis in axes[-1]:
        axis.set_xlabel("x [mm]")
    figure.colorbar(circles, ax=axes, shrink=0.6, **colours)
    return figure


def cooling(stem):
    """Fig 5, and below it what the figure itself does not show: the difference to the finest ratio."""
    table = Table(stem)
    columns = len(table.velocities)
    figure = plt.figure(figsize=(9.2, 6.4), layout="constrained")
    grid = figure.add_gridspec(2, columns, height_ratios=(3, 2))
    course, below = figure.add_subplot(grid[0, :]), None
    colour = shades(table.ratios())
    for n, u0 in enumerate(table.velocities):
        below = figure.add_subplot(grid[1, n], sharey=below)
        ratios = table.ratios(u0)
        groups = {l: np.array([r["T_mean_K"] for r in table.repeats(u0, l)]) for l in ratios}
        time = table.repeats(u0, ratios[0])[0]["time_s"]
        reference = groups[ratios[0]].mean(axis=0)
        for l, group in groups.items():
            course.plot(time, group.mean(axis=0), color=colour[l], **widths(l, ratios))
            for repeat in group:
                below.plot(time, repeat - reference, color=colour[l], lw=1.6 if l == ratios[0] else 1)
        course.annotate(f" {u0:g} m/s", (time[-1], reference[-1]), va="center")
        below.set_title(f"$u_0$ = {u0:g} m/s", fontsize=10)
        below.set_xlabel("time [s]")
        if n == 0:
            below.set_ylabel("difference to the finest $l$ [K]")
        else:
            below.tick_params(labelleft=False)
    course.set(xlabel="time [s]", ylabel="mean particle temperature [K]", xlim=(0, 1.1 * time[-1]))
    legend(figure, ratio_lines(colour))
    return figure


def at_times(table, x, y, labels, scale="linear", **shared):
    """A row a time, a column a velocity, a line a run."""
    times = table.times()
    figure, axes = panels(len(times), len(table.velocities), 2.6, sharey="row", **shared)
    colour = shades(table.ratios())
    for row, time in zip(axes, times):
        for axis, u0 in zip(row, table.velocities):
            ratios = table.ratios(u0)
            for l in ratios:
                for run in table.repeats(u0, l):
                    lines = run[run["time_s"] == time]
                    axis.plot(lines[x], lines[y], color=colour[l], **widths(l, ratios))
            axis.set_title(f"$u_0$ = {u0:g} m/s, {time:g} s", fontsize=10)
        row[0].set_ylabel(labels[1])
        row[0].set_yscale(scale)
    for axis in axes[-1]:
        axis.set_xlabel(labels[0])
    legend(figure, ratio_lines(colour))
    return figure


def mean_nusselt(stem, start):
    """Fig 11. Bars: 95 %, from what repeats of all ratios at a velocity differ by."""
    table = Table(stem)
    figure, ((axis,),) = panels(1, 1, 3.7)
    colour = dict(zip(table.velocities, plt.cm.plasma(np.linspace(0, 0.75, len(table.velocities)))))
    for u0 in table.velocities:
        groups = {l: np.array([r["Nu_mean"][r["time_s"] >= start - 1e-9].mean() for r in table.repeats(u0, l)])
                  for l in table.ratios(u0)}
        means = np.array([g.mean() for g in groups.values()])
        repeated = [g for g in groups.values() if len(g) > 1]
        bars = [bar(*spread(repeated), len(g)) for g in groups.values()] if repeated else None
        axis.fill_between(list(groups), 0.99 * means[0], 1.01 * means[0], color=colour[u0], alpha=0.12, lw=0)
        axis.errorbar(list(groups), means, bars, fmt="o-", color=colour[u0], capsize=4, label=f"$u_0$ = {u0:g} m/s")
    axis.set(xlabel="coarse-graining ratio $l$", ylabel=f"mean Nusselt number from {start:g} s on",
             xticks=table.ratios())
    axis.margins(y=0.15)
    legend(figure, axis.get_legend_handles_labels()[0])
    return figure


def nusselt_pdf(stem):
    """Fig 12. Bands: a standard error to either side."""
    table = Table(stem, "nusselt")
    figure, (axes,) = panels(1, len(table.velocities), 3.1, sharex=True, sharey=True)
    colour = shades(table.ratios())
    for axis, u0 in zip(axes, table.velocities):
        ratios = table.ratios(u0)
        for l in ratios:
            Nu, density, error = mean_density(table.repeats(u0, l))
            axis.plot(Nu, density, color=colour[l], **widths(l, ratios))
            axis.fill_between(Nu, density - error, density + error, color=colour[l], alpha=0.25, lw=0)
        axis.set_title(f"$u_0$ = {u0:g} m/s", fontsize=10)
        axis.set_xlabel("Nusselt number")
    axes[0].set(ylabel="PDF", ylim=(0, None))
    legend(figure, ratio_lines(colour))
    return figure


def draw(stem, runs, times, start, folder):
    """Writes the pictures. @param runs, times  of paper_tables.make; none where the runs are not there"""
    made = {"2-4": configurations(runs, times, TEMPERATURE), "8-10": configurations(runs, times, NUSSELT)} if runs else {}
    made |= {"5": cooling(stem),
             "6": at_times(Table(stem, "temperature"), "T_K", "density_per_K", ("particle temperature [K]", "PDF [1/K]"), scale="log"),
             "7": at_times(Table(stem, "profile"), "z_mm", "T_K", ("height [mm]", "particle temperature [K]"), sharex=True),
             "11": mean_nusselt(stem, start), "12": nusselt_pdf(stem)}
    for number, figure in made.items():
        of_particles = "-" in number
        for axis in () if of_particles else figure.axes:
            axis.grid(alpha=0.25)
        save(figure, Path(folder) / f"{Path(stem).name}_fig{number}.png", 95 if of_particles else 110)
    print(f"pictures: {folder}/{Path(stem).name}_fig{{{','.join(made)}}}.png")
