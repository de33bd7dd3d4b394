"""Whatever is wrong with a key or an argument ends in an error that names file, key and mend before anything is computed; what may
be so by its meaning runs. `./hotbed validate bad_input [--quick] [--only TEXT]`: --quick takes every fifth try, --only those
whose name holds TEXT.

Keys, units and ranges are those of the tables in docs (bad_input_keys.py), so a key that is written down is tried; that all are
written down is checked against the solver's own lists and the sources. An error must give the key, the file, and what is allowed
in the words of the table. Scene: the slim bed with 269 particles in 768 cells, two gas steps.
"""

import argparse
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
import run as hotbed
from bad_input_keys import documented, tries
from campaign import edit
from fault_scenes import SCRIPT, SMALL

COUPLING, CONTROL = "constant/couplingProperties", "system/controlDict"
LINES = {"hotbed/balance": "balance", "hotbed/coarsegrain": "cg", "hotbed/heat": "heat", "hotbed/drag": "drag", "nve/sphere/hotbed": "integrate",
         "wall/gran": "xlow"}

# values that run: one for each word of a key without a default to take
BASE = {
    "demScript": f'"{SCRIPT}"', "drag": "Beetstra", "heatTransfer": "Gunn", "kernel": "Deen", "windowLength": "3e-3",
    "deltaT": "2.5e-5", "adjustTimeStep": "yes", "maxCo": "1", "maxDeltaT": "1e-4", "purgeWrite": "0", "units": "si",
    "timestep": "2.5e-6", "ratio": "2.5", "diameter": "5e-4", "density": "1040", "stiffness": "500", "restitution": "0.74 0.1",
    "initial_temperature": "363.15", "thermalCapacity": "779", "gravity": "9.81", "vector": "0.1 0.2 -1", "kn": "500",
    "coefficientRestitution": "0.74", "tangentialRestitution": "0.1", "coefficientFriction": "0.1", "etan": "7.87e-4",
    "etat": "1.72e-3", "kt": "217.6", "vectorised": "on", "kernelWidth": "3", "kernelSamples": "2", "bedInterval": "10", "closureCo": "0.1",
    "writeRestart": "yes", "exchange": "linear", "temperatureGradient": "on", "every": "1000",
}
DASHPOTS = ("etan", "etat", "kt")  # their scene has no restitutions
THEIRS = ("deltaT", "units", "timestep")  # where OpenFOAM or LIGGGHTS reads, its own words are the mend
READ_FIRST = ("adjustTimeStep", "purgeWrite")  # by OpenFOAM, where their value is none


def scene(folder):
    """The prepared case in which one thing at a time is changed, every argument written out."""
    target = folder / "scene"
    settings = {k: v for k, v in SMALL.items() if k != "maxDeltaT"}
    case = folder / "case"
    shutil.copytree(ROOT / "examples/slim_bed", case)
    edit(case / "settings", r"^(maxDeltaT|deltaT) .*", "")  # in controlDict only
    edit(case / CONTROL, r"^maxDeltaT.*", f"maxDeltaT {BASE['maxDeltaT']};")
    edit(case / CONTROL, r"^deltaT.*", f"deltaT {BASE['deltaT']};")
    edit(case / SCRIPT, r"^(fix +cg .*)", rf"\1 stiffness {BASE['stiffness']} restitution {BASE['restitution']}")
    edit(case / SCRIPT, r"^(pair_style|fix +xlow)(.*)", r"\1\2 vectorised on")
    edit(case / SCRIPT, r"vector 0 0 -1", f"vector {BASE['vector']}")
    edit(case / SCRIPT, r"^timestep.*", f"timestep {BASE['timestep']}\nfix balance all hotbed/balance every {BASE['every']}")
    hotbed.prepare(case, target, {**settings, "endTime": "5e-5", "writeInterval": "5e-5"})
    return target


