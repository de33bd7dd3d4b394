"""Small tables of the paper's campaign, from which its figures are drawn without the runs. STEM is results/paper,
results/paper_fluidized_bed:

STEM.csv              mean temperature and Nusselt number of the particles in time (Figs 5 and 11)
STEM_temperature.csv  PDF of the particle temperature at single times (Fig 6)
STEM_profile.csv      particle temperature over the height at single times, layers two cells high (Fig 7)
STEM_nusselt.csv      PDF of the Nusselt number, all particles in all dumps since the start has passed, with its standard
                      error from blocks of time (Fig 12)

Each line begins with `l`, `u0` and `nudge`, the factor of `u0` that makes a repeat of a run. Runs to the same end whose folders
are not there (any more) keep their lines: long campaigns are made in pieces.
"""

import csv
import itertools
import sys
from pathlib import Path

import numpy as np
from scipy.stats import wasserstein_distance

sys.path.append(str(Path(__file__).resolve().parent.parent / "examples"))
import results
from bed_pictures import Run, times_to_show
from paraview import read_dump

KEY = ("l", "u0", "nudge")
BLOCKS = 5


def path(stem, table):
    return Path(f"{stem}{'_' if table else ''}{table}.csv")


def lines_by_key(stem, table):
    """Lines of a table that was written, as text, by the key (l, u0, nudge) as text; nothing without a table."""
    found = {}
    if path(stem, table).is_file():
        with open(path(stem, table), newline="") as file:
            for line in itertools.islice(csv.reader(file), 1, None):
                found.setdefault(tuple(line[:len(KEY)]), []).append(line)
    return found


def write(stem, table, columns, rows, kept, digits=6):
    """@param rows  key (l, u0, nudge), then numbers. @param kept  keys, as text, whose lines stay"""
    old = lines_by_key(stem, table)
    with open(path(stem, table), "w", newline="") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow([*KEY, *columns])
        for key in kept:
            lines.writerows(old.get(key, []))
        lines.writerows([*key, *(f"{x:.{digits}g}" for x in numbers)] for key, *numbers in rows)


class Table:
    """A table that was written, as one structured array for each run."""

    def __init__(self, stem, table=""):
        lines = np.atleast_1d(np.genfromtxt(path(stem, table), delimiter=",", names=True))
        keys = sorted(set(zip(*(lines[k] for k in ("u0", "l", "nudge")))), key=lambda k: (k[0], k[1], abs(k[2] - 1)))
        self.runs = {k: lines[(lines["u0"] == k[0]) & (lines["l"] == k[1]) & (lines["nudge"] == k[2])] for k in keys}
        self.velocities = sorted({u0 for u0, _, _ in keys})

    def ratios(self, u0=None):
        """Coarse-graining ratios at a velocity, or at any."""
        return sorted({l for v, l, _ in self.runs if u0 in (v, None)})

    def repeats(self, u0, l):
        """Runs that differ by their nudge, the one without first."""
        return [lines for (v, ratio, _), lines in self.runs.items() if (v, ratio) == (u0, l)]

    def times(self):
        return sorted(set.intersection(*(set(lines["time_s"]) for lines in self.runs.values())))


def make(stem, folders, times, start):
    """Writes the tables. @param folders  key -> folder of the run; @param times of STEM.csv [s]; @param start see above [s]
    @return key -> Run, times of the PDFs and profiles"""
    runs = {key: Run(folder) for key, folder in folders.items()}
    for run in runs.values():
        run.dumps = {t: p for t, p in run.dumps.items() if t <= times[-1] + 1e-9}
    shown = times_to_show(list(runs.values()), 2)
    made = {tuple(map(str, key)) for key in runs}
    kept = [key for key, lines in lines_by_key(stem, "").items() if key not in made and float(lines[-1][len(KEY)]) == times[-1]]
    write(stem, "", ("time_s", "T_mean_K", "Nu_mean"), (
        (key, *row) for key, run in runs.items()
        for row in zip(times, *(np.interp(times, run.bed["time_s"], run.bed[c]) for c in ("T_mean_K", "Nu_mean")))), kept, digits=9)
    write(stem, "temperature", ("time_s", "T_K", "density_per_K"), temperatures(runs, shown), kept)
    write(stem, "profile", ("time_s", "z_mm", "T_K", "particles"), profiles(runs, shown), kept)
    write(stem, "nusselt", ("Nu", "density", "error"), nusselts(runs, start), kept)
    return runs, shown


