"""What decides stability and cost of a case, told before it is run. The verb `check` of ./hotbed."""

import argparse
import math
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import run as hotbed

OK, ADVICE, REFUSED, TOLD = "ok", "advice", "refused", ""
COLOURS = {OK: 32, ADVICE: 33, REFUSED: 31}

# Until particles have had the time to fall once through the height of their bed they are not in the contacts they will
# have: from there on a DEM step costs so much more (docs/check.md).
SETTLING = 1.4
# Largest gas velocity in a bubbling bed over u0/voidage, for the gas step of a bed that has not settled (docs/check.md).
BUBBLES = 4


@dataclass
class Row:
    """One line of the table. @param level OK, ADVICE, REFUSED, or TOLD for what is neither right nor wrong"""

    name: str
    level: str
    text: str


class Facts(dict):
    """Lines `fact name values` of a log. Numbers are floats; a name that comes again is in `every`."""

    def __init__(self, log):
        super().__init__()
        self.every = []
        for name, text in re.findall(r"(?m)^fact (\w+) (.*)$", log):
            values = [float(v) if re.fullmatch(r"[-+]?[\d.]+(e[-+]?\d+)?", v) else v for v in text.split()]
            self.every.append((name, values))
            self[name] = values if len(values) > 1 else values[0]


def measure(case, changes, ranks, seconds):
    """Prepares a copy of a case in a folder that is thrown away, and lets the solver check it.

    @param seconds  processor time of the steps that are run to measure their cost
    @return (Facts, dictionary of controlDict, settings, the solver's own refusal or "")
    """
    with tempfile.TemporaryDirectory(prefix="hotbed-check-") as folder:
        target = Path(folder) / "case"
        hotbed.prepare(case, target, changes, ranks=ranks)
        control = {key: entry(target, key) for key in
                   ("endTime", "startTime", "deltaT", "adjustTimeStep", "maxCo", "maxDeltaT", "writeInterval")}
        command = [str(hotbed.SOLVER), "-case", str(target), "-check", str(seconds)]
        if ranks > 1:
            command = ["mpirun", "-np", str(ranks), *command, "-parallel"]
        done = subprocess.run(command, cwd=target, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              errors="replace", env=hotbed.environment())
        log = done.stdout.replace(str(target), str(case))
        warnings = re.findall(r"WARNING: (pair_style gran model hotbed.*)", log)
        return Facts(log), control, memory(log), refusal(log) if done.returncode else "", warnings


def entry(case, key):
    """An entry of controlDict with its variables filled in, None where it is missing."""
    found = subprocess.run(["foamDictionary", "-entry", key, "-value", "system/controlDict"], cwd=case, text=True,
                           capture_output=True, env=hotbed.environment())
    return found.stdout.split()[-1] if found.returncode == 0 and found.stdout.strip() else None


def memory(log):
    """Peak memory of a rank [MiB], None where the run did not come that far."""
    found = re.search(r"peak memory of a rank\s+(\S+) MiB", log)
    return float(found[1]) if found else None


def refusal(log):
    """What the solver said before it gave up, on one line."""
    for pattern in (r"LIGGGHTS, [^\n]*ERROR[^\n]*", r"FATAL (?:IO )?ERROR:?([\s\S]*?)\n\s*(?:\[\d+\]\s*)?(?:FOAM|From|file:)"):
        if found := re.search(pattern, log):
            return " ".join(re.sub(r"(?m)^\[\d+\]", "", found[found.lastindex or 0]).split())
    return " ".join(log[-600:].split())
