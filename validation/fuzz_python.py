"""Files that the Python side reads, changed at random: settings, dictionaries, logs, bed.csv, dumps, restarts; and the numbers of
`hotbed new`. Each may only be read or refused by CaseError."""

import math
import re
import shutil
import warnings
from contextlib import redirect_stderr
from io import StringIO

import check
import follow
import fuzz_mutations as mutate
import new
import paraview
import run as hotbed

LOG = ("    DEM step          2.5e-06 s\n\nStarting time loop\n\n" + "".join(
    f"Time = {n}e-05  Courant 0.{n}123  DEM steps 40\nfact cells 768 0.5 word\nExecutionTime = 0.4 s\n" for n in range(1, 9)))
BED = "time_s,particles,pressure_drop_Pa,overlap_max,T_mean_K\n" + "".join(f"{n}e-05,269,12.5,0.0{n},363.1\n" for n in range(1, 9))
DUMP = ("ITEM: TIMESTEP\n40\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 0.01\n0 0.01\n0 0.03\n"
        "ITEM: ATOMS id x y z vx vy vz radius f_Temp \n1 0.001 0.002 0.003 0 0 0.1 5e-4 363.15\n2 0.004 0.002 0.003 0 0 -0.1 5e-4 300 \n")


class Readers:
    def __init__(self, place):
        self.place = place

    def attempt(self, action, *arguments):
        """@return what an input that cannot be read makes of itself other than a CaseError"""
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                action(*arguments)
            except hotbed.CaseError as refused:
                return [] if str(refused).strip() else ["refused without a word"]
            except Exception as problem:
                return [f"{action.__name__}: {type(problem).__name__}: {problem}"]
        return []

    def files(self, dice, place):
        """A case with one file changed, and what is done with cases."""
        case = place / "case"
        shutil.copytree(hotbed.ROOT / "examples/slim_bed", case)
        (case / "constant/polyMesh").mkdir()
        (case / "constant/polyMesh/boundary").write_text("FoamFile { version 2.0; }\n2\n(\n    inlet\n    {\n        type patch;\n    }\n)\n")
        file = dice.choice(["settings", "constant/couplingProperties", "system/controlDict", "system/decomposeParDict",
                            "constant/polyMesh/boundary", "DEM/in.bed"])
        changed = mutate.text(dice, (case / file).read_text())
        (case / file).write_bytes(changed)
        name, value = dice.choice(["l", "kn", "bedInterval", "maxCo", "nothing"]), dice.choice(mutate.WORDS)

        def change():
            hotbed.change_case(case, {name: value})
            target = hotbed.place(case, name)
            if hotbed.read_settings(case / target).get(name, value) != value:  # none where a mark before it is missing
                raise ValueError(f"--set {name}={value} is not in {target}")

        with no_tools():
            wrong = [self.attempt(action, *arguments) for action, *arguments in (
                (change,), (hotbed.prepare, case, place / "run", {}, False, 2), (hotbed.decompose, case, 3))]
        return f"{file}:\n".encode() + changed, sum(wrong, [])

    def runs(self, dice, place):
        """A run with one file changed, and what follows or continues runs."""
        run = place / "run"
        files = {"log.hotbedFoam": LOG, "postProcessing/hotbed/0/bed.csv": BED, "DEM/post/particles40.txt": DUMP}
        for name, content in files.items():
            (run / name).parent.mkdir(parents=True, exist_ok=True)
            (run / name).write_text(content)
        file = dice.choice(list(files))
        changed = mutate.text(dice, files[file])
        (run / file).write_bytes(changed)
        odd = dice.choice(["0.1", "1e-5", "copy", "0.1.old", "nan", ".x", "0.1 (copy)"])
        for folder in ("restart", "postProcessing/hotbed"):
            (run / folder / odd).mkdir(parents=True)
            (run / folder / odd / ("state" if folder == "restart" else "bed.csv")).write_text("time_s\n")
        log = changed.decode(errors="replace")
        with no_tools():
            wrong = [self.attempt(action, *arguments) for action, *arguments in (
                (follow.status, run, "log.hotbedFoam", 1e-4, 0.0, 1.0), (paraview.particles, run), (check.Facts, log), (check.refusal, log),
                (check.memory, log), (hotbed.resume, run))]
        return f"{file}, restart/{odd}:\n".encode() + changed, sum(wrong, [])

    def new(self, dice, place):
        """Numbers of `hotbed new`: refused, or settings that are finite and above zero."""
        numbers = re.findall(r"--[\w-]+", new.parser().format_usage())
        arguments = [str(place / "case"), "--u0", "0.2"]
        for option in dice.sample([o for o in numbers if o not in ("--gas", "--u0", "--help")], dice.randint(1, 4)):
            arguments += [option, *(word(dice) for _ in range(3 if option == "--size" else 1))]

        def write():
            with redirect_stderr(StringIO()):
                try:
                    options = new.parser().parse_args(arguments)
                except SystemExit:
                    return
            settings = new.write(options, "")
            bad = {name: value for name, value in settings.items() if not (math.isfinite(value) and value > 0)}
            if bad:
                raise ValueError(f"settings {bad}")

        return " ".join(arguments[1:]), self.attempt(write)


def word(dice):
    return dice.choice(mutate.WORDS) if dice.random() < 0.4 else f"{10 ** dice.uniform(-12, 12):.6g}"


class no_tools:
    """OpenFOAM's programs are not run."""

    def __enter__(self):
        self.tool, hotbed.tool = hotbed.tool, lambda *arguments: None
        self.box, hotbed.box = hotbed.box, lambda run: ([0.02, 0.01, 0.1], [0, 0, -9.81])

    def __exit__(self, *problem):
        hotbed.tool, hotbed.box = self.tool, self.box
