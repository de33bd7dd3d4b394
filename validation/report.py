"""The page of a run, `./hotbed report RUN` (report_run.py), or error against run time: which settings are worth their cost,
`./hotbed report CASE [--quick]`.

CASE is fixed_bed or slim_bed, with variations ready, or the folder of any case with --vary. Each run's errors are taken against
the finest run (the fixed bed's against the exact solution). Writes results/report/CASE/index.html (one file, works offline),
report.json and the pictures; runs that are there already are not repeated. See docs/report.md.
"""

import argparse
import hashlib
import itertools
import json
import re
import shlex
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "examples"
sys.path[:0] = [str(ROOT / "cfd_solver"), str(EXAMPLES / "fixed_bed")]
import campaign
import paraview
import report_errors
import report_page
import report_run
import results
from run import CaseError, place, read_settings

# of these the smallest value is the finest
FINER_IF_SMALLER = ("l", "deltaT", "maxDeltaT", "maxCo", "deltaTDEM")


def vary(name, *values, **others):
    """Runs that differ in one number, and have `others` in common."""
    return [{name: value, **others} for value in values]


# for all runs; group -> runs, each by what it changes; finest run, None for an exact solution
FIXED_BED = {
    "common": {}, "reference": None,
    "groups": {
        "as the case stands": [{}],
        "ratio l": vary("l", "1", "1.5", "2.5"),
        "gas step": vary("deltaT", "1.25e-3", "5e-3", "1e-2", "2e-2"),
        "plain exchange": vary("deltaT", "1.25e-3", "2.5e-3", "5e-3", "1e-2", "2e-2", exchange="implicit"),
        "plain reading": vary("l", "1", "1.5", "2", "2.5", temperatureGradient="off"),
        "kernel": vary("kernelWidth", "2", "4") + vary("windowLength", "1.5e-3", "4e-3"),
        "cells": vary("cellsHeight", "50", "200"),
        "cells, plain exchange": vary("cellsHeight", "200", exchange="implicit"),
        "several": [{"l": "2.5", "deltaT": "1e-2"}, {"l": "2.5", "deltaT": "1e-2", "cellsHeight": "50"}],
    },
}
FIXED_BED_QUICK = {**FIXED_BED, "common": {"height": "0.075", "cellsHeight": "50", "endTime": "1.5", "writeInterval": "0.5"},
                   "groups": {**FIXED_BED["groups"], "cells": vary("cellsHeight", "25", "100"),
                              "cells, plain exchange": vary("cellsHeight", "100", exchange="implicit"),
                              "several": [{"l": "2.5", "deltaT": "1e-2"},
                                          {"l": "2.5", "deltaT": "1e-2", "cellsHeight": "25"}]}}
REPEATS = vary("u0", "0.2000002", "0.1999998")  # means nothing, but a chaotic bed takes another course
SLIM_BED = {
    "common": {"endTime": "0.5", "writeInterval": "0.02"}, "reference": {"l": "1"},
    "groups": {
        "as the case stands": [{}],
        "repeat": REPEATS,
        "ratio l": vary("l", "1.5", "2.5", "3"),
        "gas step": vary("maxDeltaT", "5e-5", "1e-4", "4e-4") + vary("maxCo", "0.25", "1", maxDeltaT="8e-4"),
        "DEM step": vary("deltaTDEM", "1.25e-6", "5e-6"),
        "stiffness": [{"kn": "125", "deltaTDEM": "5e-6"}, {"kn": "50", "deltaTDEM": "6.25e-6"}],
        "kernel": vary("kernelWidth", "2", "4") + vary("windowLength", "1.5e-3", "4.5e-3"),
        "plain exchange": [{"exchange": "implicit"}],
        "plain reading": vary("temperatureGradient", "off"),
        "several": [{"l": "2.5", "kn": "50", "deltaTDEM": "6.25e-6", "maxDeltaT": "4e-4"}],
    },
}
SLIM_BED_QUICK = {
    "common": {"endTime": "0.25", "writeInterval": "0.01"}, "reference": {"l": "1.5"},
    "groups": {
        "as the case stands": [{}],
        "repeat": REPEATS,
        "ratio l": vary("l", "2.5"),
        "gas step": vary("maxDeltaT", "4e-4"),
        "DEM step": vary("deltaTDEM", "5e-6"),
        "stiffness": [{"kn": "50", "deltaTDEM": "6.25e-6"}],
        "kernel": vary("kernelWidth", "2"),
        "plain exchange": [{"exchange": "implicit"}],
        "plain reading": vary("temperatureGradient", "off"),
    },
}
SCENES = {"fixed_bed": (FIXED_BED, FIXED_BED_QUICK), "slim_bed": (SLIM_BED, SLIM_BED_QUICK)}


