"""What decides stability and cost of a case, told before it is run. The verb `check` of ./hotbed."""

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import run as hotbed
from check_rows import ADVICE, OK, REFUSED, rows
from paraview import NUMBER

COLOURS = {OK: 32, ADVICE: 33, REFUSED: 31}


class Facts(dict):
    """Lines `fact name values` of a log. Numbers are floats; a name that comes again is in `every`."""

    def __init__(self, log):
        super().__init__()
        self.every = []
        for name, text in re.findall(r"(?m)^fact (\w+) (.*\S.*)$", log):
            values = [float(v) if re.fullmatch(NUMBER, v) else v for v in text.split()]
            self.every.append((name, values))
            self[name] = values if len(values) > 1 else values[0]


def measure(case, changes, ranks, seconds, full=False):
    """Prepares a copy of a case in a folder that is thrown away, and lets the solver check it.

    @param seconds  processor time of the steps that are run to measure their cost
    @return (Facts, entries of controlDict as text, peak memory of a rank [MiB], the solver's own refusal or "")
    """
    with tempfile.TemporaryDirectory(prefix="hotbed-check-") as folder:
        target = Path(folder) / "case"
        hotbed.prepare(case, target, changes, full, ranks)
        control = {key: entry(target, key) for key in
                   ("endTime", "startTime", "deltaT", "adjustTimeStep", "maxCo", "maxDeltaT", "writeControl",
                    "writeInterval")}
        command = [str(hotbed.SOLVER), "-case", str(target), "-check", str(seconds)]
        if ranks > 1:
            command = [*hotbed.mpirun(ranks), *command, "-parallel"]
        done = subprocess.run(command, cwd=target, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              errors="replace", env=hotbed.environment())
        log = done.stdout.replace(str(target), str(case))
        return Facts(log), control, memory(log), refusal(log) if done.returncode else ""


def entry(case, key):
    """An entry of controlDict with its variables filled in, None where it is missing."""
    found = subprocess.run(["foamDictionary", "-entry", key, "-value", "system/controlDict"], cwd=case, text=True,
                           capture_output=True, env=hotbed.environment())
    return found.stdout.split()[-1] if found.returncode == 0 and found.stdout.strip() else None


def memory(log):
    """Peak memory of a rank [MiB], None where the run did not come that far."""
    found = re.search(rf"peak memory of a rank +({NUMBER}) MiB", log)
    return float(found[1]) if found else None


def refusal(log):
    """What the solver said before it gave up, on one line."""
    for pattern in (r"LIGGGHTS, [^\n]*ERROR[^\n]*", r"FATAL (?:IO )?ERROR:?([\s\S]*?)\n\s*(?:\[\d+\]\s*)?(?:FOAM|From|file:)"):
        if found := re.search(pattern, log):
            return " ".join(re.sub(r"(?m)^\[\d+\]", "", found[found.lastindex or 0]).split())
    return " ".join(log[-600:].split())


def show(table, colours):
    width = max(len(row.name) for row in table)
    for row in table:
        word = f"{row.level:8}"
        if colours and row.level:
            word = f"\033[{COLOURS[row.level]}m{word}\033[0m"
        print(f"{word} {row.name:{width}}  {row.text}")


def main():
    parser = argparse.ArgumentParser(prog="hotbed check", description="Tells what decides stability and cost of a case, "
                                     "before it is run. Exit status 1 where the solver would refuse it.")
    parser.add_argument("case", type=Path, help="folder of the case")
    parser.add_argument("-np", type=int, default=1, metavar="N", help="MPI ranks (default 1)")
    parser.add_argument("--set", nargs="+", action="extend", default=[], metavar="name=value", help="as for `hotbed run`")
    parser.add_argument("--full", action="store_true", help="the full size, file settings.full")
    parser.add_argument("--seconds", type=float, default=10, metavar="S",
                        help="processor time of the first steps, run to measure what a step costs [s] (default 10)")
    options = parser.parse_args()
    try:
        changes = hotbed.assignments(options.set)
        case = options.case.resolve()
        if not (case / "system/controlDict").is_file() and (scripts := sorted(case.glob("in.*"))):
            raise hotbed.CaseError(f"{case} has no gas, only a LIGGGHTS script of its own ({scripts[0].name}): LIGGGHTS "
                                   "checks it when it runs, there is nothing to check here")
        facts, control, peak, refused = measure(case, changes, options.np, options.seconds, options.full)
    except hotbed.CaseError as problem:
        sys.exit(f"hotbed: {problem}")
    table = rows(facts, control, peak, refused, options.np)
    show(table, sys.stdout.isatty())
    sys.exit(1 if any(row.level == REFUSED for row in table) else 0)


if __name__ == "__main__":
    main()
