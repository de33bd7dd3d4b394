"""What the folder of one run tells of it, finished, stopped or still going, for its page: `./hotbed report RUN`."""

import json
import os
import re
import socket
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import paraview
import results
from check import entry, refusal
from follow import COMMAND, ending, stopped
from run import CaseError, read_settings

FROM = 0.4  # means in time leave out this share of the run, as those of the error against run time do


@dataclass
class Piece:
    """One log of a run, which may have been stopped and gone on.

    steps     [n, 3]: time at the end of a gas step [s], Courant number, DEM steps
    warnings  texts of OpenFOAM's and Hotbed's own
    wall      [s], from the closing table; of a piece that was cut off what its last step tells
    """
    steps: np.ndarray
    warnings: list
    wall: float


def read_log(path):
    """@return Piece"""
    steps, found, wall, open_warning = [], [], 0.0, False
    with open(path, errors="replace") as file:
        for line in file:
            if open_warning:
                if open_warning := line.startswith("    "):
                    if not re.match(r"    (From|in file) ", line):
                        found[-1] = f"{found[-1]} {line.strip()}".strip()
            elif line.startswith("Time = "):
                step = re.match(r"Time = (\S+)  Courant (\S+)  DEM steps (\d+)\n", line)
                if step:
                    steps.append([float(word) for word in step.groups()])
            elif line.startswith("ExecutionTime"):
                wall = float(line.split()[6])
            elif "--> FOAM" in line and "Warning" in line:
                open_warning = True
                found.append("")
    closed = re.search(r"(?m)^    whole run\s+([\d.]+)", ending(path))
    return Piece(np.array(steps).reshape(-1, 3), found, float(closed[1]) if closed else wall)


def logs(run):
    """Logs of all pieces, the last one at the end."""
    earlier = [p for p in run.glob("log.hotbedFoam.*") if p.suffix[1:].isdigit()]
    return [*sorted(earlier, key=lambda p: int(p.suffix[1:])), run / "log.hotbedFoam"]


def going(head):
    """Whether the solver that wrote a log's head still runs on this machine."""
    found = {name: re.search(rf"(?m)^{name}\s+: (\S+)", head) for name in ("Host", "PID")}
    if not all(found.values()) or found["Host"][1] != socket.gethostname():
        return False
    try:
        return Path(os.readlink(f"/proc/{found['PID'][1]}/exe")).name.startswith("hotbedFoam")
    except OSError:
        return False


def state(run, head, end, reached):
    """(finished, stopped, failed, going or ended; a sentence)"""
    text, last = ending(run / "log.hotbedFoam"), f"{reached:.6g} of {end:.6g} s"
    restarts = sorted((float(p.parent.name), p.parent.name) for p in run.glob("restart/*/state"))
    again = (f" It goes on from its restart of {restarts[-1][1]} s: the command that started it, with --restart." if restarts
             else " It holds no restart to go on from.")
    if "FATAL" in text:
        return "failed", f"Failed at {last}: {refusal(text).rstrip('.')}." + again
    if found := stopped(run / "log.hotbedFoam"):
        return "stopped", f"Stopped by signal {found[0]} at {last}." + again
    if "\nEnd\n" in text:
        if reached > end * (1 - 1e-6):
            return "finished", f"Finished: {reached:.6g} s simulated."
        return "stopped", f"Ended at {last}, as its controlDict says." + again
    if going(head):
        return "going", f"Still going: {last} so far; what follows is what there is by now."
    return "ended", f"Ended without a word at {last}: killed, or cut off from here." + again


def dumps(run):
    """{time [s]: file} of the series of particle dumps with the most snapshots, empty where the script dumps none."""
    step, series = paraview.dem_timestep(run), {}
    for path in run.glob("DEM/post/*.txt"):
        if (named := re.fullmatch(r"(.*?)(\d+)", path.stem)) and step:
            series.setdefault(named[1], {})[round(int(named[2]) * step, 9)] = path
    return max(series.values(), key=len, default={})