def temperatures(runs, times):
    """The bins are those of all runs at a velocity and time; the coldest half per cent of the particles is left out."""
    for u0, time in itertools.product(sorted({key[1] for key in runs}), times):
        values = {key: run.particles(time)["f_Temp"] for key, run in runs.items() if key[1] == u0}
        edges = np.linspace(min(np.percentile(v, 0.5) for v in values.values()), max(map(np.max, values.values())), 41)
        for key, value in values.items():
            density = np.histogram(value, edges)[0] / len(value) / np.diff(edges)
            yield from ((key, time, *row) for row in zip((edges[1:] + edges[:-1]) / 2, density) if row[1] > 0)


def profiles(runs, times):
    for (key, run), time in itertools.product(runs.items(), times):
        edges, particles = run.layers(), run.particles(time)
        mean, count = results.layer_means(particles["z"], particles["f_Temp"], edges)
        rows = np.array([500 * (edges[1:] + edges[:-1]), mean, count]).T
        yield from ((key, time, *row) for row in rows[count >= 5])


def nusselts(runs, start, width=0.1):
    for key, run in runs.items():
        values = [read_dump(file)["f_Nusselt"] for time, file in sorted(run.dumps.items()) if time >= start - 1e-9]
        edges = width * np.arange(np.floor(min(map(np.min, values)) / width), np.ceil(max(map(np.max, values)) / width) + 1)
        blocks = np.array([np.histogram(np.concatenate(v), edges, density=True)[0] for v in
                           np.array_split(np.array(values), min(BLOCKS, len(values)))])
        error = blocks.std(axis=0, ddof=1) / np.sqrt(len(blocks)) if len(blocks) > 1 else np.full(len(edges) - 1, np.nan)
        density = np.histogram(np.concatenate(values), edges, density=True)[0]
        yield from ((key, *row) for row in zip((edges[1:] + edges[:-1]) / 2, density, error))


def mean_density(runs):
    """PDF of the Nusselt number of all repeats together. @return Nu, density, its standard error"""
    Nu = np.unique(np.round(np.concatenate([r["Nu"] for r in runs]), 6))
    density, error = (np.array([np.interp(Nu, r["Nu"], r[c], left=0, right=0) for r in runs]) for c in ("density", "error"))
    return Nu, density.mean(axis=0), np.sqrt((error**2).sum(axis=0)) / len(runs)


def nusselt_distance(runs, reference):
    """Wasserstein distance of the PDFs of the Nusselt number, over the mean of the reference."""
    (a, p, _), (b, q, _) = mean_density(runs), mean_density(reference)
    return wasserstein_distance(a, b, p, q) / np.average(b, weights=q)


def profile_distance(runs, reference, time, hot):
    """Mean difference of the layers' temperatures (means of the repeats), weighted with the particles in them, over what the
    reference has cooled since it was at `hot` [K]."""
    def layers(repeats):
        rows = np.concatenate([r[r["time_s"] == time] for r in repeats])
        return {z: (rows["T_K"][rows["z_mm"] == z].mean(), rows["particles"][rows["z_mm"] == z].sum())
                for z in np.unique(rows["z_mm"])}
    own, theirs = layers(runs), layers(reference)
    common = sorted(set(own) & set(theirs))
    weights = [theirs[z][1] for z in common]
    away = np.average([abs(own[z][0] - theirs[z][0]) for z in common], weights=weights)
    return away / (hot - np.average([theirs[z][0] for z in common], weights=weights))


def distances(stem, hot):
    """Of the curves of Figs 7 and 12: each `l` against the finest, and what repeats of a run differ by, mean of all pairs.

    @param hot  temperature of the particles at the start [K]
    @return name -> value
    """
    nusselt, profile = Table(stem, "nusselt"), Table(stem, "profile")
    time = profile.times()[-1]
    figures = {"PDF of the Nusselt number, Wasserstein distance, of the mean": (nusselt, nusselt_distance),
               f"axial temperature profile at {time:g} s, mean difference, of the drop":
                   (profile, lambda runs, reference: profile_distance(runs, reference, time, hot))}
    found = {}
    for (name, (table, distance)), u0 in itertools.product(figures.items(), nusselt.velocities):
        finest, *coarser = table.ratios(u0)
        for l in coarser:
            value = distance(table.repeats(u0, l), table.repeats(u0, finest))
            found[f"u0 = {u0:g} m/s, l = {l:g} against {finest:g}: {name}"] = value
        for l in (finest, *coarser):
            pairs = list(itertools.combinations(table.repeats(u0, l), 2))
            if pairs:
                found[f"u0 = {u0:g} m/s, repeats of l = {l:g}: {name}"] = np.mean([distance([a], [b]) for a, b in pairs])
    return found
