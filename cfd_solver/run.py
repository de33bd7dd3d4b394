"""Prepares and runs a Hotbed case: mesh, decomposition, coupled run, picture. The verb `run` of ./hotbed."""

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import decompose as decomposition
import paraview
from follow import COMMAND, Stopped, by_time, ending, progress, stop
from paraview import NUMBER

ROOT = Path(__file__).resolve().parent.parent
INSTALLED = not (ROOT / "CMakeLists.txt").is_file()  # in PREFIX/share/hotbed
SOLVER = (ROOT.parents[1] / "bin" if INSTALLED else Path(os.environ.get("HOTBED_BUILD", ROOT / "build")) / "cfd_solver") / "hotbedFoam"


class CaseError(Exception):
    """A case that cannot be run; the text names file, key and mend."""


# of memory, which large arrays gain from where the system gives them to those who ask
LARGE_PAGES = {"GLIBC_TUNABLES": "glibc.malloc.hugetlb=1"}


def environment():
    """Environment of OpenFOAM's programs and of mpirun, which refuses root and more ranks than cores otherwise; large pages
    for large arrays. What the user has set for Open MPI or the C library stands."""
    return {
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "OMPI_MCA_hwloc_base_binding_policy": "none",
        "OMPI_MCA_mpi_yield_when_idle": "1",
        "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
        **LARGE_PAGES,
        **os.environ,
        "WM_PROJECT_DIR": "/usr/share/openfoam",
    }


ENTRY = r"(?m)^(\s*)({})(\s+)([^;]+);"
KEPT = {"encoding": "utf-8", "errors": "surrogateescape"}  # files of a case may be in any encoding, and keep it


def read(path):
    """Text of a file of a case."""
    return Path(path).read_text(**KEPT)


def write(path, text):
    Path(path).write_text(text, **KEPT)


def read_settings(path):
    """name -> text of every entry of a settings file."""
    return {m[2]: m[4].strip() for m in re.finditer(ENTRY.format(r"\w+"), read(path))}


def change_settings(path, changes):
    """Writes new values into a settings file; an unknown name is a CaseError."""
    text = read(path)
    known = read_settings(path)
    for name, value in changes.items():
        if name not in known:
            raise CaseError(f"{path}: no setting '{name}'; known are {', '.join(known)}")
        text = re.sub(ENTRY.format(re.escape(name)), lambda m: f"{m[1]}{m[2]}{m[3]}{value};", text)
    write(path, text)


COUPLING = ("drag", "heatTransfer", "kernelWidth", "windowLength", "kernelSamples", "exchange", "temperatureGradient",
            "writeRestart", "bedInterval", "closureCo")


def place(case, name):
    """The file of a case in which `--set name=value` changes a number: settings where it has that name, else a dictionary."""
    if (case / "settings").is_file() and name in (known := read_settings(case / "settings")):
        return "settings"
    if name in COUPLING:
        return "constant/couplingProperties"
    if name == "maxCo" and name in read_settings(case / "system/controlDict"):
        return "system/controlDict"
    if not (case / "settings").is_file():
        raise CaseError(f"{case} has no settings to change: the file 'settings' is missing")
    raise CaseError(f"{case}/settings: no setting '{name}'; known are {', '.join(known)}")


def change_case(run, changes):
    """Writes new values into the files of a case's copy."""
    properties = run / "constant/couplingProperties"
    for name, value in changes.items():
        file = place(run, name)
        if file == "constant/couplingProperties":
            other = {"windowLength": "kernelWidth", "kernelWidth": "windowLength"}.get(name, name)  # one of the two may stand
            text = re.sub(ENTRY.format(f"{name}|{other}"), "", read(properties))
            write(properties, f"{text.rstrip()}\n{name} {value};\n")
        else:
            change_settings(run / file, {name: value})