def pairs(items):
    """name=value ... as a dictionary."""
    for item in items:
        if not all(item.partition("=")):
            raise CaseError(f"{item}: write name=value")
    return dict(item.split("=", 1) for item in items)


def own_scene(case, common, varied, product, repeats):
    """A scene of the variations on the command line: each alone, or all combinations. Reference: the finest of the values."""
    values = {name: text.split(",") for name, text in pairs(varied).items()}
    for name in {*values, *pairs(repeats)} & set(campaign.COMMON):
        raise CaseError(f"{name} is the same for all runs of a report: --set {name}=..., not --vary or --repeat")
    groups = {"as the case stands": [{}],
              "repeat": [r for name, text in pairs(repeats).items() for r in vary(name, *text.split(","))]}
    if product:
        groups["combinations"] = [dict(zip(values, some)) for some in itertools.product(*values.values())]
    else:
        groups.update({name: vary(name, *some) for name, some in values.items()})
    finest = {}
    for name in (name for name in values if name in FINER_IF_SMALLER):
        now = common.get(name) or read_settings(case / place(case, name))[name]
        finest[name] = min(values[name] + [now], key=float)
    return {"common": common, "reference": finest, "groups": groups}


def runs_of(case, scene):
    """The runs of a scene [{group, changes}], reference first; without what the case has anyway, and each once."""
    def reduced(changes):
        has = {n: read_settings(case / place(case, n)).get(n) for n in changes}
        return {n: v for n, v in changes.items() if v != scene["common"].get(n, has[n])}

    listed = [] if scene["reference"] is None else [("reference", scene["reference"])]
    listed += [(group, changes) for group, members in scene["groups"].items() for changes in members]
    rows, seen = [], []
    for group, changes in listed:
        changes = reduced(changes)
        if changes not in seen:
            seen.append(changes)
            rows.append({"group": group, "changes": changes})
    return rows


def fingerprint(case, common):
    """Of what all runs take from the case and have in common: runs of an edited case are other runs."""
    digest = hashlib.sha256(repr(sorted(common.items())).encode())
    for path in sorted(p for folder in ("0", "constant", "system", "DEM", "settings") for p in
                       ([case / folder] if (case / folder).is_file() else (case / folder).rglob("*"))):
        if path.is_file() and "post" not in path.parts:
            digest.update(str(path.relative_to(case)).encode() + path.read_bytes())
    return digest.hexdigest()[:8]


def run_seconds(folder):
    """Wall time of a run; one that was stopped and went on: that of its last piece, for its whole length."""
    end = results.bed(folder)["time_s"][-1]
    begin = max(float(p.name) for p in folder.glob("postProcessing/hotbed/*"))
    return results.wall_time(folder) * end / (end - begin)


