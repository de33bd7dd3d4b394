"""The page of one run: one HTML file without anything from elsewhere. Called by report_run.py."""

import base64
import html
import io
import re
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1] / "examples"))
import bed_pictures
from check_rows import number
from follow import COMMAND
from paraview import read_dump
from report_page import STYLE, seconds

STYLE += """
.answer.failed, .answer.ended { background: #fbeeee; border-color: #b3261e; }
.answer.stopped, .answer.going { background: #fdf6e3; border-color: #b58900; }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(9.5rem, 1fr)); gap: .5rem; }
.cards div { background: #f4f4f5; padding: .5rem .7rem; }
.cards b { display: block; font-size: 1.15rem; font-variant-numeric: tabular-nums; }
.cards span { font-size: .8rem; color: #444; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 20rem), 1fr)); gap: .5rem; }
.particles img { max-height: 36rem; }
td.bar { width: 100%; min-width: 5rem; } td.bar i { display: block; height: .8rem; background: #0072b2; }
tr.part td.bar i { background: #56b4e9; } tr.part td:first-child { padding-left: 1.4rem; }
table.full { width: 100%; } td.name { white-space: pre-wrap; min-width: 0; } td.long { white-space: normal; overflow-wrap: anywhere; }
.fine code { overflow-wrap: anywhere; }
@media (max-width: 600px) { td.bar { min-width: 3rem; } td.wide, th.wide { display: none; } .cards { grid-template-columns: 1fr 1fr; } }
"""
BLUE, GREY = "#0072b2", "0.45"
MOST = 600  # points of a line


def thinned(time, values):
    """(time, mean, smallest, largest) of at most MOST spans of time; a span without a value is left out."""
    known = np.isfinite(values)
    time, values = time[known], values[known]
    spans = np.array_split(np.arange(len(time)), min(MOST, max(len(time), 1)))
    rows = [(time[s].mean(), values[s].mean(), values[s].min(), values[s].max()) for s in spans if len(s)]
    return np.array(rows).reshape(-1, 4).T


def line(axis, time, values, **look):
    """A line; where points are too many, their mean over the band of what they span."""
    t, mean, low, high = thinned(time, values)
    axis.plot(t, mean, lw=1.2, **{"color": BLUE, **look})
    if np.any(high > low):
        axis.fill_between(t, low, high, color=look.get("color", BLUE), alpha=0.2, lw=0)


def plots(run):
    """[(what, figure)] over time, those that the run has."""
    bed, steps = run["bed"], run["steps"]
    made = []

    def panel(what, unit):
        figure, axis = plt.subplots(figsize=(4.4, 2.9), layout="constrained")
        axis.set(xlabel="time [s]", ylabel=f"{what} [{unit}]" if unit else what)
        axis.grid(alpha=0.25)
        made.append((what, figure))
        return axis

    def has(column):
        return bed is not None and column in bed.dtype.names and np.isfinite(bed[column]).sum() > 1

    time = bed["time_s"] if bed is not None else None
    if has("T_mean_K"):
        axis = panel("particle temperature", "K")
        axis.fill_between(time, bed["T_min_K"], bed["T_max_K"], color=BLUE, alpha=0.15, lw=0, label="coldest to hottest")
        line(axis, time, bed["T_mean_K"], label="mean")
        axis.legend(frameon=False, fontsize=9)
    if has("pressure_drop_Pa"):
        axis = panel("pressure drop", "Pa")
        line(axis, time, bed["pressure_drop_Pa"])
        low, high = np.percentile(bed["pressure_drop_Pa"], [2, 98])  # without the kick of the start
        if has("weight_Pa") and bed["weight_Pa"].max() > 0:
            axis.plot(time, bed["weight_Pa"], color=GREY, lw=1, ls="--", label="weight of the bed over the cross-section")
            axis.legend(frameon=False, fontsize=9, loc="lower right")
            high = max(high, bed["weight_Pa"].max())
        axis.set_ylim(min(0, 1.2 * low), 1.25 * max(high, 1e-30))
    for column, what, unit, factor in (("Nu_mean", "mean Nusselt number", "", 1), ("height_m", "bed height", "mm", 1e3),
                                       ("overlap_max", "largest overlap", "% of a diameter", 100)):
        if has(column):
            axis = panel(what, unit)
            line(axis, time, factor * bed[column])
            if column != "Nu_mean":
                axis.set_ylim(0, 1.1 * factor * np.nanmax(bed[column]) or None)
    if len(steps) > 1:
        line(panel("Courant number", ""), steps[:, 0], steps[:, 1])
        length = np.diff(steps[:, 0])
        axis = panel("gas step", "ms")
        line(axis, steps[1:, 0], 1e3 * length)
        axis.set_ylim(0, 1.15e3 * length.max())
    return made


