"""Faults put into runs: none may lose more than the time since the last write, and each must end with an error that names file
and mend where one is due. `./hotbed validate faults [--quick]`: more than a hundred, --quick about sixty.

A row is one fault; its value counts what went wrong. Scene: the slim bed with 269 particles in 768 cells, a restart every
millisecond. Full disks are small mounted ones and need root; without it these rows are left out.
"""

import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "slim_bed"
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
import run as hotbed
from campaign import edit, reached
from fault_scenes import BLOW_UPS, LATER, SMALL, STEP, elsewhere, goes_on, lacking, shown, solve

LAST, BEFORE = 0.003, 0.002  # the last two restarts of the base runs [s]
chance = random.Random(1)


def scene(folder, name, ranks=1, edits=(), **settings):
    """A prepared small slim bed. @param edits (file, pattern, replacement) made before the mesh"""
    case = folder / "case"
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(CASE, case)
    for file, pattern, replacement in edits:
        edit(case / file, pattern, replacement)
    hotbed.prepare(case, folder / name, {**SMALL, **{k: f"{v}" for k, v in settings.items()}}, ranks=ranks, overwrite=True)
    return folder / name


class Faults:
    def __init__(self, figures, folder):
        self.figures, self.folder = figures, folder
        self.bases = {}

    def row(self, name, wrong):
        self.figures.add(name, len(wrong), 0, "; ".join(wrong)[:300])

    def base(self, ranks):
        """A run that ended at LAST."""
        if ranks not in self.bases:
            self.bases[ranks] = scene(self.folder, f"base-{ranks}", ranks, endTime=LAST)
            hotbed.run_case(self.bases[ranks], ranks)
        return self.bases[ranks]

    def copy(self, name, ranks=1, place=None):
        target = (place or self.folder) / name
        shutil.rmtree(target, ignore_errors=True)
        shutil.copytree(self.base(ranks), target)
        hotbed.change_settings(target / "settings", {"endTime": f"{LAST + 5 * STEP:.7g}"})
        return target


