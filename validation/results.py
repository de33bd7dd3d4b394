"""Reading a run's results, and the lines and files in which figures are reported."""

import json
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from numpy.lib.recfunctions import repack_fields


def field(path):
    """Internal values of an ASCII OpenFOAM field, [cells] or [cells, 3]."""
    text = Path(path).read_text()
    head = re.search(r"internalField\s+nonuniform\s+List<(\w+)>\s*(\d+)\s*\(", text)
    if not head:
        raise ValueError(f"{path}: no nonuniform internalField")
    values = text[head.end():text.index("\n)", head.end())]
    if head[1] == "vector":
        return np.array(values.replace("(", " ").replace(")", " ").split(), float).reshape(-1, 3)
    return np.array(values.split(), float)


def layers(path):
    """Profiles that LIGGGHTS' fix ave/spatial wrote: step -> array [bins, 3] of height, particles, mean value."""
    profiles, rows = {}, None
    for line in Path(path).read_text().splitlines():
        word = line.split()
        if line.startswith("#") or not word:
            continue
        if len(word) == 2:
            rows = profiles.setdefault(int(word[0]), [])
        else:
            rows.append([float(w) for w in word[1:4]])
    return {step: np.array([r for r in rows if r[1] > 0]) for step, rows in profiles.items()}


def layer_means(heights, values, edges):
    """Mean of a quantity of the particles in each layer. @return (mean, nan where there are none; particles), [layers]"""
    count = np.histogram(heights, edges)[0]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.histogram(heights, edges, weights=values)[0] / count, count


def bed(run):
    """bed.csv of a run as a structured array; where the run was stopped and went on, one piece after the other, with the columns
    that all of them have. A line that a killed run left unfinished is dropped. Raises ValueError where there is none."""
    paths = sorted(Path(run).glob("postProcessing/hotbed/*/bed.csv"), key=lambda p: float(p.parent.name))
    pieces = []
    for path in paths:
        whole = [line for line in path.read_text().splitlines(keepends=True) if line.endswith("\n")]
        if whole:
            pieces.append((float(path.parent.name), np.atleast_1d(np.genfromtxt(whole, delimiter=",", names=True))))
    if not pieces:
        raise ValueError(f"{run} has no line in postProcessing/hotbed/*/bed.csv")
    ends = [start for start, _ in pieces[1:]] + [np.inf]
    pieces = [piece[piece["time_s"] < end * (1 + 1e-9)] for (_, piece), end in zip(pieces, ends)]
    columns = [name for name in pieces[0].dtype.names if all(name in piece.dtype.names for piece in pieces)]
    return np.concatenate([repack_fields(piece[columns]) for piece in pieces])


def timing(run):
    """phase -> mean seconds a step, from the table that closes the log; parts of phases are left out; with `memory` in MiB."""
    text = (Path(run) / "log.hotbedFoam").read_text()
    table = {m[1].strip(): float(m[2]) for m in
             re.finditer(r"(?m)^    (\S.{27})\s*[\d.]+\s+[\d.]+\s+([\d.]+)\s+[\d.]+ %$", text)}
    table["memory"] = float(re.search(r"peak memory of a rank\s+([\d.]+) MiB", text)[1])
    return table


def between(short, long):
    """As `timing`, of the steps that one of two runs from the same state has more than the other: without its first ones."""
    steps = [int(re.search(r"(?m)^Timing \(.* (\d+) steps\)", (Path(run) / "log.hotbedFoam").read_text())[1])
             for run in (short, long)]
    a, b = timing(short), timing(long)
    return {phase: (steps[1] * b[phase] - steps[0] * a[phase]) / (steps[1] - steps[0]) for phase in b if phase != "memory"}


def loop_time(phases):
    """Seconds a step of all phases of the time loop, from what `timing` or `between` gives."""
    return sum(v for k, v in phases.items() if k not in ("DEM set-up", "everything else", "whole run", "memory"))


def exchange_time(phases):
    """Of that what is between gas and particles: weights, voidage, closures, exchange, their messages."""
    return loop_time(phases) - phases["gas"] - phases["DEM"] - phases.get("output", 0.0)