class Scene:
    """The particles of a run as bed_pictures draws them: LIGGGHTS' box, and what the dumps hold at their times."""

    def __init__(self, files):
        self.dumps, self.read = files, {}
        first = min(files)
        bounds = re.search(r"ITEM: BOX BOUNDS[^\n]*\n((?:[^\n]*\n){3})", files[first].read_text())[1]
        (self.low, right), (front, back), (_, self.height) = np.array([row.split()[:2] for row in bounds.splitlines()], float)
        self.width, self.middle = right - self.low, (front + back) / 2

    def particles(self, time):
        """Columns of a dump, with the speed; None where it is being written, or holds no particles."""
        if time not in self.read:
            dump = read_dump(self.dumps[time])
            if dump and {"vx", "vy", "vz"} <= set(dump):
                dump["speed"] = np.sqrt(dump["vx"]**2 + dump["vy"]**2 + dump["vz"]**2)
            self.read[time] = dump if dump and len(dump.get("radius", ())) and {"x", "y", "z"} <= set(dump) else None
        return self.read[time]


def pictures(files):
    """[(what, wide figure, narrow one)] of particles near the centre plane at times spread over the run."""
    if not files:
        return []
    scene, made = Scene(files), []
    wanted = [t for t in sorted(files) if t > 0] or sorted(files)
    chosen = sorted({wanted[round((len(wanted) - 1) * k / 4)] for k in range(1, 5)})
    times = [t for t in chosen if scene.particles(t)]
    for column, label, colours in (bed_pictures.TEMPERATURE, bed_pictures.NUSSELT, ("speed", "speed [m/s]", "viridis")):
        if not times or not all(column in scene.particles(t) for t in times) or (column == "speed" and made):
            continue
        made.append((f"particles near the centre plane by {label.split(' [')[0]}",
                     *(bed_pictures.configurations([scene], some, (column, label, colours)) for some in (times, times[-2:]))))
    return made


def data(figure, kind):
    """A figure as the address of an image inside the page; closes it."""
    file = io.BytesIO()
    with plt.rc_context({"svg.hashsalt": "hotbed"}):
        figure.savefig(file, format=kind, dpi=120, **({"metadata": {"Date": None}} if kind == "svg" else {"bbox_inches": "tight"}))
    plt.close(figure)
    return f"data:image/{'svg+xml' if kind == 'svg' else kind};base64,{base64.b64encode(file.getvalue()).decode()}"


def cards(run):
    """The figures that one looks at first."""
    f = run["figures"]
    shown = [("simulated", f"{f['simulated_s']:.4g} s"), ("wall time of the solver", seconds(run["wall_s"]))]

    def add(what, name, form, factor=1.0):
        if name in f:
            shown.append((what, form.format(factor * f[name])))

    add("coarse particles", "particles", "{:,.0f}")
    add("mean temperature at the end", "temperature_mean_K", "{:.2f} K")
    add("mean Nusselt number", "nusselt_mean", "{:.3g}")
    add("mean pressure drop", "pressure_drop_mean_Pa", "{:.4g} Pa")
    if f.get("weight_mean_Pa"):
        shown.append(("of the weight of the bed", f"{100 * f['pressure_drop_mean_Pa'] / f['weight_mean_Pa']:.1f} %"))
    add("mean bed height", "height_mean_m", "{:.3g} mm", 1e3)
    add("largest overlap, of a diameter", "overlap_largest", "{:.2g} %", 100)
    add("gas steps", "gas_steps", "{:,.0f}")
    if "gas_step_mean_s" in f:
        shown.append(("mean gas step", number(f["gas_step_mean_s"], "s")))
    add("mean Courant number", "courant_mean", "{:.2g}")
    add("largest Courant number", "courant_largest", "{:.2g}")
    add("energy not accounted for, of that exchanged", "energy_not_accounted_for", "{:.1e}")
    add("momentum not accounted for", "momentum_not_accounted_for", "{:.1e}")
    return '<div class="cards">' + "".join(f"<div><b>{html.escape(v)}</b><span>{what}</span></div>" for what, v in shown) + "</div>"


def table(rows):
    """A table of texts; the first column is one of names, and takes the whole row where nothing follows."""
    def cells(row):
        if not any(row[1:]):  # a line of the budget without a number of its own
            return f'<td class="text name" colspan="{len(row)}">{html.escape(row[0])}</td>'
        return "".join(f'<td class="text{" name" if not n else " long" if len(text) > 24 else ""}">{html.escape(text)}</td>'
                       for n, text in enumerate(row))

    return '<div class="wide"><table>' + "".join(f"<tr>{cells(row)}</tr>" for row in rows) + "</table></div>"