def spoil(path, how, other):
    """@param other  the same file of another case"""
    content = bytearray(path.read_bytes())
    if how == "half of it":
        path.write_bytes(content[:len(content) // 2])
    elif how == "last byte missing":
        path.write_bytes(content[:-1])
    elif how == "empty":
        path.write_bytes(b"")
    elif how == "a bit flipped":
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(7)
        path.write_bytes(content)
    elif how == "of another case":
        shutil.copyfile(other, path)
    else:
        path.unlink()


def restart_files(faults, ranks, files, ways):
    """Damage to the files of the last restart: refused with the file's name and the mend, which makes the one before go on."""
    foreign = scene(faults.folder, f"foreign-{ranks}", ranks, solids="2e-7", cellsWidth="6", maxDeltaT="8e-5", endTime=LAST)
    hotbed.run_case(foreign, ranks)
    for file in files:
        for how in ways:
            run = faults.copy("damaged", ranks)
            spoil(run / file, how, foreign / file)
            code, log = solve(run, ranks)
            if file.endswith("state") and how == "missing":  # what a killed write leaves: taken for unfinished
                wrong = [f"exit status {code}"] * (code != 0) + lacking(log, "was left unfinished") + elsewhere(log, BEFORE)
            elif file.endswith("checksums") and how == "missing":  # the user's word that all is well
                wrong = [f"exit status {code}"] * (code != 0) + elsewhere(log, LAST)
            else:
                named = file if "checksums" not in file else "restart/"  # a list that is not whole accuses others
                wrong = lacking(log, "is damaged", named, f"remove restart/{LAST}/state") + ["it ran"] * (code == 0)
                (run / f"restart/{LAST}/state").unlink(missing_ok=True)
                wrong += goes_on(run, ranks, BEFORE)
            faults.row(f"{file}, {how}" + (f", {ranks} ranks" if ranks > 1 else ""), wrong)


def other_restarts(faults):
    """Restarts that are whole and belong to something else, and those to go on with on other numbers of ranks."""
    def refused(name, change, *texts):
        run = faults.copy("other")
        change(run)
        code, log = solve(run)
        faults.row(name, lacking(log, *texts) + ["it ran"] * (code == 0))

    foreign = faults.folder / "foreign-1"
    last = f"restart/{LAST}"

    def take(run, *paths):
        for path in paths:
            shutil.rmtree(run / path)
            shutil.copytree(foreign / path, run / path)

    def without(run, key):
        (run / last / "checksums").unlink()
        edit(run / last / "state", rf"^ *{key} .*\n", "")

    refused("restart of another case beside these fields", lambda run: take(run, last), "is damaged", f"{LAST}/")
    refused("restart and fields of another case", lambda run: take(run, last, f"{LAST}"), f"{LAST}/", "size")
    refused("particles of another case, no checksums", lambda run: (
        shutil.copyfile(foreign / last / "particles.liggghts", run / last / "particles.liggghts"),
        (run / last / "checksums").unlink()), "but the run had", "particles.liggghts", "belongs to another run")
    refused("state of another version: an entry less", lambda run: without(run, "inflow"), f"{last}/state", "inflow")
    refused("restart folder gone", lambda run: shutil.rmtree(run / "restart"), last, "startFrom startTime")
    refused("script that starts anew", lambda run: edit(run / "DEM/in.bed", r'"\$\{resume\} == 1"', '"${resume} == 7"'),
            "DEM/in.bed", "did not go on", "read_restart")

    run = faults.copy("other")
    (run / last / "state").unlink()
    (run / f"{LAST}" / "U").write_text("half a fi")
    hotbed.resume(run, ranks=2)
    faults.row("write left unfinished, gone on with on 2 ranks", goes_on(run, 2, BEFORE))
    for file in (f"{LAST}/T", f"{last}/particles.liggghts"):
        run = faults.copy("other")
        spoil(run / file, "a bit flipped", None)
        try:
            hotbed.resume(run, ranks=2)
            wrong = ["it was taken"]
        except hotbed.CaseError as problem:
            wrong = lacking(str(problem), file, "is damaged", "remove")
        faults.row(f"{file}, a bit flipped, to go on with on 2 ranks", wrong)


def children(pid):
    return [int(n) for n in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def alive(pid):
    try:
        return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


def kills(faults, ranks, times, whom):
    """kill -9 at random moments: the next start goes on from the last write."""
    run = scene(faults.folder, f"killed-{ranks}-{whom.replace(' ', '-')}", ranks, endTime=1)
    before = at = 0.0
    for n in range(times + 1):  # the last start only shows that it goes on
        process = hotbed.start(run, ranks)
        time.sleep(chance.uniform(0.8, 2.5))
        wrong = [f"ended by itself: {process.returncode}"] if process.poll() is not None else []
        solvers = [process.pid] if ranks == 1 else [pid for pid in children(process.pid)] if not wrong else []
        victim = {"the run": solvers, "a rank": solvers[-1:], "mpirun": [process.pid]}[whom]
        for pid in victim:
            os.kill(pid, signal.SIGKILL)
        process.wait(timeout=60)
        patience = time.time() + 30
        while any(map(alive, solvers)) and time.time() < patience:
            time.sleep(0.1)
        wrong += [f"process {pid} lives on" for pid in filter(alive, solvers)]
        times_ = [float(t) for t in re.findall(r"(?m)^Time = (\S+)", (run / "log.hotbedFoam").read_text(errors="replace"))]
        if n and times_:
            lost = before - times_[0]
            wrong += [f"lost {lost:.4f} s"] * (lost > 1e-3 + 2.2 * STEP) + ["not from the last restart"] * (times_[0] > at + 1.1 * STEP)
        if n:
            faults.row(f"kill -9 of {whom}, {ranks} ranks, number {n}", wrong)
        before, at = (times_[-1] if times_ else before), reached(run)


def ended(run, ranks, log, code, expected):
    """What is wrong with a run that was told to end."""
    wrong = [f"exit status {code} instead of {expected}"] * (code != expected)
    at = reached(run)
    wrong += lacking(log, "restart written") if expected != 1 else []  # mpirun reads no more of what is printed
    return wrong + (goes_on(run, ranks, at) if at > 0 else ["no restart"])


def signals(faults, quick):
    """SIGINT, SIGTERM, SIGUSR2 to the solver, to mpirun, to ./hotbed run; stopAt writeNow."""
    for ranks in (1, 2, 4):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR2):
            if quick and ranks == 4 and number != signal.SIGUSR2:
                continue
            run = scene(faults.folder, "signalled", ranks, endTime=10, writeInterval=10)
            process = hotbed.start(run, ranks)
            begun(run)
            process.send_signal(number)
            code = process.wait(timeout=60)
            expected = 0 if number == signal.SIGUSR2 else 1 if ranks > 1 else 128 + number
            faults.row(f"{number.name} to {'mpirun' if ranks > 1 else 'hotbedFoam'}, {ranks} ranks",
                       ended(run, ranks, (run / "log.hotbedFoam").read_text(errors="replace"), code, expected))
    run = scene(faults.folder, "signalled", endTime=10, writeInterval=10)
    process = hotbed.start(run)
    begun(run)
    edit(run / "system/controlDict", r"^stopAt .*", "stopAt writeNow;")
    code = process.wait(timeout=60)
    edit(run / "system/controlDict", r"^stopAt .*", "stopAt endTime;")
    faults.row("stopAt writeNow in controlDict of a run", [f"exit status {code}"] * (code != 0) + goes_on(run, 1, reached(run)))
    for ranks, numbers in ((1, [signal.SIGINT]), (2, [signal.SIGTERM]), (2, [signal.SIGINT, signal.SIGINT])):
        place = faults.folder / "command"
        shutil.rmtree(place, ignore_errors=True)
        changes = [f"{k}={v}" for k, v in {**SMALL, "endTime": "10", "writeInterval": "0.001"}.items()]
        process = subprocess.Popen([sys.executable, hotbed.__file__, CASE, "-np", str(ranks), "--results", place, "--set", *changes],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        while not (runs := list(place.glob("*/*/log.hotbedFoam"))):
            time.sleep(0.1)
        run = runs[0].parent
        begun(run)
        for number in numbers:
            process.send_signal(number)
            time.sleep(0.05)
        said = process.communicate(timeout=60)[0]
        wrong = [f"exit status {process.returncode}"] * (process.returncode != 128 + numbers[0])
        faults.row(f"{' and '.join(n.name for n in numbers)} to ./hotbed run, {ranks} ranks",
                   wrong + lacking(said, "--restart") + goes_on(run, ranks, reached(run)))


def begun(run, steps=30):
    """Waits until a run has made some steps and, where it writes often, a restart."""
    patience = time.time() + 60
    while len(re.findall(r"(?m)^Time = ", (run / "log.hotbedFoam").read_text(errors="replace"))) < steps and time.time() < patience:
        time.sleep(0.1)


def blow_ups(faults, quick):
    for name, (edits, texts) in BLOW_UPS.items():
        for ranks in (1,) if quick else (1, 2):
            run = scene(faults.folder, "blown", ranks, edits, endTime=0.1)
            code, log = solve(run, ranks)
            faults.row(f"{name}, {ranks} ranks", lacking(log, *texts) + ["it ran"] * (code == 0))
    for name, ((file, pattern, replacement), texts) in LATER.items():
        for ranks in (1, 2):
            run = faults.copy("later", ranks)
            whole = (run / file).read_text()
            edit(run / file, pattern, replacement)
            code, log = solve(run, ranks)
            (run / file).write_text(whole)
            faults.row(f"{name}, after a restart, {ranks} ranks",
                       lacking(log, *texts) + ["it ran"] * (code == 0) + goes_on(run, ranks, LAST))


def disks(faults, free):
    """Full and read-only disks. @param free  room left, in kB"""
    if os.geteuid() != 0:
        print("full disks need root: left out")
        return
    with tempfile.TemporaryDirectory() as place:
        if subprocess.call(["mount", "-t", "tmpfs", "-o", "size=16m", "none", place]) != 0:
            print("cannot mount a small disk: left out")
            return
        try:
            for ranks, left in free:
                run = faults.copy("full", ranks, Path(place))
                hotbed.change_settings(run / "settings", {"endTime": "0.05"})
                room = shutil.disk_usage(place).free - left * 1024
                (Path(place) / "filler").write_bytes(bytes(room))
                if left > 30:
                    code, log = solve(run, ranks)
                else:  # not even the log has room: read as on a terminal
                    code, log = shown(run)
                (Path(place) / "filler").unlink()
                shutil.rmtree(run / "DEM/post", ignore_errors=True)  # a run of LIGGGHTS' own dumps may hold half a file
                faults.row(f"disk full, {left} kB left, {ranks} ranks", lacking(log, "cannot write", f"{run}/", "No space left") +
                           ["it ran"] * (code == 0) + goes_on(run, ranks, reached(run)))
            run = faults.copy("full", 1, Path(place))
            subprocess.check_call(["mount", "-o", "remount,ro", place])
            code, log = shown(run)
            faults.row("read-only folder, hotbedFoam", lacking(log, "cannot write", "log.liggghts") + ["it ran"] * (code == 0))
            try:
                hotbed.start(run)
                wrong = ["it ran"]
            except OSError as problem:
                wrong = lacking(str(problem), "log.hotbedFoam")
            subprocess.check_call(["mount", "-o", "remount,rw", place])
            faults.row("read-only folder, ./hotbed run", wrong + goes_on(run, 1, LAST))
        finally:
            subprocess.call(["umount", "-l", place])
    run = faults.copy("blocked")
    blocked = run / f"restart/{LAST + 5 * STEP:.7g}"
    hotbed.change_settings(run / "settings", {"writeInterval": f"{5 * STEP}"})
    blocked.write_text("")
    code, log = solve(run)
    blocked.unlink()
    faults.row("a file where the next restart goes",
               lacking(log, "cannot write", str(blocked)) + ["it ran"] * (code == 0) + goes_on(run, 1, LAST))


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate faults", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer of each kind")
    parser.add_argument("--only", default="", help="kinds: restarts, others, kills, signals, blow-ups, disks")
    options = parser.parse_args()
    quick, only = options.quick, options.only.split(",") if options.only else []
    figures = results.Figures("faults")
    folder = Path("results") / "faults" / ("validate-quick" if quick else "validate")
    folder.mkdir(parents=True, exist_ok=True)
    faults = Faults(figures, folder.resolve())
    last = f"restart/{LAST}"
    files = [f"{last}/particles.liggghts", f"{last}/state", f"{last}/checksums", f"{LAST}/U", f"{LAST}/h", f"{LAST}/uniform/time"]
    ways = ["half of it", "last byte missing", "empty", "a bit flipped", "of another case", "missing"]
    if not only or "restarts" in only or "others" in only:
        restart_files(faults, 1, files[:4] if quick else files, ["half of it", "a bit flipped", "missing"] if quick else ways)
        restart_files(faults, 2, [f"processor1/{LAST}/phi", files[0]], ["a bit flipped"] if quick else ways)
        other_restarts(faults)
    if not only or "kills" in only:
        kills(faults, 1, 4 if quick else 12, "the run")
        kills(faults, 2, 2 if quick else 6, "a rank")
        kills(faults, 2, 1 if quick else 3, "mpirun")
    if not only or "signals" in only:
        signals(faults, quick)
    if not only or "blow-ups" in only:
        blow_ups(faults, quick)
    if not only or "disks" in only:
        disks(faults, [(1, 4), (1, 60), (1, 200), (2, 150)] if quick else
              [*((1, left) for left in (0, 4, 20)), *((ranks, left) for ranks in (1, 2) for left in (60, 100, 150, 200, 300, 500))])
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