def evaluated(log):
    """Part of the gas steps in which closures were evaluated. @param log  text of a log"""
    found = re.search(r"closures evaluated +(\S+) % of the gas steps", log)
    return float(found[1]) / 100 if found else 1.0


def processor_times(log):
    """Processor seconds at the end of each time step, from the ExecutionTime lines of an OpenFOAM solver's log."""
    return [float(t) for t in re.findall(r"(?m)^ExecutionTime = (\S+) s", Path(log).read_text())]


def seconds_a_step(log, skip):
    """Processor seconds a time step, the first `skip` steps left out."""
    times = processor_times(log)
    return (times[-1] - times[skip - 1]) / (len(times) - skip)


def wall_time(run):
    """Seconds from the start of the solver to its end, from the table that closes the log."""
    return float(re.search(r"(?m)^    whole run\s+([\d.]+)", (Path(run) / "log.hotbedFoam").read_text())[1])


class Figures:
    """Collects figures `name value bound PASS|FAIL`, prints each, writes results/NAME.json at the end."""

    def __init__(self, name, folder=Path("results"), verb="validate"):
        self.name, self.folder, self.verb, self.rows, self.kept, self.begin = name, Path(folder), verb, [], [], time.time()

    def add(self, name, value, bound, text=None, least=False):
        """A figure that must not exceed its bound, or with `least` not fall below it (nan fails)."""
        passed = bool(value >= bound if least else value <= bound)
        self.rows.append({"name": name, "value": float(value), "bound": float(bound), "pass": passed})
        print(f"{name:68s} {value:10.3e} {('>= %.3g' if least else '<= %.3g') % bound:>12s} {'PASS' if passed else 'FAIL'}"
              f"{'  ' + text if text else ''}", flush=True)

    def note(self, name, value):
        """Something measured that has no bound."""
        self.rows.append({"name": name, "value": value})
        print(f"{name:68s} {value if isinstance(value, str) else '%.4g' % value}", flush=True)

    def path(self):
        """Of the JSON."""
        suffix = "-quick" if "--quick" in sys.argv else ""
        prefix = "bench_" if self.verb == "bench" else ""
        return self.folder / f"{prefix}{self.name}{suffix}.json"

    def keep(self, starts):
        """Figures of the last time that have not been made anew, with their date. @param starts  what their names start with"""
        if not self.path().is_file():
            return
        before, made = json.loads(self.path().read_text()), {row["name"] for row in self.rows}
        self.kept = [{"date": before["date"], **row} for row in before["figures"]
                     if row["name"].startswith(starts) and row["name"] not in made]

    def close(self):
        """Writes the JSON; @return exit status."""
        failed = [r for r in self.rows if r.get("pass") is False]
        self.folder.mkdir(parents=True, exist_ok=True)
        script = Path(sys.argv[0]).stem.removeprefix(f"{self.verb}_")
        record = {"command": "./hotbed " + " ".join([self.verb, script, *sys.argv[1:]]), "versions": versions(),
                  "machine": machine(), "date": time.strftime("%Y-%m-%d"), "seconds": round(time.time() - self.begin),
                  "figures": self.rows + self.kept}
        self.path().write_text(json.dumps(record, indent=1) + "\n")
        print(f"{len(self.rows) - len(failed)} figures fine, {len(failed)} failed; written to {self.path()}")
        return 1 if failed else 0


def versions():
    """Package versions that the figures were made with, and Hotbed's own."""
    out = subprocess.run(["dpkg-query", "-W", "-f", "${Package} ${Version}\n", "libopenfoam", "libliggghts3",
                          "libopenmpi3"], capture_output=True, text=True).stdout
    versions = dict(line.split() for line in out.splitlines())
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=Path(__file__).parent,
                            capture_output=True, text=True).stdout.strip()
    return {**versions, "hotbed": commit}


def machine():
    """Model of the processor."""
    found = re.search(r"model name\s*:\s*(.*)", Path("/proc/cpuinfo").read_text())
    return found[1] if found else "unknown"
