"""Errors of a run against a reference run, or of the fixed bed against its exact solution, for report.py.

Each comes with a bar: beds are chaotic, so two runs differ even where nothing is wrong. The bar is the half-width of the 95 %
confidence interval: from repeats of the same run where there are any, else from blocks of time, which know less (too short for
the bed's memory they make too little of it; where both runs are in a transient, too much). An error below its bar is not
known to be there: all that is known is `<= bar`.
"""

import itertools
from collections import namedtuple
from pathlib import Path

import numpy as np
from scipy.stats import t as student
from scipy.stats import wasserstein_distance

import paraview
import results

BLOCKS = 5
CONFIDENCE = student.ppf(0.975, BLOCKS - 1)

# figure -> (short name, what its error is relative to)
FIGURES = {
    "gas": ("gas temperature", "mean difference over the height, over the temperature step, worst of the write times"),
    "particles": ("particle temperature", "the same for the layers of particles"),
    "temperature": ("mean particle temperature", "difference of its change, over that of the reference"),
    "nusselt": ("mean Nusselt number", "difference over the value of the reference"),
    "nusselt_pdf": ("PDF of the Nusselt number", "Wasserstein distance over the mean, all particles in all dumps"),
    "profile": ("axial temperature profile", "mean difference of the layers, over the range of the reference's"),
    "height": ("bed height", "difference over the value of the reference"),
    "fluctuation": ("pressure-drop fluctuation", "difference of the standard deviation, over that of the reference"),
}
HEAT = ("gas", "particles", "temperature", "nusselt", "nusselt_pdf", "profile")


class Error(namedtuple("Error", "value bar")):
    """A relative error and its bar."""

    @property
    def known(self):
        """What may be claimed: the error, or the bar where the error is less."""
        return max(self.value, self.bar)


def of_blocks(difference, scale):
    """Error of a mean from the differences of its blocks."""
    return Error(abs(np.mean(difference)) / scale,
                 CONFIDENCE * np.std(difference, ddof=1) / np.sqrt(len(difference)) / scale)


def of_means(run, reference, column, statistic):
    """Relative error of a statistic of a column of bed.csv, its bar from what each block of time has."""
    blocks = [record.blocks(column) for record in (run, reference)]
    value, scale = (statistic(b) for b in blocks)
    bar = of_blocks(statistic(blocks[0], axis=1) - statistic(blocks[1], axis=1), scale).bar
    return Error(abs(value - scale) / scale, bar)


def against_exact(run):
    """The fixed bed of Table 1: worst of the write times."""
    from validate_fixed_bed import errors  # knows the example's files

    rows = np.array(list(errors(run).values()))
    return {"gas": Error(rows[:, 0].max(), 0.0), "particles": Error(rows[:, 2].max(), 0.0)}


class Record:
    """What is compared of a run: bed.csv, and particle dumps `... x y z ... f_Temp f_Nusselt` where the case writes them."""

    def __init__(self, run):
        self.bed = results.bed(run)
        self.end = self.bed["time_s"][-1]
        self.start = 0.4 * self.end  # means in time are taken from here on: the start from a lattice is left out
        step = paraview.dem_timestep(run)
        self.dumps = {}
        for path in Path(run).glob("DEM/post/particles*.txt"):
            number = path.stem[len("particles"):]
            if number.isdigit() and int(number) * step >= self.start * (1 - 1e-9):
                self.dumps[round(int(number) * step, 9)] = path
        self.read = {}

    def has(self, column):
        return column in self.bed.dtype.names

    def column(self, name):
        """{time: values} of the dumps, empty where one has no such column."""
        for time, path in self.dumps.items():
            if time not in self.read:
                dump = paraview.read_dump(path) or {}
                self.read[time] = {c: dump[c] for c in ("z", "f_Temp", "f_Nusselt") if c in dump}
        complete = all(name in dump for dump in self.read.values())
        return {time: self.read[time][name] for time in sorted(self.read)} if complete else {}

    def blocks(self, column):
        """Values of bed.csv at even times (its lines are not), [BLOCKS, 200]."""
        times = np.linspace(self.start, self.end, 200 * BLOCKS)
        return np.interp(times, self.bed["time_s"], self.bed[column]).reshape(BLOCKS, 200)

    def changes(self):
        """Change of the mean particle temperature over each of BLOCKS equal spans. What happens once at the start, as when hot
        particles heat the cold gas around them in a millisecond, is left out: of a short run it would be most of the error."""
        edges = np.linspace(self.start, self.end, BLOCKS + 1)
        return np.diff(np.interp(edges, self.bed["time_s"], self.bed["T_mean_K"]))