def contact_steps(folder):
    """DEM steps in a contact of two original particles, None where the script does not say in the examples' way."""
    script = "\n".join(p.read_text() for p in sorted(folder.glob("DEM/in.*")))
    settings = folder / "settings"
    for name, value in (read_settings(settings) if settings.is_file() else {}).items():
        script = script.replace(f"${{{name}}}", value)
    size = re.search(r"hotbed/coarsegrain .*diameter\s+(\S+)\s+density\s+(\S+)", script)
    constants = [re.search(rf"\b{name} peratomtypepair 1 (\S+)", script) for name in ("kn", "coefficientRestitution")]
    if not size or not all(constants):
        return None
    k, e = (float(c[1]) for c in constants)
    mass = np.pi / 6 * float(size[1])**3 * float(size[2])
    return np.sqrt(mass / (2 * k) * (np.pi**2 + np.log(e)**2)) / paraview.dem_timestep(folder)


def cheapest(rows, bound, figures):
    """The run of least time whose errors of these figures are all known to be within a bound."""
    fine = [r for r in rows if r["choice"] and all(r["errors"][f].known <= bound for f in figures)]
    return min(fine, key=lambda r: r["seconds"], default=None)


def evaluate(rows, exact):
    """Times and errors of the runs that did not fail. @return (figures that all of them have, those of heat)"""
    done = [r for r in rows if r["folder"]]
    if not exact and rows[0]["folder"] is None:
        raise CaseError("the reference run failed, see above")
    reference = None if exact else report_errors.Record(rows[0]["folder"])
    repeated = any(r["group"] == "repeat" for r in done)
    alike = [r["folder"] for r in done if r["group"] == "repeat" or not r["changes"]] if repeated and not exact else []
    bars = report_errors.of_repeats([report_errors.Record(folder) for folder in alike])
    for r in done:
        r["seconds"] = run_seconds(r["folder"])
        r["contact"] = contact_steps(r["folder"])
        r["errors"] = (report_errors.against_exact(r["folder"]) if exact else
                       report_errors.against_run(report_errors.Record(r["folder"]), reference))
        for f, bar in bars.items():
            r["errors"][f] = report_errors.Error(r["errors"][f].value, bar)
    figures = [f for f in report_errors.FIGURES
               if all(f in r["errors"] and np.isfinite(r["errors"][f].known) for r in done)]
    heat = [f for f in figures if f in report_errors.HEAT] or figures
    if not heat:
        raise CaseError("these runs have no figure in common: bed.csv has neither temperatures nor a bed height")
    for r in done:
        r["worst"] = max(r["errors"][f].known for f in heat)
    for r in done:
        r["front"] = r in report_page.front(done, lambda r: r["worst"])
    return figures, heat


