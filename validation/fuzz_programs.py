"""Inputs of the two programs, changed at random: arguments of our styles under the unmodified `liggghts`; couplingProperties,
controlDict, settings and restarts of hotbedFoam. Both with sanitizers."""

import math
import re
import shutil
import subprocess

import fuzz_mutations as mutate
import run as hotbed
import sanitized
from bad_input_keys import documented
from fault_scenes import SMALL

PATIENCE = 120  # [s], of the wall on a busy machine: a run takes one
COUPLING, CONTROL = "constant/couplingProperties", "system/controlDict"

SCRIPT = """units si
atom_style granular
boundary f f f
newton off
communicate single vel yes
region box block -0.005 0.005 -0.005 0.005 -0.005 0.005 units box
create_box 1 box
neighbor 1e-4 bin
neigh_modify delay 0
fix cg all hotbed/coarsegrain ratio 2 diameter 5e-4 density 1040 stiffness 500 restitution 0.74 0.1
fix capacity all property/global thermalCapacity peratomtype 1500
fix heat all hotbed/heat initial_temperature 363.15
fix drag all hotbed/drag
fix kn all property/global kn peratomtypepair 1 500
fix en all property/global coefficientRestitution peratomtypepair 1 0.74
fix et all property/global tangentialRestitution peratomtypepair 1 0.1
fix mu all property/global coefficientFriction peratomtypepair 1 0.1
pair_style gran model hotbed tangential hotbed vectorised on
pair_coeff * *
fix wall all wall/gran model hotbed tangential hotbed primitive type 1 zplane 0 vectorised on
create_atoms 1 single 0 0 4.9e-4 units box
create_atoms 1 single 9.9e-4 0 4.9e-4 units box
set group all diameter 1e-3 density 1040
fix integrate all nve/sphere/hotbed gravity 9.81 vector 0 0 -1
timestep 1e-6
"""
SHOW = "".join(f'variable v{n} equal f_cg[{n}]\nprint "value ${{v{n}}}"\n' for n in range(1, 8)) + 'variable e equal f_heat\nprint "value ${e}"\n'
# lines that are changed -> number of words that stay
CHANGED = {"fix cg": 4, "fix capacity": 5, "fix heat": 4, "fix drag": 4, "fix kn": 5, "fix en": 5, "fix et": 5, "fix mu": 5,
           "pair_style": 6, "fix wall": 11, "fix integrate": 4}