def change(target, key, attempt, owner):
    """Writes one try into a copy of the scene. @return the file that the error must name"""
    if owner in (COUPLING, CONTROL):
        path = target / owner
        gone = "kernelWidth|windowLength" if key.name in ("kernelWidth", "windowLength") else key.name
        text = re.sub(rf"(?m)^({gone})\s[^;]*;.*\n", "", path.read_text())
        if attempt.name:
            text += f"\n{attempt.name} {attempt.value};\n" if attempt.value else f"\n{attempt.name} {{ a 1; }}\n"
        path.write_text(text)
        return Path(owner).name
    if key.name in DASHPOTS:
        edit(target / SCRIPT, r"^(fix +m[23] .*\n)+", "".join(
            f"fix {name} all property/global {name} peratomtypepair 1 {BASE[name]}\n" for name in DASHPOTS))
    if owner == "property/global":
        line, old = rf"^fix.*property/global {key.name} ", rf"{key.name} (\w+(?: 1)?) \S+$"
        old = rf"(?<=global ){key.name} (peratom\w+(?: 1)?) \S+"
        new = rf"{attempt.name} \1 {attempt.value}"
        edit(target / SCRIPT, rf"{line}.*\n" if not attempt.name else old, "" if not attempt.name else new)
        return SCRIPT
    start = {"DEM script": rf"^()({key.name} +\S+)(.*)$", "pair_style": rf"^(pair_style .*)({key.name} \w+)(.*)$"}.get(owner)
    start = start or rf"^(fix +{LINES[owner]} .*?)(\b{key.name}(?: \S+){{{key.values}}})(.*)$"
    edit(target / SCRIPT, start, rf"\g<1>{attempt.name or ''} {attempt.value or ''}\g<3>")
    return SCRIPT


def solve(target):
    """@return (exit status, log, whether something was computed or written)"""
    before = {p for p in target.rglob("*") if p.is_file()}
    code = hotbed.start(target).wait(timeout=120)
    log = re.sub(r"e\+0*", "e", (target / "log.hotbedFoam").read_text(errors="replace"))  # 1e+06 is 1e6
    written = [p for p in target.rglob("*") if p.is_file() and p not in before and not p.name.startswith("log.")]
    return code, log, bool(written) or "\nTime = " in log


def expected(key, attempt, owner, file):
    """What must stand in the error: file, key and mend."""
    renamed = attempt.name and attempt.name != key.name
    texts = [Path(file).name, attempt.name if renamed and owner in ("DEM script", "pair_style", "wall/gran") else key.name]
    if key.name in THEIRS or (renamed and owner in ("pair_style", "wall/gran")):
        return texts
    if not attempt.name or renamed:
        listed = renamed and owner in (COUPLING, "hotbed/coarsegrain")
        return texts + ["known" if listed else "xpecting" if owner in ("hotbed/balance", "hotbed/heat", "nve/sphere/hotbed") else "add"]
    if key.name in READ_FIRST and not re.fullmatch("-?[0-9]+", attempt.value):
        return texts
    if owner == "property/global" and not re.fullmatch(r"[\d.e+-]+", attempt.value):  # LIGGGHTS' own fix
        return texts + (["floating point"] if attempt.value else [])
    if attempt.what == "value missing":
        return texts
    if key.choices:
        return texts + ["must be", *key.choices]
    limits = re.findall(r"[<>]=? [\d.e+-]+", key.range)
    return texts + (["set it to 2"] if key.name == "purgeWrite" and attempt.value == "1" else [", ".join(limits)])


def wrong(key, attempt, owner, file, code, log, computed):
    """What is not right about the end of a run."""
    if attempt.runs:
        return [] if code == 0 and log.rstrip().endswith("End") else [f"refused: {refusal(log)}"]
    if code == 0:
        return ["runs"]
    lacks = [f"the error lacks '{text}'" for text in expected(key, attempt, owner, file) if text not in log]
    return lacks + ["ended by a signal"] * (code < 0) + ["something was computed or written"] * computed + (
        [refusal(log)] if lacks else [])


def refusal(log):
    """The error in a log, shortened."""
    found = re.search(r"(?s)(--> FOAM FATAL.*|LIGGGHTS, .*)", log)
    return re.sub(r"\s+", " ", found[1] if found else log[-300:])[:300]