def against_run(run, reference):
    """{figure: Error} of one Record against another; figures that the case does not have are left out."""
    errors = {}
    if reference.has("T_mean_K"):
        change = reference.changes()
        drop = abs(change.sum())
        if drop > 1e-6:
            total = of_blocks(run.changes() - change, drop)
            errors["temperature"] = Error(total.value * BLOCKS, total.bar * BLOCKS)
        errors["nusselt"] = of_means(run, reference, "Nu_mean", np.mean)
        pdf, profile = nusselt_pdf(run, reference), axial_profile(run, reference)
        errors.update({name: e for name, e in (("nusselt_pdf", pdf), ("profile", profile)) if e})
    if reference.has("height_m"):
        errors["height"] = of_means(run, reference, "height_m", np.mean)
        errors["fluctuation"] = of_means(run, reference, "pressure_drop_Pa", np.std)
    return errors


def of_repeats(records):
    """{figure: bar} from runs that should not differ: Student's factor times the root mean square of their differences."""
    pairs = [against_run(a, b) for a, b in itertools.combinations(records, 2)]
    return {f: student.ppf(0.975, len(records) - 1) * np.sqrt(np.mean([p[f].value**2 for p in pairs]))
            for f in (pairs[0] if pairs else ())}


def nusselt_pdf(run, reference):
    """Wasserstein distance of the Nusselt numbers of all particles in all dumps, over their mean. Bar: a run's even dumps
    against its odd ones, scaled from halves to wholes."""
    samples = [list(record.column("f_Nusselt").values()) for record in (run, reference)]
    if min(map(len, samples)) < 4:
        return None
    mean = np.concatenate(samples[1]).mean()
    noise = [wasserstein_distance(np.concatenate(s[::2]), np.concatenate(s[1::2])) for s in samples]
    distance = wasserstein_distance(*(np.concatenate(s) for s in samples))
    return Error(distance / mean, 2 * np.hypot(*noise) / 2 / mean)


def axial_profile(run, reference, layers=16):
    """Difference of the mean temperature of layers, weighted with the particles in them, over the range of the reference's
    layers. Bar: from blocks of dumps."""
    z, times = reference.column("z"), sorted(set(reference.column("f_Temp")) & set(run.column("f_Temp")))
    if len(times) < BLOCKS or not z or not run.column("z"):
        return None
    heights = np.concatenate(list(z.values()))
    edges = np.linspace(0, np.percentile(heights, 99), layers + 1)

    def profiles(record):
        """Mean of each layer in each block of dumps, nan where a layer is empty."""
        for block in np.array_split(times, BLOCKS):
            height, value = (np.concatenate([record.column(c)[t] for t in block]) for c in ("z", "f_Temp"))
            yield results.layer_means(height, value, edges)[0]

    own, theirs = (np.array(list(profiles(record))) for record in (run, reference))
    filled = np.isfinite(own + theirs).all(axis=0)
    if filled.sum() < 2:
        return None
    difference, weight = (own - theirs)[:, filled], np.histogram(heights, edges)[0][filled]
    scale = np.ptp(theirs[:, filled].mean(axis=0))
    bar = CONFIDENCE * np.std(difference, axis=0, ddof=1) / np.sqrt(BLOCKS)
    return Error(*(np.average(x, weights=weight) / scale for x in (abs(difference.mean(axis=0)), bar)))