def prepare(case, run, changes=None, full=False, ranks=1, overwrite=False):
    """Copies a case to the folder `run`, sets its numbers, makes mesh and decomposition.

    Raises CaseError where the case is not one, a setting is unknown, OpenFOAM cannot use the folder, or a run was started in it
    already: what only a failed preparation left there is made anew.
    """
    case, run = Path(case), Path(run)
    for needed in ("system/controlDict", "constant/couplingProperties"):
        if not (case / needed).is_file():
            raise CaseError(f"{case} is not a Hotbed case: {needed} is missing")
    unusable = re.search(r"[\s'\"]", str(run.resolve()))
    if unusable:
        raise CaseError(f"{run.resolve()}: OpenFOAM takes no folder with {unusable[0]!r} in its path: rename that folder, or work in "
                        "another one")
    if run.exists():
        begun = any(any(run.glob(left)) for left in ("log.hotbedFoam*", "postProcessing", "restart"))
        if begun and not overwrite:
            raise CaseError(f"{run} holds a run already: add --restart to go on with it, or --overwrite to make it anew")
        shutil.rmtree(run)
    changes = dict(changes or {})
    if full:
        if not (case / "settings.full").is_file():
            raise CaseError(f"{case} has no full size: settings.full is missing")
        changes = {**read_settings(case / "settings.full"), **changes}
    for name in changes:
        place(case, name)
    shutil.copytree(case, run, ignore=shutil.ignore_patterns("README*", "plot.py", "log*", "processor*"))
    change_case(run, changes)
    mesh(run)
    if ranks > 1:
        decompose(run, ranks)


def mesh(run):
    """The gas mesh, by blockMesh where the case has a blockMeshDict, else the one in constant/polyMesh; and the surfaces
    constant/triSurface/PATCH.stl that the DEM script reads and the case does not bring, from the patches of that name.

    Raises CaseError where there is no mesh, or neither surface nor patch.
    """
    if (run / "system/blockMeshDict").is_file():
        tool(run, "blockMesh")
    elif not any(run.glob("constant/polyMesh/points*")):
        raise CaseError(f"{run} has no mesh: put a blockMeshDict into system, or the mesh itself into constant/polyMesh")
    properties = run / "constant/couplingProperties"
    script = run / read_settings(properties).get("demScript", "").strip('"')
    if not os.path.isfile(script):  # also of a name that no file can have
        return  # the solver says so
    for name in re.findall(r"(?m)^[^#\n]*\sconstant/triSurface/(\w+)\.stl\b", read(script)):
        surface = run / f"constant/triSurface/{name}.stl"
        if not surface.is_file():
            patches = re.findall(r"(?m)^\s*(\w+)\s*\{", read(run / "constant/polyMesh/boundary").partition("}")[2])
            if name not in patches:
                raise CaseError(f"{script} reads {surface}, which is not there: bring that surface, or name it after the patch "
                                f"of the mesh that it is to be written from ({', '.join(patches)})")
            surface.parent.mkdir(exist_ok=True)
            tool(run, "surfaceMeshExtract", "-patches", f"({name})", f"constant/triSurface/{name}.stl")


def resume(run, changes=None, ranks=1):
    """Makes a folder that holds a run ready to go on from its last restart, on any number of ranks.

    Raises CaseError where there is no run, or one without restarts.
    """
    run = Path(run)
    restarts = by_time(run.glob("restart/*/state"))
    if not restarts:
        raise CaseError(f"{run} holds no restart to go on from: run it anew, without --restart")
    last = restarts[-1].parent
    change_case(run, changes or {})
    before = len(list(run.glob("processor*"))) or 1
    if before == ranks:
        return
    # the time of the restart: a later one is what a killed run left unfinished
    move_checksums(run, last / "checksums")
    if before > 1:
        tool(run, "reconstructPar", "-time", last.name)
        for folder in run.glob("processor*"):
            shutil.rmtree(folder)
    if ranks > 1:
        decompose(run, ranks, "-time", last.name)


def move_checksums(run, checksums):
    """Before the fields are split for another number of ranks: refuses damaged ones, then forgets their checksums."""
    if not checksums.is_file():
        return
    check = subprocess.run(["sha1sum", "--check", "--strict", "--quiet", checksums.relative_to(run)], cwd=run,
                           capture_output=True, text=True)
    if check.returncode != 0:
        raise CaseError(f"the restart {checksums.parent} is damaged: {check.stdout.strip() or check.stderr.strip()}\n"
                        f"To go on from the restart before it, remove {checksums.parent}/state. If you changed the file "
                        f"yourself and mean it, remove {checksums}")
    kept = [line for line in read(checksums).splitlines(keepends=True) if "  restart/" in line]
    write(checksums, "".join(kept))