def timing(run):
    """The closing table with a bar for each share."""
    if not run["timing"]:
        return ('<p class="fine">The log has no timing table: it is written when the solver ends by itself or by a signal.</p>')
    ranks = run["ranks"] and run["ranks"] > 1
    head = ('<tr><th class="text">phase</th><th class="text">share</th><th></th><th class="wide">seconds</th>'
            + '<th class="wide">largest of the ranks</th>' * bool(ranks) + '<th class="wide">ms a gas step</th></tr>')
    body = "".join(
        f'<tr{" class=part" if r["part"] else ""}><td class="text">{html.escape(r["phase"])}</td><td class="bar">'
        f'<i style="width:{100 * r["share"]:.1f}%"></i></td><td>{100 * r["share"]:.1f} %</td><td class="wide">{r["mean_s"]:.2f}</td>'
        + f'<td class="wide">{r["largest_s"]:.2f}</td>' * bool(ranks) + f'<td class="wide">{1e3 * r["a_step_s"]:.3g}</td></tr>'
        for r in run["timing"] if r["phase"] != "whole run")
    last = " Of the last piece of the run." if run["pieces"] > 1 else ""
    return (f'<div class="wide"><table class="full">{head}{body}</table></div><p class="fine">Paler bars are parts of the phase '
            f"above them.{last}</p>" + table(run["speed"].items()))


def budget(run):
    if run["budget"]:
        return table(run["budget"])
    return ('<p class="fine">The log has no budget yet: it is written when the solver ends by itself or by a signal. The last line '
            "of bed.csv:</p>" + table([(name, f"{run['figures'][name]:.6g}") for name in
                                       ("exchanged_J", "energy_not_accounted_for", "momentum_not_accounted_for", "mismatch")
                                       if name in run["figures"]]))


def files(run):
    """Where what the run wrote is."""
    make = f"not there yet: {Path(__file__).resolve().parents[1]}/cfd_solver/paraview.py {run['folder']}"
    rows = [("particles.pvd", "the particles for ParaView" if run["files"]["particles.pvd"] else make),
            ("gas.pvd", "the gas for ParaView" if run["files"]["gas.pvd"] else make)]
    rows += [("postProcessing/hotbed/", "bed.csv: what the curves are drawn from")] if run["files"]["postProcessing/hotbed"] else []
    rows += [("restart/", f"restarts: {COMMAND} run ... --restart")] if run["files"]["restart"] else []
    return f"<p class='fine'>In <code>{html.escape(run['folder'])}</code>:</p>" + table([*rows, ("log.hotbedFoam", "the log")])


def write(run, dumps):
    """Draws the pictures and writes report.html into the run's folder. @param dumps  {time: file}. @return its path"""
    curves = "".join(f'<img src="{data(figure, "svg")}" alt="{html.escape(what)} over time">' for what, figure in plots(run))
    particles = "".join(
        f'<p class="particles"><picture><source media="(max-width: 600px)" srcset="{data(narrow, "png")}"><img src="{data(wide, "png")}" '
        f'alt="{html.escape(what)}"></picture></p>' for what, wide, narrow in pictures(dumps))
    warned = "".join(f"<li>{html.escape(text)}{f' <small>({count} times)</small>' if count > 1 else ''}</li>"
                     for text, count in run["warnings"].items())
    changes = run["label"].replace(",", ", ")
    again = f" It was stopped and went on: {run['pieces']} logs." if run["pieces"] > 1 else ""
    ranks = f"{run['ranks']} rank{'s' * (run['ranks'] > 1)}" if run["ranks"] else ""
    settings = [(s["name"], s["value"], s["meaning"]) for s in run["settings"]]
    page = f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(f"{run['name']}: {changes}")}</title><style>{STYLE}</style></head><body>
<h1>{html.escape(run["name"])}</h1>
<p class="fine">{html.escape(changes)}</p>
<p class="answer {run['state']}">{html.escape(run['sentence'] + again)}</p>
{cards(run)}
<p class="fine">Means are over time and leave out the first 40 % of the run.</p>
<h2>Over time</h2>
{f'<div class="plots">{curves}</div>' if curves else '<p class="fine">Nothing yet.</p>'}
<h2>Particles</h2>
{particles or '<p class="fine">The DEM script dumps no particles as text with x y z radius and f_Temp, f_Nusselt or vx vy vz.</p>'}
<h2>What is conserved</h2>
{budget(run)}
<h2>Where the time went</h2>
{timing(run)}
<h2>Warnings</h2>
{f"<ul>{warned}</ul>" if warned else '<p class="fine">None in the logs.</p>'}
<h2>What was run</h2>
{table([*run["case"].items(), ("begun", run["date"] or "not known"), ("on", ranks), *run["versions"].items()])}
{"<h3>settings</h3>" + table(settings) if settings else ""}
<h3>constant/couplingProperties</h3>
{table(run["coupling"].items())}
<h2>Files</h2>
{files(run)}
</body></html>
"""
    target = Path(run["folder"]) / "report.html"
    target.write_text(page)
    return target
