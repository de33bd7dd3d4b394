"""Follows a run on a terminal or in a log, and ends it with a restart when asked to."""

import os
import re
import shutil
import signal
import sys
import time
from pathlib import Path

import paraview
from paraview import NUMBER

COMMAND = os.environ.get("HOTBED_COMMAND", "./hotbed")  # as messages call it


class Stopped(BaseException):
    """Ctrl-C, SIGTERM or the end of the terminal. @param number of the signal"""

    def __init__(self, number):
        self.number = number


def ending(path):
    """The last part of a log, which may be long."""
    with open(path, "rb") as file:
        file.seek(max(0, os.path.getsize(path) - 20000))
        return file.read().decode(errors="replace")


def stopped(log):
    """(signal, time [s], what was written: restart or fields) as texts where a signal ended the run, else None."""
    found = re.search(r"(?m)^Stopped by signal (\d+) at (\S+) s, (restart|fields) written", ending(log))
    return found and found.groups()


def by_time(paths):
    """The paths whose folder is named after a time, in its order; others, such as copies of the user's, are left out."""
    timed = [path for path in paths if re.fullmatch(NUMBER, path.parent.name)]
    return sorted(timed, key=lambda path: float(path.parent.name))


def bed_now(run):
    """The numbers in the last whole line of a run's newest bed.csv, by name; empty before the first one."""
    files = by_time(Path(run).glob("postProcessing/hotbed/*/bed.csv"))
    if not files:
        return {}
    with open(files[-1], errors="replace") as file:
        names = file.readline().strip().split(",")
    lines = ending(files[-1]).split("\n")[:-1]
    last = zip(names, lines[-1].split(",")) if len(lines) > 1 else ()
    return {name: float(text) for name, text in last if re.fullmatch(NUMBER, text)}


def status(run, log, end, first, elapsed):
    """What a run is doing, in a line. @param first simulated time at the start [s]; @param elapsed wall time since then [s]"""
    found = re.findall(rf"Time = ({NUMBER})  Courant ({NUMBER})  ", ending(Path(run) / log))
    if not found:
        return None
    now, courant = map(float, found[-1])
    seconds = elapsed * (end - now) / (now - first) if now > first else None
    left = "" if seconds is None else f", {seconds // 3600:.0f}:{seconds // 60 % 60:02.0f}:{seconds % 60:02.0f} to go"
    parts = [f"{now:.5g} of {end:g} s{left}"]
    bed = bed_now(run)
    for name, text in (("T_mean_K", "bed {:.2f} K"), ("pressure_drop_Pa", "pressure drop {:.4g} Pa"),
                       ("overlap_max", "overlap {:.2g}")):
        if name in bed:
            parts.append(text.format(bed[name]))
    return now, "  ".join([*parts, f"Courant {courant:.2g}"])


def progress(process, run, end, log="log.hotbedFoam"):
    """Follows a run until it ends: a line that is written over on a terminal, else a line every 15 s; the particles'
    series for ParaView grows with it."""
    terminal = sys.stdout.isatty()
    begin, first, shown, drawn, width = time.time(), None, 0.0, time.time(), 0
    while process.poll() is None:
        time.sleep(0.25)
        if time.time() - drawn > 15:
            paraview.particles(run)
            drawn = time.time()
        if not terminal and time.time() - shown < 15:
            continue
        found = status(run, log, end, first or 0.0, time.time() - begin)
        if found is None:
            continue
        if first is None:
            first, begin = found[0], time.time()
            continue
        shown = time.time()
        text = found[1][:shutil.get_terminal_size().columns - 3] if terminal else found[1]
        print(f"\r  {text:{width}}" if terminal else f"  {text}", end="" if terminal else "\n", flush=True)
        width = len(text)
    if terminal:
        print()
    return process.returncode


def stop(process, run, number, log="log.hotbedFoam"):
    """Ends a run with a restart. Another signal kills it at once."""
    print("\nstopping: the run writes a restart and ends; Ctrl-C again kills it at once", flush=True)
    process.send_signal(signal.SIGUSR2)  # which mpirun hands on to the ranks; on others it kills them soon
    try:
        process.wait()
    except Stopped:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()  # mpirun's ranks
        for pid in [*map(int, children), process.pid]:
            os.kill(pid, signal.SIGKILL)
        process.wait()
    found = stopped(Path(run) / log)
    words = [word for word in sys.argv[1:] if word not in ("--overwrite", "--restart")]
    again = f"go on with: {COMMAND} run {' '.join(words)} --restart"
    if found:
        _, time, written = found
        print(f"stopped at {time} s, {written} written" + (f"; {again}" if written == "restart" else ""))
    elif any(Path(run).glob("restart/*/state")):
        print(f"stopped without a new restart; {again} (from the last one)")
    else:
        print("stopped before there was a restart: run it anew with --overwrite")
    sys.exit(128 + number)
