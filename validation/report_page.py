"""The page of a report: one HTML file without anything from elsewhere, and its pictures. Called by report.py."""

import base64
import html
import itertools

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, NullFormatter

from report_errors import FIGURES

COLOURS = ["#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f6a00", "#882255", "#888888"]
MARKERS = "oDs^vPX<>p"

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1d1d1f; background: #fff; max-width: 1080px; margin: 0 auto;
       padding: 1rem; }
h1 { font-size: 1.6rem; line-height: 1.2; } h2 { font-size: 1.2rem; margin-top: 2.2rem; }
.answer { background: #eef4f8; border-left: 4px solid #0072b2; padding: .7rem 1rem; overflow-wrap: anywhere; }
img { max-width: 100%; height: auto; display: block; margin: 0 auto; }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-size: .82rem; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .45rem; text-align: right; white-space: nowrap; border-bottom: 1px solid #ddd; }
th { vertical-align: bottom; white-space: normal; min-width: 4.5rem; }
th.text, td.text { text-align: left; } td.name { white-space: normal; min-width: 9rem; }
th.number { min-width: 0; }
tr.group td { background: #f4f4f5; font-weight: 600; border-top: 1px solid #aaa; }
.group span { position: sticky; left: .6rem; }
tr.front td { font-weight: 600; } td.unknown { color: #6b6b70; font-weight: 400; }
dt { font-weight: 600; } dd { margin: 0 0 .4rem 1rem; } small, .fine { font-size: .85rem; color: #444; }
td.name span { white-space: nowrap; }
@media (max-width: 600px) { th, td { padding: .25rem .3rem; } th, td.name { min-width: 0; } table { font-size: .75rem; } }
code { overflow-wrap: anywhere; }
"""


def seconds(value):
    """A time for people."""
    return f"{value:.2g} s" if value < 10 else f"{value:.0f} s" if value < 600 else f"{value / 60:.0f} min"


def percent(value):
    return f"{100 * value:.2g} %" if value < 0.995 else f"{100 * value:.0f} %"


def shown(error):
    """An error as the tables show it."""
    if error.value < error.bar:
        return f"≤ {percent(error.bar)}"
    return f"{percent(error.value)[:-2]} ± {percent(error.bar)}" if error.bar > 0 else percent(error.value)


def setting(label):
    """A label that breaks between its settings only."""
    return " ".join(f"<span>{html.escape(word)}</span>" for word in label.split()) if "=" in label else html.escape(label)


def against(report):
    """What errors are taken against."""
    return "the exact solution" if report["exact"] else f"the reference run ({report['rows'][0]['label']})"


def compared(report):
    """The figures that the answer is about."""
    names = [FIGURES[f][0] for f in report["heat"]]
    return " and ".join(names) if len(names) < 3 else "all heat figures"


def sentence(report):
    """The answer: the cheapest setting within 5 and within 1 %."""
    slowest = max((r for r in report["rows"] if r["folder"]), key=lambda r: r["seconds"])

    def named(bounds, best):
        within = " and ".join(f"within {100 * b:g} %" for b in bounds)
        if best is None:
            return f"{within} none is known to be"
        ratio = slowest["seconds"] / best["seconds"]
        faster = f", {ratio:.2g} times faster than the slowest run" if best is not slowest else ""
        return f"the cheapest {within} is {best['label']} ({seconds(best['seconds'])}{faster})"

    best = report["best"]["heat"]
    parts = ([named((0.05, 0.01), best[0.05])] if best[0.05] is best[0.01] else
             [named((bound,), best[bound]) for bound in (0.05, 0.01)])
    return f"In {compared(report)}, against {against(report)}: {'; '.join(parts)}."


def commands(report):
    """How to run the cheapest settings."""
    best = {r["label"]: r for r in report["best"]["heat"].values() if r}
    lines = []
    for r in best.values():
        changes = {**report["common"], **r["changes"]}
        lines.append(f"./hotbed run {report['path']}" + (" --set " if changes else "") +
                     " ".join(f"{n}={v}" for n, v in changes.items()))
    return "".join(f"<p class='fine'><code>{html.escape(line)}</code></p>" for line in lines)


def looks(report):
    """group -> colour and marker"""
    groups = list(dict.fromkeys(r["group"] for r in report["rows"]))
    return {g: (COLOURS[n % len(COLOURS)], MARKERS[n % len(MARKERS)])
            for n, g in enumerate(g for g in groups if g != "reference")}


def front(rows, error):
    """The runs that have none both cheaper and better, by time."""
    rows = [r for r in rows if r["folder"] and r["choice"]]
    return sorted((r for r in rows if not any(
        o["seconds"] <= r["seconds"] and error(o) <= error(r) and (o["seconds"], error(o)) != (r["seconds"], error(r))
        for o in rows)),
                  key=lambda r: r["seconds"])


def number(axis, points, taken):
    """Writes each point's number beside it, where it hides least. @param points [(x, y, text, weight)]"""
    figure = axis.figure
    scale = figure.dpi / 72
    spots = [axis.transData.transform(p[:2]) for p in points]
    taken = [np.array(t) for t in taken] + spots
    for (x, y, text, weight), spot in zip(points, spots):
        offsets = [(dx, dy) for radius in (10, 15, 21) for dx, dy in
                   radius * np.array([(1, 0), (0, 1), (-1, 0), (0, -1), (.75, .75), (-.75, .75), (-.75, -.75), (.75, -.75)])]
        best = min(offsets, key=lambda o: sum(max(0, 1 - np.hypot(*((spot + scale * np.array(o) - t) / scale / (1, 0.8))) / 13)
                                              for t in taken) + 0.01 * np.hypot(*o))
        taken.append(spot + scale * np.array(best))
        far = np.hypot(*best) > 12
        axis.annotate(text, (x, y), best, textcoords="offset points", ha="center", va="center", fontsize=8, weight=weight,
                      zorder=5, path_effects=[withStroke(linewidth=2.5, foreground="white")],
                      arrowprops=dict(arrowstyle="-", lw=0.5, color="0.5", shrinkA=0, shrinkB=3) if far else None)


def plot(axis, report, error, numbers, title=None):
    """Error over time. @param error  of a row: (known error, whether the error itself is known)"""
    look = looks(report)
    rows = [r for r in report["rows"] if r["folder"] and r["group"] != "reference"]
    values = {id(r): (max(error(r)[0], 1e-6), error(r)[1]) for r in rows}
    for group, (colour, marker) in look.items():
        for r in (r for r in rows if r["group"] == group):
            y, known = values[id(r)]
            axis.plot(r["seconds"], y, marker, ms=6.5, mew=1.3, color=colour, mfc=colour if known else "white", zorder=3)
            if not known:
                axis.annotate("", (r["seconds"], y), (0, -14), textcoords="offset points",
                              arrowprops=dict(arrowstyle="<-", lw=1, color=colour, shrinkB=4), zorder=2)
    best = front(report["rows"], lambda r: values[id(r)][0])
    if best:
        axis.step([r["seconds"] for r in best], [values[id(r)][0] for r in best], where="post", color="0.6", lw=1.6, zorder=1)
    axis.set(xscale="log", yscale="log")
    times = [r["seconds"] for r in rows]
    if not report["exact"]:
        reference = report["rows"][0]["seconds"]
        times = times + [reference]
        axis.axvline(reference, color="0.5", ls=":", lw=1.2)
    levels = [v[0] for v in values.values()]
    axis.set_xlim(min(times) / 1.25, max(times) * 1.25)
    axis.set_ylim(min(min(levels), 0.01) / 2, max(max(levels) * 2, 0.08))
    low, high = axis.get_ylim()
    for bound in (0.01, 0.05):
        axis.axhline(bound, color="0.65", lw=1, zorder=0)
        axis.annotate(f"{bound:.0%}", (1, bound), (-2, 2), xycoords=("axes fraction", "data"), textcoords="offset points",
                      ha="right", va="bottom", fontsize=7, color="0.4")
    axis.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{100 * y:g} %"))
    axis.yaxis.set_minor_formatter(NullFormatter())
    if high / low < 30:  # decades alone would be too few
        axis.yaxis.set_minor_formatter(FuncFormatter(lambda y, _: f"{100 * y:g} %" if f"{y:e}"[0] in "25" else ""))
    first, last = axis.get_xlim()
    for digits in ([1], [1, 3], [1, 2, 5], np.arange(1, 10), np.arange(1, 10, 0.5)):
        ticks = [m * 10.0**e for e in range(-2, 7) for m in digits if first <= m * 10.0**e <= last]
        if len(ticks) > 2:
            break
    axis.set_xticks(ticks)
    axis.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.grid(alpha=0.2, which="both", lw=0.5)
    if title:
        axis.set_title(title, fontsize=10)
    if numbers:
        axis.figure.canvas.draw()
        number(axis, [(r["seconds"], values[id(r)][0], str(r["number"]), "bold" if r in best else "normal") for r in rows], [])


def legend(figure, report, columns):
    handles = [plt.Line2D([], [], color=c, marker=m, ls="", ms=6, label=g) for g, (c, m) in looks(report).items()]
    handles.append(plt.Line2D([], [], color="0.6", lw=1.6, label="front: none cheaper and better"))
    if any(r["folder"] and not r["known"] for r in report["rows"]):
        handles.append(plt.Line2D([], [], color="0.3", marker="o", mfc="white", ls="", ms=6, label="at most: error below bar"))
    if not report["exact"]:
        handles.append(plt.Line2D([], [], color="0.5", ls=":", label="time of the reference"))
    figure.legend(handles=handles, loc="lower center", ncols=columns, fontsize=8, frameon=False, columnspacing=1.2)
    below = (0.19 * -(-len(handles) // columns) + 0.15) / figure.get_figheight()
    figure.get_layout_engine().set(rect=(0, below, 1, 1 - below))


def pictures(report, folder):
    """{name: (wide, narrow)} paths of the pictures: the largest heat error over time, and each figure alone."""
    def largest(r):
        return r["worst"], r["known"]

    made = {}
    for name, size, columns in (("front", (9, 5.6), 4), ("front-narrow", (4.2, 5.6), 2)):
        figure, axis = plt.subplots(figsize=size, layout="constrained", dpi=150)
        legend(figure, report, columns)
        axis.set_xlabel("run time [s]")
        axis.set_ylabel(f"error against {'the exact solution' if report['exact'] else 'the reference'}")
        plot(axis, report, largest, True)
        made[name] = figure
    figures = report["figures"]
    for name, wide in (("figures", min(3, len(figures))), ("figures-narrow", 1)):
        rows = -(-len(figures) // wide)
        size = (9, 3.1 * rows + 0.9) if wide > 1 else (4.2, 2.9 * rows + 1.2)
        figure, axes = plt.subplots(rows, wide, figsize=size, layout="constrained", squeeze=False, dpi=150)
        legend(figure, report, 4 if wide > 1 else 2)
        for axis, f in itertools.zip_longest(axes.flat, figures):
            if f is None:
                axis.axis("off")
                continue
            plot(axis, report, lambda r: (r["errors"][f].known, r["errors"][f].value >= r["errors"][f].bar), False,
                 FIGURES[f][0])
            axis.tick_params(labelsize=8, which="both")
        for axis in axes[-1]:
            axis.set_xlabel("run time [s]", fontsize=9)
        made[name] = figure
    for name, figure in made.items():
        figure.savefig(folder / f"{name}.png")
        plt.close(figure)
    return {"front": (folder / "front.png", folder / "front-narrow.png"),
            "figures": (folder / "figures.png", folder / "figures-narrow.png")}


def image(paths, text):
    """Both pictures inside the page: the narrow one for phones."""
    wide, narrow = ("data:image/png;base64," + base64.b64encode(p.read_bytes()).decode() for p in paths)
    return (f'<picture><source media="(max-width: 600px)" srcset="{narrow}">'
            f'<img src="{wide}" alt="{html.escape(text)}"></picture>')


def table(report):
    """All runs, by group."""
    out = ['<div class="wide"><table><tr><th class="number">#</th><th class="text">changed</th><th>run time</th>']
    contact = all(r["contact"] for r in report["rows"] if r["folder"])
    out += ["<th>DEM steps a contact</th>"] * contact
    out += [f"<th>{FIGURES[f][0]}</th>" for f in report["figures"]] + ["</tr>"]
    before = None
    for r in report["rows"]:
        if r["group"] != before:
            before = r["group"]
            out.append(f'<tr class="group"><td class="text" colspan="{3 + contact + len(report["figures"])}">'
                       f'<span>{html.escape(before)}</span></td></tr>')
        if not r["folder"]:
            out.append(f'<tr><td>{r["number"]}</td><td class="text name">{setting(r["label"])}</td>'
                       f'<td class="text" colspan="{1 + contact + len(report["figures"])}">the run failed</td></tr>')
            continue
        out.append(f'<tr{" class=front" if r["front"] else ""}><td>{r["number"]}</td>'
                   f'<td class="text name">{setting(r["label"])}</td><td>{seconds(r["seconds"])}</td>')
        if contact:
            out.append(f'<td>{r["contact"]:.3g}</td>')
        for f in report["figures"]:
            e = r["errors"][f]
            out.append("<td>-</td>" if r["group"] == "reference" else
                       f'<td{" class=unknown" if e.value < e.bar else ""}>{shown(e)}</td>')
        out.append("</tr>")
    return "\n".join(out) + "</table></div>"


def cheapest_table(report):
    """The cheapest run for each figure alone."""
    out = ['<div class="wide"><table><tr><th class="text">figure</th><th class="text">cheapest within 5 %</th>'
           '<th class="text">cheapest within 1 %</th></tr>']
    for f in ["heat"] * (len(report["heat"]) > 1) + report["figures"]:
        out.append(f'<tr><td class="text name">{FIGURES[f][0] if f in FIGURES else compared(report)}</td>')
        for bound in (0.05, 0.01):
            r = report["best"][f][bound]
            out.append('<td class="text name">' + (f'{setting(r["label"])} <small>({seconds(r["seconds"])})</small>' if r
                                              else "none known to be") + "</td>")
        out.append("</tr>")
    return "\n".join(out) + "</table></div>"


def write(report, folder):
    """Draws the pictures and writes index.html."""
    for n, r in enumerate(report["rows"]):
        r["number"] = n if not report["exact"] else n + 1
        if r["folder"]:
            r["known"] = any(e.value >= e.bar and e.known == r["worst"] for e in (r["errors"][f] for f in report["heat"]))
    paths = pictures(report, folder)
    common = " ".join(f"{n}={v}" for n, v in report["common"].items())
    figures = "".join(f"<dt>{FIGURES[f][0]}</dt><dd>{FIGURES[f][1]}</dd>" for f in report["figures"])
    bars = "" if report["exact"] else (
        " Two runs of a chaotic bed differ even where nothing is wrong: <b>±</b> is the half-width of the 95 % confidence "
        "interval, from "
        + ("repeats of the case that differ by nothing that matters" if any(r["group"] == "repeat" for r in report["rows"])
           else "five blocks of time") +
        ". An error below its bar is written <b>≤ bar</b> (open symbols, arrow down): nothing more is known, and nothing "
        "more is claimed. Longer runs make the bars smaller.")
    alike = [r["seconds"] for r in report["rows"] if r["folder"] and (r["group"] == "repeat" or not r["changes"])]
    noise = "" if len(alike) < 2 else (
        f" Times have noise too, from whatever else the machine does: {len(alike)} runs alike took {seconds(min(alike))} to "
        f"{seconds(max(alike))}.")
    versions = ", ".join(f"{n} {v}" for n, v in report["versions"].items())
    title = f"Error against run time: {report['case'].replace('_', ' ')}{', quick' if report['quick'] else ''}"
    page = f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)}</title><style>{STYLE}</style></head><body>
<h1>{html.escape(title)}</h1>
<p class="answer">{html.escape(report["sentence"])}</p>
{commands(report)}
<h2>Which settings are worth their cost</h2>
{image(paths["front"], "largest heat error over run time")}
<p class="fine">Error: the largest one of {html.escape(compared(report))}, against
{html.escape(against(report))}. Numbers are those of the table of runs; bold ones lie on the front: no other run is both cheaper
and better. Errors of different origin can cancel: what is better than a finer run here need not be so with other cells.</p>
<h2>Cheapest for each figure</h2>
{cheapest_table(report)}
<h2>All runs</h2>
<p class="fine">Each run is the case with only this changed{html.escape(f" (and, in all of them, {common})" if common else "")}.
Bold: on the front.</p>
{table(report)}
<h2>Each figure over run time</h2>
{image(paths["figures"], "each error over run time")}
<h2>How to read it</h2>
<p>Errors are against {html.escape(against(report))}.{bars}</p>
<dl>{figures}</dl>
<p>Run time is the wall time of the solver from start to end, on one core, with {report["at_once"]}
run{"s" * (report["at_once"] > 1)} at a time. A run that was stopped and went on counts with the pace of its last
piece.{noise}</p>
<p class="fine">Made by <code>{html.escape(report["command"])}</code> on {html.escape(report["machine"])};
{html.escape(versions)}.</p>
</body></html>
"""
    (folder / "index.html").write_text(page)