def decompose(run, ranks, *options):
    """Splits the gas for a number of ranks, as system/decomposeParDict says; see cfd_solver/decompose.py for what it leaves
    open."""
    dictionary = Path(run) / "system/decomposeParDict"
    text = read(dictionary) if dictionary.is_file() else decomposition.DICTIONARY
    text, found = re.subn(r"(?m)^(\s*numberOfSubdomains\s+)\d+", rf"\g<1>{ranks}", text)
    if not found:
        raise CaseError(f"{dictionary}: the entry numberOfSubdomains is missing")
    if decomposition.is_open(text, ranks):
        text = re.sub(decomposition.PIECES, "n ({} {} {})".format(*decomposition.pieces(ranks, *box(run))), text)
    write(dictionary, text)
    tool(run, "decomposePar", *options)


def box(run):
    """Size of the mesh along x, y, z [m], and gravity."""
    tool(run, "checkMesh", "-constant", "-noTopology")
    size = decomposition.extent((Path(run) / "log.checkMesh").read_text())
    read_g = subprocess.run(["foamDictionary", "-entry", "value", "-value", "constant/g"], cwd=run, env=environment(),
                            capture_output=True, text=True, errors="replace")
    found = re.search(r"\(\s*(\S+)\s+(\S+)\s+(\S+?)\s*\)\s*$", read_g.stdout)
    try:
        return size, [float(g) for g in found.groups()]
    except (AttributeError, ValueError):
        raise CaseError(f"{run}/constant/g has no vector 'value': write 'value (0 0 -9.81);'") from None


def tool(run, *command):
    """Runs one of OpenFOAM's own programs in a case, its output in log.<program>."""
    log = Path(run) / f"log.{command[0]}"
    with open(log, "w") as out:
        code = subprocess.call(command, cwd=run, stdout=out, stderr=subprocess.STDOUT, env=environment())
    if code != 0:
        raise CaseError(f"{command[0]} failed in {run}; the end of {log}:\n{tail(log)}")


def tail(path, lines=25):
    """What a log ends with; where OpenFOAM gave up, from its words on, without the stack: that would push them out."""
    rows = ending(path).splitlines()
    fatal = next((n for n, row in enumerate(rows) if "--> FOAM FATAL" in row), None)
    if fatal is None:
        return "\n".join(rows[-lines:])
    return "\n".join([row for row in rows[fatal:] if not re.match(r"(\[\d+\] *)?#\d+ ", row)][:lines])


def keep(log):
    """Moves the log of the piece of a run before to the next free log.1, log.2, ..."""
    if log.exists():
        number = next(n for n in range(1, 10**6) if not Path(f"{log}.{n}").exists())
        log.rename(f"{log}.{number}")


def mpirun(ranks):
    """The start of a command for a number of ranks, on the hosts that Open MPI is told of."""
    return ["mpirun", "-np", str(ranks), "-x", "WM_PROJECT_DIR", "-x", "GLIBC_TUNABLES"]


def start(run, ranks=1, log="log.hotbedFoam", own_session=False):
    """Starts the solver in a prepared case. @param own_session  Ctrl-C does not reach it. @return subprocess.Popen"""
    command = [str(SOLVER), "-case", str(Path(run).resolve())]
    if ranks > 1:
        command = [*mpirun(ranks), *command, "-parallel"]
    for name in (log, "log.liggghts"):
        keep(Path(run) / name)
    with open(Path(run) / log, "w") as out:
        return subprocess.Popen(command, cwd=run, stdout=out, stderr=subprocess.STDOUT, env=environment(),
                                start_new_session=own_session)


def finish(run, ranks=1, log="log.hotbedFoam"):
    """What follows a run: one set of fields from those of the ranks."""
    written = [p for p in Path(run).glob("processor0/[0-9]*") if re.fullmatch(r"[\d.e+-]+", p.name) and float(p.name) > 0]
    if ranks > 1 and written:
        tool(run, "reconstructPar")


def end_time(run):
    """End time of a case [s]. Raises CaseError where it has none."""
    found = subprocess.run(["foamDictionary", "-entry", "endTime", "-value", "system/controlDict"], cwd=run, env=environment(),
                           text=True, errors="replace", capture_output=True)
    value = found.stdout.split()[-1:] or ["missing"]
    if found.returncode != 0 or not re.fullmatch(NUMBER, value[0]):
        raise CaseError(f"{run}/system/controlDict: endTime must be a number, not '{value[0]}'\n{found.stderr[-1000:]}")
    return float(value[0])