class Programs:
    """@param place  folder for scenes; @param reports  folder that the sanitizers write to"""

    def __init__(self, place, reports, build):
        self.place, self.reports, self.build = place, reports, build
        self.environment = {**hotbed.environment(), **sanitized.environment(reports)}
        self.keys = {}
        for key in documented():
            self.keys.setdefault(key.owner, []).append(key)
        self.started = self.resumed = None

    def call(self, command, folder, **more):
        """@return (exit status, what it printed, what is wrong with how it ended)"""
        try:
            done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=PATIENCE,
                                  env={**self.environment, **more})
        except subprocess.TimeoutExpired:
            return 1, "", [f"still running after {PATIENCE} s"]
        output = done.stdout.decode(errors="replace")
        findings = sanitized.reported(self.reports)[0]
        for path in self.reports.iterdir():
            path.unlink()
        ended = [] if done.returncode in (0, 1) or findings else [f"ended with {done.returncode}: {output[-500:]}"]
        said = "ERROR" in output or "MPI_ABORT" in output  # which loses what LIGGGHTS has printed into a pipe
        silent = ["no error, and not the end either"] if done.returncode == 1 and not findings and not said else []
        return done.returncode, output, findings + ended + silent

    def styles(self, dice, place):
        """One line of the script; a number beyond its range must be refused, one in it must not be for its range."""
        start = dice.choice(list(CHANGED))
        line = re.search(rf"(?m)^{start} .*", SCRIPT)[0]
        right = key = None
        if dice.random() < 0.5 and (key := dice.choice(self.keys.get(self.owner(line), [None]))) and not key.choices and key.name in line.split():
            parts, word = line.split(), mutate.number(dice, key)
            last = parts.index(key.name) + (1 if "peratom" in line else 0) + (1 if "peratomtypepair" in line else 0)
            parts[last + dice.randint(1, key.values)] = word
            changed, right = " ".join(parts), mutate.allowed(key, word)
        else:
            changed = mutate.words(dice, line, CHANGED[start])
        script = SCRIPT.replace(line, changed) + "run 3\n" + SHOW
        (place / "in.fuzz").write_bytes(script.encode("latin-1", "replace"))
        code, output, wrong = self.call(["liggghts", "-in", "in.fuzz", "-log", "none"], place,
                                        LD_PRELOAD=f"{sanitized.preload()}:{self.build}/liggghts_fixes/libhotbed_liggghts.so")
        values = re.findall(r"(?m)^value (\S+)$", output)
        if right is False and code == 0:
            wrong.append("runs, and is out of range")
        if right and f"{key.name} must be" in output:
            wrong.append("refused, and is in its range")
        if code == 0 and not all(math.isfinite(float(value)) for value in values):
            wrong.append(f"gives {values}")
        return changed, wrong

    def owner(self, line):
        return "property/global" if "property/global" in line else re.search(r"hotbed/\w+|nve/sphere/hotbed|$", line)[0]

    def scene(self, place, resumed=False):
        """A copy of a small case, prepared; with `resumed` one that ran and has a restart."""
        if not self.started:
            self.started = self.place / "started"
            sanitized.prepare("slim_bed", self.started, {**SMALL, "cellsWidth": "4", "cellsDepth": "2", "cellsHeight": "12",
                                                         "endTime": "1e-4", "writeInterval": "1e-4"})
            self.resumed = self.place / "resumed"
            shutil.copytree(self.started, self.resumed)
            hotbed.run_case(self.resumed)
            hotbed.change_settings(self.resumed / "settings", {"endTime": "1.5e-4"})
        shutil.copytree(self.resumed if resumed else self.started, place, dirs_exist_ok=True)

    def solve(self, place, *options):
        """As `call`; a run that came to its end has finite numbers in bed.csv."""
        code, output, wrong = self.call([str(self.build / "cfd_solver/hotbedFoam"), "-case", str(place), *options], place)
        if code == 0:
            if not output.rstrip().endswith("End"):
                wrong.append(f"exit status 0 without the end: {output[-300:]}")
            lines = [path.read_text().split("\n") for path in place.glob("postProcessing/hotbed/*/bed.csv")]
            bad = [line for text in lines for line in text[1:-1] if not all(math.isfinite(float(word or 0)) for word in line.split(","))]
            wrong += [f"bed.csv is not finite: {line}" for line in bad]
            wrong += ["bed.csv has no line"] * ("\nTime = " in output and not any(text[1:-1] for text in lines))
        return code, output, wrong

    def dictionaries(self, dice, place):
        """A key of couplingProperties or controlDict, or anything in couplingProperties."""
        self.scene(place)
        if dice.random() < 0.4:
            changed = mutate.text(dice, (place / COUPLING).read_text())
            (place / COUPLING).write_bytes(changed)
            return changed, self.solve(place, "-check", "0")[2]
        owner = dice.choice([COUPLING, CONTROL])
        key = dice.choice([k for k in self.keys[owner] if k.range != "a file" and k.name not in ("adjustTimeStep", "writeRestart")])
        word = mutate.number(dice, key) if not key.choices else dice.choice(mutate.WORDS)
        text = re.sub(rf"(?m)^({'kernelWidth|windowLength' if key.unit in 'm-' and owner == COUPLING else key.name})\s[^;]*;", "",
                      (place / owner).read_text())
        (place / owner).write_text(f"{text}\n{key.name} {word};\n")
        whole = key.unit == "whole" and not re.fullmatch(r"-?\d{1,9}", word)
        right = None if key.choices or whole or key.name in ("deltaT", "purgeWrite") else mutate.allowed(key, word)
        code, output, wrong = self.solve(place, "-check", "0")
        if right is False and code == 0:
            wrong.append("runs, and is out of range")
        if right and f"{key.name} must be" in output:
            wrong.append("refused, and is in its range")
        return f"{owner}: {key.name} {word};", wrong

    def settings(self, dice, place):
        """Lines more, or changed ones, of the settings that the solver hands on to LIGGGHTS."""
        self.scene(place)
        path = place / "settings"
        content = path.read_text()
        if dice.random() < 0.5:
            name = dice.choice([*mutate.WORDS, *(f"a{mark}b" for mark in mutate.MARKS), "resume", "restart", "d", "l"])
            value = dice.choice([*mutate.WORDS, *mutate.MARKS, '"two words"', "(1 2 3)", "{ a 1; }", "$l", "$nothing", '#include "nothing"'])
            changed = (content + f"\n{name} {value};\n").encode("latin-1", "replace")
        else:
            line = dice.choice(re.findall(r"(?m)^(?:u0|kn|maxDeltaT) .*", content))
            changed = content.encode().replace(line.encode(), mutate.text(dice, line, 2))
        path.write_bytes(changed)
        return changed, self.solve(place, "-check", "0")[2]

    def restarts(self, dice, place):
        """`state` or `checksums`. Where the checksums still stand, none may be taken that is not as it was written."""
        self.scene(place, resumed=True)
        folder = next((place / "restart").iterdir())
        name = dice.choice(["state", "checksums"])
        path, alone = folder / name, dice.random() < 0.7
        written = path.read_text()
        if alone and name == "state":
            (folder / "checksums").unlink()
            entry, word = dice.choice(re.findall(r"(?m)^ *(\w+) +(.*);", written)), dice.choice(mutate.WORDS)
            changed = re.sub(rf"(?m)^ *{entry[0]} .*", lambda m: f"{entry[0]} {word};", written).encode() if dice.random() < 0.5 else \
                mutate.text(dice, written)
        else:
            changed = mutate.text(dice, written)
        path.write_bytes(changed)
        code, output, wrong = self.solve(place)
        same = changed.decode("latin-1").split() == written.split()
        if code == 0 and name == "state" and not same and not alone:
            wrong.append("goes on from a state that is not as it was written")
        return changed, wrong
