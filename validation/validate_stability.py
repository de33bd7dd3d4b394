"""Stiff and extreme scenes: each runs finite, bounded and conserving, or is refused with the reason and the number that would
work. `./hotbed validate stability [--quick] [--only TEXT]`: --quick takes fewer values of each kind, --only the rows whose name
holds TEXT.

The figure of a row is the largest of what was measured over its bound: energy not accounted for and mismatch of the exchange,
temperatures beyond those of inlet and start, particles lost, speed of the particles over three times the larger one of
interstitial inlet velocity (as hot as the hottest) and free fall from the top; infinite where a number is not finite or the run
failed. A row that is to be refused: texts that the error lacks.
"""

import argparse
import re
import shutil
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
import run as hotbed
from campaign import edit
from stability_scenes import FIXED_BED, GRAVITY, HOT_SPHERE, SLIM, scenes

BUDGET, MISMATCH, BEYOND, SPEED = 1e-8, 1e-12, 1e-9, 3.0
DIGIT = 2.0**-52


def solved(folder, scene):
    """@return (run folder, exit status, log)"""
    target = folder / re.sub(r"[^\w.=-]+", "_", scene.name)
    case = folder / "case"
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(scene.case, case)
    for file, pattern, replacement in scene.edits:
        edit(case / file, pattern, replacement)
    settings = {k: f"{v}" for k, v in scene.settings.items()}
    if scene.case != HOT_SPHERE:
        settings["writeInterval"] = settings["endTime"]
    hotbed.prepare(case, target, settings, ranks=scene.ranks, overwrite=True)
    code, log = finished(target, scene.ranks)
    if code == 0 and scene.then:
        for pattern, replacement in scene.then:
            edit(target / settings["endTime"] / "U", pattern, replacement)
        (target / "restart" / settings["endTime"] / "checksums").unlink()  # the change is meant
        hotbed.resume(target, {"endTime": f"{2 * float(settings['endTime'])}"}, scene.ranks)
        code, log = finished(target, scene.ranks)
    return target, code, log


def finished(target, ranks):
    code = hotbed.start(target, ranks).wait(timeout=600)
    return code, (target / "log.hotbedFoam").read_text(errors="replace")


def finite(target):
    """Whether every field of the last time and every particle of every snapshot is."""
    places = [p for p in [*target.iterdir(), *target.glob("processor*/*")] if re.fullmatch(r"[\d.e-]+", p.name) and p.name != "0"]
    texts = [f.read_text(errors="replace") for p in places for f in p.iterdir() if f.is_file()]
    texts += [p.read_text() for p in target.glob("DEM/post/particles*.txt")]
    return not any(re.search(r"(?i)(?<![a-z])[-+]?(nan|inf)(?![a-z])", text) for text in texts)


def fastest(target):
    """Largest speed of a particle in the snapshots [m/s]."""
    speed = 0.0
    for path in target.glob("DEM/post/particles*.txt"):
        rows = [line.split() for line in path.read_text().splitlines()[9:]]
        if rows:
            speed = max(speed, np.linalg.norm(np.array(rows, float)[:, 4:7], axis=1).max())
    return speed


def judged(target, scene):
    """@return what was measured over its bound, and a text"""
    if not finite(target):
        return np.inf, "a field or a particle is not finite"
    bed = results.bed(target)
    here = bed["particles"] > 0
    for column in bed.dtype.names:
        if not np.isfinite(bed[column][here]).all():
            return np.inf, f"{column} is not finite"
    # temperatures are kept in doubles: their last digit, once a step, is what a budget of next to no exchange can lack
    exchanged = max(bed["exchanged_J"][-1], 1e-300)
    held = np.abs(bed["gas_energy_J"]).max() + bed["particle_energy_J"].max()
    digit = len(bed) * DIGIT * held / exchanged
    low, high = scene.range
    beyond = max(low - bed["gas_T_min_K"].min(), bed["gas_T_max_K"].max() - high,
                 low - bed["T_min_K"][here].min(), bed["T_max_K"][here].max() - high, 0.0)
    lost = bed["particles"].max() - bed["particles"][-1]
    budget = abs(bed["budget_error"][-1])
    worst = {"energy": budget / max(BUDGET, digit), "mismatch": bed["mismatch"].max() / MISMATCH, "temperature": beyond / BEYOND}
    text = f"energy {budget:.0e}, mismatch {bed['mismatch'].max():.0e}, beyond {beyond:.0e} K"
    if scene.leaves:
        worst["left"] = 0.0 if (lost == bed["particles"].max() if scene.leaves == "all" else lost > 0) else np.inf
        text += f", {lost:.0f} of {bed['particles'].max():.0f} left"
    else:
        worst["lost"] = np.inf if lost else 0.0
    if scene.case not in (FIXED_BED, HOT_SPHERE):
        s = {**SLIM, **scene.settings}
        inlet = float(s.get("u0", 0.2)) / 0.4 * high / low
        bound = SPEED * max(inlet, np.sqrt(2 * GRAVITY * float(s["height"])), scene.speed)
        speed = fastest(target)
        worst["speed"] = speed / bound
        text += f", {speed:.2g} of {bound:.2g} m/s, overlap {bed['overlap_max'].max():.0e}"
    name = max(worst, key=worst.get)
    return worst[name], text + ("" if worst[name] <= 1 else f"  <- {name}")


def row(figures, folder, scene):
    try:
        target, code, log = solved(folder, scene)
    except hotbed.CaseError as problem:
        figures.add(scene.name, np.inf, 1, str(problem).splitlines()[0])
        return
    if scene.refused:
        lacking = [text for text in ("ERROR", *scene.refused) if text not in log]
        fine = code != 0 and "Time = " not in log
        figures.add(scene.name + ", refused", len(lacking) if fine else np.inf, 0,
                    " ".join(re.findall(r"ERROR: *\n?(.*)", log)[:1])[:240] or f"exit status {code}")
        return
    if code != 0:
        reached = re.findall(r"(?m)^Time = (\S+)", log)
        why = re.findall(r"ERROR.*|Foam::sigFpe|FOAM FATAL.*", log)
        figures.add(scene.name, np.inf, 1, f"exit status {code} at {reached[-1] if reached else 'the start'}: {why[:1]}")
        return
    value, text = judged(target, scene)
    if scene.warned and not all(text in log for text in ("WARNING", *scene.warned)):
        value, text = np.inf, "the warning is missing"
    figures.add(scene.name, value, 1, text)


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate stability", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer values of each kind")
    parser.add_argument("--only", default="", help="rows whose name holds this")
    options = parser.parse_args()
    figures = results.Figures("stability")
    folder = Path("results") / "stability" / ("validate-quick" if options.quick else "validate")
    folder.mkdir(parents=True, exist_ok=True)
    for scene in scenes():
        if (scene.quick or not options.quick) and options.only in scene.name:
            row(figures, folder, scene)
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