def timing(text):
    """Rows of the table that closes a log: phase, whether it is a part of the one before, mean and largest of the ranks [s], of
    a step [s], share."""
    return [{"phase": m[2].strip(), "part": bool(m[1]), "mean_s": float(m[3]), "largest_s": float(m[4]),
             "a_step_s": float(m[5]), "share": float(m[6]) / 100}
            for m in re.finditer(r"(?m)^    (  )?(\S.*?)\s{2,}([\d.]+)\s+([\d.]+)\s+([\d.]+)\s+([\d.]+) %$", text)]


def speed(text):
    """The lines below that table, name -> text."""
    below = text[text.rfind("    whole run"):]
    return {m[1].strip(): m[2].strip() for m in re.finditer(r"(?m)^    (\S.*?)\s{2,}(\d[^%\n]*)$", below)}


def shortened(text):
    """Six digits of each number."""
    return re.sub(r"-?\d+\.\d{6,}(?:e[+-]\d+)?", lambda m: f"{float(m[0]):.6g}", text)


def budget(text):
    """What the log says between the last step and the timing table, (name, text) a line; digits that mean nothing left out."""
    end = text.rfind("\nTiming (")
    if end < 0:
        return []
    lines = text[:end].splitlines()
    last = max((n for n, line in enumerate(lines) if re.match("ExecutionTime|Time =|.*No Iterations|Stopped", line)), default=0)
    lines = [line for line in lines[last + 1:] if line.strip()]
    short = map(shortened, lines)
    return [(m[1], m[2]) if (m := re.fullmatch(r"(\s*\S.*?)\s{2,}(-?\d.*)", line)) else (line, "") for line in short]


def over_time(bed, column):
    """Mean of a column of bed.csv over time, without the first part of the run; None where there is none."""
    if bed is None or column not in bed.dtype.names:
        return None
    late = (bed["time_s"] >= FROM * bed["time_s"][-1]) & np.isfinite(bed[column])
    time, values = bed["time_s"][late], bed[column][late]
    return None if not len(time) else float(values[0]) if len(time) < 2 else float(np.trapz(values, time) / np.ptp(time))


def figures(run, bed, steps):
    """name -> value; only what the run has."""
    found = {"simulated_s": float(steps[-1, 0]) if len(steps) else 0.0, "gas_steps": len(steps)}
    if len(steps):
        lengths = np.diff(steps[:, 0], prepend=0.0) if len(steps) > 1 else steps[:, 0]
        found.update(dem_steps=int(steps[:, 2].sum()), gas_step_mean_s=float(lengths.mean()),
                     courant_mean=float(np.average(steps[:, 1], weights=lengths)), courant_largest=float(steps[:, 1].max()))
    if bed is None:
        return found
    found["particles"] = int(bed["particles"][-1])
    for column, name in (("pressure_drop_Pa", "pressure_drop_mean_Pa"), ("weight_Pa", "weight_mean_Pa"),
                         ("height_m", "height_mean_m"), ("Nu_mean", "nusselt_mean")):
        if (value := over_time(bed, column)) is not None:
            found[name] = value
    for column, name, choose in (("overlap_max", "overlap_largest", np.nanmax), ("mismatch", "mismatch", np.nanmax)):
        if column in bed.dtype.names:
            found[name] = float(choose(bed[column]))
    for column, name in (("T_mean_K", "temperature_mean_K"), ("T_min_K", "temperature_lowest_K"),
                         ("T_max_K", "temperature_highest_K"), ("exchanged_J", "exchanged_J"),
                         ("budget_error", "energy_not_accounted_for"), ("momentum_error", "momentum_not_accounted_for")):
        if column in bed.dtype.names:
            known = bed[column][np.isfinite(bed[column])]
            if len(known):
                found[name] = float(known[-1])
    return found


