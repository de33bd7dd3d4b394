"""Long runs in pieces: each goes on from its last restart where it was stopped."""

import re
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from scipy.stats import t as student

import results
import run as hotbed
from follow import stopped


def edit(path, pattern, replacement):
    """Replaces a regular expression (lines begin at ^, end at $) in a file of a case; it must be there."""
    path = Path(path)
    text, found = re.subn(pattern, replacement, path.read_text(), flags=re.M)
    if not found:
        raise ValueError(f"{path}: nothing matches {pattern}")
    path.write_text(text)


NUDGES = (1, 1 + 1e-6, 1 - 1e-6, 1 + 2e-6, 1 - 2e-6)  # of a velocity, for repeats of a run
COMMON = ("endTime", "writeInterval")  # of all runs of a campaign


def name(settings):
    """Folder of a run: its settings but for those that all have in common."""
    return ",".join(f"{k}={v}" for k, v in settings.items() if k not in COMMON) or "default"


def reached(folder):
    """Simulated time of the last restart [s], 0 without one."""
    return max((float(state.parent.name) for state in Path(folder).glob("restart/*/state")), default=0.0)


def ended(folder, end=None):
    """Whether a folder holds a run that came to its end: the table that closes the log is there, and no signal before it.
    @param end  that it was to reach [s], as near as whole steps come; a `stopAt` that was set while it ran ends it before"""
    log = Path(folder) / "log.hotbedFoam"
    if not log.is_file() or "\n    whole run" not in hotbed.ending(log) or stopped(log):
        return False
    times = [0.0, *(float(t) for t in re.findall(r"(?m)^Time = (\S+)", hotbed.ending(log)))]
    return end is None or times[-1] >= end - 0.51 * np.diff(times[-2:]).sum()


def done(folder, settings):
    """Whether a folder holds a run with these settings, or a longer one."""
    end = float(settings.get("endTime", "inf"))
    if reached(folder) >= end * (1 - 1e-6):
        return True
    file = Path(folder) / "settings"
    have = hotbed.read_settings(file).get("endTime", "inf") if file.is_file() else "inf"
    return float(have) >= end * (1 - 1e-6) and ended(folder, end if end < float("inf") else None)


def run_all(case, folder, runs, at_once=2, ranks=1, keep_going=False):
    """Runs cases with each of the settings in `runs`, `at_once` at a time, as far as they are not done yet.

    @param keep_going  a run that fails is told and left out
    @return folders of the runs, None for one that failed
    """
    def one(settings):
        target = Path(folder) / name(settings)
        if done(target, settings):
            return target
        try:
            if reached(target) > 0:
                hotbed.resume(target, settings, ranks)
            else:
                hotbed.prepare(case, target, settings, ranks=ranks, overwrite=True)
            hotbed.run_case(target, ranks)
        except hotbed.CaseError as problem:
            if not keep_going:
                raise
            print(f"left out: {problem}", file=sys.stderr)
            return None
        print(f"done: {target.name}, {results.wall_time(target):.0f} s", flush=True)
        return target

    with ThreadPoolExecutor(at_once) as pool:
        return list(pool.map(one, runs))


def branch(case, source, target, settings, ranks=1):
    """Runs a case from the last restart of another run of it, which came to its end and stays as it is, with settings and on
    a number of ranks of its own. @param target  folder of the new run, made anew"""
    name = max((state.parent.name for state in Path(source).glob("restart/*/state")), key=float)
    hotbed.prepare(case, target, settings, overwrite=True)
    for part in (name, f"restart/{name}"):
        shutil.copytree(Path(source) / part, Path(target) / part)
    checksums = Path(target) / "restart" / name / "checksums"
    kept = [line for line in checksums.read_text().splitlines(keepends=True) if "  restart/" in line]
    checksums.write_text("".join(kept))  # the others are of the fields of each rank
    hotbed.resume(target, ranks=ranks)
    hotbed.run_case(target, ranks)


def mean(bed, column, start, end, blocks=5):
    """Mean of a column of bed.csv over time, and its standard error from the means of blocks of time."""
    edges = np.linspace(start, end, blocks + 1)
    time = bed["time_s"]
    values = [np.trapz(bed[column][inside], time[inside]) / np.ptp(time[inside])
              for inside in ((time >= a) & (time <= b) for a, b in zip(edges, edges[1:]))]
    return np.mean(values), np.std(values, ddof=1) / np.sqrt(blocks)


def acceleration(bed, start, end):
    """Mean acceleration of the particles' centre of mass, upwards [m/s2]."""
    speed = np.interp([start, end], bed["time_s"], np.gradient(bed["z_mean_m"], bed["time_s"]))
    return (speed[1] - speed[0]) / (end - start)


def spread(groups):
    """Standard deviation of a run from runs that differ by nothing that matters, pooled.

    @param groups  arrays [repeats, ...]
    @return (deviation [...], degrees of freedom)
    """
    freedom = sum(len(g) - 1 for g in groups)
    squares = sum(((g - g.mean(axis=0))**2).sum(axis=0) for g in groups)
    return np.sqrt(squares / freedom), freedom


def bar(deviation, freedom, *repeats):
    """Half-width of the 95 % confidence interval of a mean of so many repeats, or of the difference of two such means."""
    return student.ppf(0.975, freedom) * deviation * np.sqrt(sum(1 / n for n in repeats))


def bar_from_blocks(*errors, blocks=5):
    """The same of the difference of two means of runs. @param errors  for each mean, those of `mean` of its runs"""
    error = np.sqrt(sum(np.sum(np.square(e)) / len(e)**2 for e in errors))
    return student.ppf(0.975, (blocks - 1) * sum(len(e) for e in errors)) * error


def bar_of_difference(a, b):
    """Half-width of the 95 % confidence interval of the difference of the means of two sets of runs that scatter each in their own
    way (Welch)."""
    share = np.array([np.var(v, ddof=1) / len(v) for v in (a, b)])
    freedom = share.sum()**2 / (share**2 / (np.array([len(a), len(b)]) - 1)).sum()
    return student.ppf(0.975, freedom) * np.sqrt(share.sum())