def lists(target):
    """Differences between the tables of docs and what solver and sources know: owner -> names that only one of them has."""
    keys = documented()
    def named(owner):
        return {k.name for k in keys if k.owner == owner}
    (target / COUPLING).write_text((target / COUPLING).read_text() + "\nunknown 1;\n")
    known = {COUPLING: re.search(r"known keys are\s+\d*\s*\(([^)]*)\)", solve(target)[1])[1].split()}
    edit(target / COUPLING, r"^unknown.*\n", "")
    edit(target / SCRIPT, r"^(fix +cg .*)", r"\1 unknown 1")
    known["hotbed/coarsegrain"] = re.search(r"known are ([\w, ]+)\b", solve(target)[1])[1].split(", ")
    sources = ROOT / "liggghts_fixes"
    known["property/global"] = ["thermalCapacity", *re.findall(r'registry, "(\w+)"', (sources / "contact_constants.cpp").read_text())]
    settings = (ROOT / "cfd_solver/settings.cpp").read_text() + (ROOT / "cfd_solver/hotbedFoam.cpp").read_text()
    known[CONTROL] = {"deltaT", *re.findall(r'control(?:, |\.found\()"(\w+)"', settings)}
    differ = {owner: set(names) ^ named(owner) for owner, names in known.items()}
    pages = {re.search(r"(?m)^# fix (\S+)", p.read_text())[1] for p in (ROOT / "docs").glob("fix_*.md")}
    styles = set(re.findall(r'fixes\["(\S+)"\]', (sources / "register_styles.cpp").read_text()))
    styles -= {"wall/gran", "hotbed/carried"}  # LIGGGHTS' own page; not for scripts
    return {**differ, "pages of fix styles": pages ^ styles}


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate bad_input")
    parser.add_argument("--quick", action="store_true", help="every fifth try")
    parser.add_argument("--only", default="", metavar="TEXT", help="tries whose name holds TEXT")
    options = parser.parse_args()
    os.environ["OMPI_MCA_ess_singleton_isolated"] = "1"  # Open MPI starts no daemon for a run on one rank
    figures = results.Figures("bad_input")
    with tempfile.TemporaryDirectory(prefix="hotbed-bad-input-") as folder:
        base = scene(Path(folder))
        target = Path(folder) / "try"

        def fresh():
            shutil.rmtree(target, ignore_errors=True)
            shutil.copytree(base, target)

        fresh()
        for owner, names in lists(target).items():
            figures.add(f"{owner}: names in docs or in the code only", len(names), 0, " ".join(sorted(names)))
        tried = right = 0
        plan = {}
        for key in documented():
            for owner in ("pair_style", "wall/gran") if key.owner == "model hotbed" else (key.owner,):
                plan.setdefault(owner, []).extend(
                    (key, attempt) for attempt in tries(key, BASE[key.name], owner in (COUPLING, CONTROL)))
        for owner, attempts in plan.items():
            attempts = [(k, a) for k, a in attempts if options.only in f"{owner} {k.name} {a.what}"]
            count = failed = 0
            for key, attempt in attempts[::5 if options.quick else 1]:
                fresh()
                file = change(target, key, attempt, owner)
                problems = wrong(key, attempt, owner, file, *solve(target))
                count, failed = count + 1, failed + bool(problems)
                if problems:
                    print(f"  {owner} {key.name}, {attempt.what}: {'; '.join(problems)}", flush=True)
            tried, right = tried + count, right + count - failed
            if count:
                figures.add(f"{owner}: wrong of {count} tries", failed, 0)
        # what stands behind the last argument
        for owner, fix in LINES.items():
            if options.only in owner:
                fresh()
                edit(target / SCRIPT, rf"^(fix +{fix} .*)", r"\1 surplus 1")
                code, log, computed = solve(target)
                fine = code > 0 and not computed and re.search(r"surplus|takes no arg|xpecting", log) and SCRIPT in log
                tried, right = tried + 1, right + bool(fine)
                if not fine:
                    print(f"  {owner}, an argument too many: {refusal(log)}")
        figures.note("tries", tried)
        figures.note("right", right)
        figures.add("right, of all tries", right / tried if tried else 0, 1, f"{right} of {tried}", least=True)
    return figures.close()


if __name__ == "__main__":
    sys.exit(main())