def bed_of(run):
    """bed.csv, None before its first line."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numpy's, of a file that has only its head
        try:
            bed = results.bed(run)
        except ValueError:
            return None
    return bed if bed.dtype.names and len(bed) else None


def read(run):
    """Everything the page tells, as numbers and texts; `bed` and `steps` are arrays. CaseError where the folder holds no run."""
    run = Path(run).resolve()
    missing = [name for name in ("system/controlDict", "log.hotbedFoam") if not (run / name).is_file()]
    if missing:
        raise CaseError(f"{run} holds no run: {' and '.join(missing)} {'are' if missing[1:] else 'is'} missing there; "
                        f"{COMMAND} run CASE makes one, under results/<case>/<what --set says>")
    with open(run / "log.hotbedFoam", errors="replace") as file:
        head = file.read(30000)
    files, text = logs(run), ending(run / "log.hotbedFoam")
    pieces = [read_log(path) for path in files]
    steps = pieces[-1].steps
    for piece in reversed(pieces[:-1]):
        # what a later piece computes anew counts once
        steps = np.concatenate([piece.steps[piece.steps[:, 0] < steps[0, 0] * (1 - 1e-9)] if len(steps) else piece.steps, steps])
    bed, end = bed_of(run), float(entry(run, "endTime") or "nan")
    reached = max(float(steps[-1, 0]) if len(steps) else 0.0, float(bed["time_s"][-1]) if bed is not None else 0.0)
    word, sentence = state(run, head, end, reached)
    lines = (run / "settings").read_text().splitlines() if (run / "settings").is_file() else []
    comment = {m[1]: m[2] for line in lines if (m := re.match(r"\s*(\w+)\s+[^;]*;\s*//\s*(.*)", line))}
    case = re.search(r"(?m)^Case\n((?:    .*\n)+)", head)
    versions = re.search(r"(?m)^Hotbed (\S+).*\n((?:    .*\n)*)", head)
    liggghts = [re.sub(r" \(\S+\)$", "", w) for p in sorted(run.glob("log.liggghts*"))
                for w in re.findall(r"(?m)^WARNING: (.*)$", p.read_text(errors="replace"))]
    said = [w for piece in pieces for w in piece.warnings] + [f"LIGGGHTS: {w}" for w in liggghts]
    ranks = re.search(r"(?m)^nProcs : (\d+)", head)
    return {
        "name": run.parent.name, "label": run.name, "folder": str(run), "state": word, "sentence": sentence, "end_s": end,
        "ranks": int(ranks[1]) if ranks else None, "pieces": len(pieces), "wall_s": sum(p.wall for p in pieces),
        "date": m[1] if (m := re.search(r"(?m)^Date   : (.*)$", head)) else None,
        "versions": {"Hotbed": versions[1], **pairs(versions[2])} if versions else {},
        "case": pairs(shortened(case[1])) if case else {},
        "settings": [{"name": n, "value": v, "meaning": comment.get(n, "")} for n, v in entries(run / "settings").items()],
        "coupling": entries(run / "constant/couplingProperties"),
        "figures": figures(run, bed, steps), "budget": budget(text),
        "timing": timing(text[max(text.rfind("\nTiming ("), 0):]) if "\nTiming (" in text else [],
        "speed": speed(text) if "    whole run" in text else {},
        "warnings": {w: said.count(w) for w in dict.fromkeys(said)},
        "files": {name: (run / name).exists() for name in ("particles.pvd", "gas.pvd", "restart", "postProcessing/hotbed")},
        "bed": bed, "steps": steps,
    }


def entries(path):
    """name -> text of the entries of a dictionary, without its head; empty where it is missing."""
    known = read_settings(path) if path.is_file() else {}
    return {name: value for name, value in known.items() if name not in ("FoamFile", "version", "format", "class", "object")}


def pairs(text):
    """`    name   value` a line, as the log writes what runs and what the case is."""
    return {m[1]: m[2].strip() for m in re.finditer(r"(?m)^    (\S.*?)\s{2,}(.*)$", text)}


def write(folder):
    """Writes report.html and report.json into the folder of a run. @return path of the page"""
    import report_run_page  # draws

    run = read(folder)
    page = report_run_page.write(run, dumps(Path(run["folder"])))
    plain = {name: value for name, value in run.items() if name not in ("bed", "steps")}
    Path(run["folder"], "report.json").write_text(json.dumps(plain, indent=1) + "\n")
    return page