def main():
    parser = argparse.ArgumentParser(prog="hotbed report", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", help=f"folder of a run; {' or '.join(SCENES)}, or the folder of a case")
    parser.add_argument("--quick", action="store_true", help="a smaller scene and fewer runs, at most ten minutes on two cores")
    parser.add_argument("--vary", nargs="+", default=[], metavar="name=v1,v2",
                        help="settings, keys of couplingProperties, maxCo; instead of the scene's own variations")
    parser.add_argument("--product", action="store_true", help="all combinations of what --vary names, not one at a time")
    parser.add_argument("--repeat", nargs="+", default=[], metavar="name=v1,v2",
                        help="with --vary: changes too small to mean anything, for error bars of chaotic runs")
    parser.add_argument("--set", nargs="+", default=[], metavar="name=value", help="for all runs")
    parser.add_argument("--reference", nargs="+", default=None, metavar="name=value",
                        help="the run that errors are taken against (default: the finest values)")
    parser.add_argument("--at-once", type=int, default=2, metavar="N", help="runs at a time (default 2)")
    parser.add_argument("--results", type=Path, default=Path("results"), help="where runs go (default: results)")
    options = parser.parse_args()
    try:
        path = EXAMPLES / options.case if options.case in SCENES else Path(options.case).resolve()
        exact = path == EXAMPLES / "fixed_bed" and options.reference is None
        if not options.vary and (path / "log.hotbedFoam").is_file():
            print(report_run.write(path))
            return
        if not (path / "system/controlDict").is_file():
            raise CaseError(f"{options.case} is neither one of {', '.join(SCENES)} nor the folder of a case (system/controlDict is "
                            "missing there) nor that of a run (log.hotbedFoam is missing, too)")
        ready = SCENES[path.name][options.quick] if path.parent == EXAMPLES and path.name in SCENES else None
        if not ready and not options.vary:
            raise CaseError(f"{options.case} is a case, not the folder of a run (log.hotbedFoam is missing there): say what to vary, "
                            "--vary name=value,value ..., or name a run, results/<case>/<what --set says>")
        common = {**(ready["common"] if ready else {}), **pairs(options.set)}
        scene = own_scene(path, common, options.vary, options.product, options.repeat) if options.vary else \
            {**ready, "common": common}
        if exact or options.reference is not None:
            scene["reference"] = None if exact else pairs(options.reference)
        make(path, scene, exact, options)
    except CaseError as problem:
        sys.exit(f"hotbed: {problem}")


def make(case, scene, exact, options):
    """Runs what is missing and writes the report."""
    rows = runs_of(case, scene)
    if exact and any("u0" in changes for changes in [scene["common"], *(r["changes"] for r in rows)]):
        raise CaseError("the exact solution of the fixed bed is that for u0 = 0.1: give a --reference to vary u0")
    kind = "-".join([case.name] + ["quick"] * options.quick + ["own"] * bool(options.vary))
    folder = options.results / "report" / kind
    folder.mkdir(parents=True, exist_ok=True)
    print(f"{len(rows)} runs in {folder}, {options.at_once} at a time; those that are there already are taken as they are",
          flush=True)
    runs = folder / f"runs-{fingerprint(case, scene['common'])}"
    found = campaign.run_all(case, runs, [{**scene["common"], **r["changes"]} for r in rows], options.at_once, keep_going=True)
    for r, run in zip(rows, found):
        r["folder"], r["label"] = run, " ".join(f"{n}={v}" for n, v in r["changes"].items()) or "as the case stands"
        r["choice"] = r["group"] not in ("reference", "repeat")
    figures, heat = evaluate(rows, exact)
    done = [r for r in rows if r["folder"]]
    best = {f: {bound: cheapest(done, bound, [f]) for bound in (0.01, 0.05)} for f in figures}
    best["heat"] = {bound: cheapest(done, bound, heat) for bound in (0.01, 0.05)}
    report = {"case": case.name, "path": relative(case), "quick": options.quick, "exact": exact,
              "command": " ".join(map(shlex.quote, sys.argv)),
              "machine": results.machine(), "versions": results.versions(), "common": scene["common"],
              "at_once": options.at_once, "figures": figures, "heat": heat, "rows": rows, "best": best}
    report["sentence"] = report_page.sentence(report)
    report_page.write(report, folder)
    (folder / "report.json").write_text(json.dumps(plain(report), indent=1) + "\n")
    print(f"{report['sentence']}\n{folder}/index.html")


def relative(path):
    """As it is written on the command line in Hotbed's own folder."""
    return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else str(path)


def plain(report):
    """The report as numbers and names."""
    def run(r):
        return {"group": r["group"], "changes": r["changes"], "failed": True} if not r["folder"] else {
            "group": r["group"], "changes": r["changes"], "wall_time_s": r["seconds"], "dem_steps_a_contact": r["contact"],
            "pareto_front": r["front"], "largest_heat_error": r["worst"],
            "errors": {f: {"error": r["errors"][f].value, "bar": r["errors"][f].bar, "shown": report_page.shown(r["errors"][f])}
                       for f in report["figures"]}}

    return {**report, "rows": [run(r) for r in report["rows"]],
            "best": {f: {f"{bound:g}": r and r["label"] for bound, r in found.items()}
                     for f, found in report["best"].items()}}


if __name__ == "__main__":
    main()