def for_paraview(run):
    """Particles and gas as the series particles.pvd and gas.pvd."""
    paraview.particles(run)
    if any(re.fullmatch(r"[\d.e+-]*[1-9][\d.e+-]*", p.name) for p in Path(run).iterdir()):
        tool(run, "foamToVTK", "-noZero", "-no-boundary", "-name", "VTK/gas", "-overwrite")
        paraview.gas(run)


def run_case(run, ranks=1):
    """Runs a prepared case to its end. Raises CaseError with the end of the log where it fails."""
    process = start(run, ranks)
    try:
        code = process.wait()
    except BaseException:
        process.terminate()
        raise
    if code != 0:
        raise CaseError(f"the run in {run} failed (exit status {code}); the end of its log:\n"
                        f"{tail(Path(run) / 'log.hotbedFoam')}")
    finish(run, ranks)


def draw(script, run):
    """Runs a case's plot.py, which finds the modules of the examples' own also where the case is a copy of one of them."""
    paths = [str(ROOT / folder) for folder in ("examples", "validation", "cfd_solver")]
    own = os.environ.get("PYTHONPATH")
    code = subprocess.call(["/usr/bin/python3", str(script), str(run)],
                           env={**os.environ, "PYTHONPATH": os.pathsep.join(paths + ([own] if own else []))})
    if code != 0:
        raise CaseError(f"{script} failed (exit status {code}), its own words stand above. The results in {run} are whole: mend it, "
                        "then call it with that folder, or remove it")


def assignments(items):
    """name -> value of the words after --set."""
    changes = {}
    for item in items:
        name, equals, value = item.partition("=")
        if not equals or not value:
            raise CaseError(f"--set {item}: write name=value")
        changes[name] = value
    return changes


def interrupted(number, frame):
    raise Stopped(number)


def main():
    parser = argparse.ArgumentParser(prog="hotbed run", description="Runs a case, coupled.")
    parser.add_argument("case", type=Path, help="folder of the case")
    parser.add_argument("-np", type=int, default=1, metavar="N", help="MPI ranks (default 1)")
    parser.add_argument("--set", nargs="+", action="extend", default=[], metavar="name=value",
                        help="changes numbers of the case's file settings, keys of couplingProperties, maxCo")
    parser.add_argument("--full", action="store_true", help="the full size, file settings.full")
    parser.add_argument("--until", metavar="T", help="other end time [s]")
    parser.add_argument("--overwrite", action="store_true", help="make a run anew that is there already")
    parser.add_argument("--restart", action="store_true", help="go on from the last restart of the same run")
    parser.add_argument("--results", type=Path, default=Path("results"), help="where runs go (default: results)")
    options = parser.parse_args()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, interrupted)
    try:
        if options.np < 1:
            raise CaseError("-np must be at least 1")
        changes = assignments(options.set)
        label = ",".join((["full"] if options.full else []) + [f"{k}={v}" for k, v in changes.items()]) or "default"
        if options.until:
            changes["endTime"] = options.until
        case = options.case.resolve()
        run = options.results / case.name / label
        if options.restart:
            resume(run, changes, options.np)
        else:
            prepare(case, run, changes, options.full, options.np, options.overwrite)
        end = end_time(run)
        print(f"running in {run}, log in {run}/log.hotbedFoam", flush=True)
        process = start(run, options.np, own_session=True)
        try:
            code = progress(process, run, end)
        except Stopped as stopped:
            stop(process, run, stopped.number)
        log = run / "log.hotbedFoam"
        if code != 0:
            full = ". Its disk is full: make room, then go on with --restart" if shutil.disk_usage(run).free < 65536 else ""
            raise CaseError(f"the run failed (exit status {code}); the end of {log}:\n{tail(log)}{full}")
        finish(run, options.np)
        for_paraview(run)
        text = ending(log)
        print(text[max(text.rfind("Energy budget"), text.rfind("\nTiming ") if "Energy budget" not in text else 0):]
              .replace("\nEnd\n", "").strip())
        if (case / "plot.py").is_file():
            draw(case / "plot.py", run)
        print(f"a page of it: {COMMAND} report {run}")
    except CaseError as problem:
        sys.exit(f"hotbed: {problem}")
    except OSError as problem:
        sys.exit(f"hotbed: {problem.filename}: {problem.strerror}: the folder of the run must be writable and its disk "
                 "have room; what restarts it holds are whole")
    except Stopped as stopped:
        sys.exit(128 + stopped.number)


if __name__ == "__main__":
    main()
