"""What `./hotbed validate faults` puts into the small slim bed to blow it up, what the error must say, and how its runs are looked
at."""

import re
import subprocess

import results
import run as hotbed

STEP = 1e-4  # the longest gas step [s]
SMALL = {"l": "2.5", "width": "0.01", "depth": "0.005", "height": "0.03", "cellsWidth": "8", "cellsDepth": "4", "cellsHeight": "24",
         "solids": "2.75e-7", "maxDeltaT": "1e-4", "writeInterval": "0.001"}

SCRIPT = "DEM/in.bed"
RUNAWAY = ("particle", "with velocity", "blew up", "shorter timestep", "DEM/in.bed")
GAS = ("the gas blew up", "cell", "time step")
TEMPERATURE = ("particle", "has the temperature", "initial_temperature")
OVERLAP = ("particle", "overlaps", "made or inserted on top")
TRAPPED = ("a division by zero, an overflow or a number that is not finite", "likely")


def last(line):
    """A line more at the end of the script."""
    return SCRIPT, r"^timestep .*", "timestep ${deltaTDEM}\n" + line


def extra(*places):
    lines = "".join(f"create_atoms 1 single {place} units box\n" for place in places)
    return SCRIPT, r"^set +group all", f"{lines}set group all"


# name: (edits, texts of the error)
BLOW_UPS = {
    "a particle at 300 m/s": ([last("group one id 7\nvelocity one set 300 0 0")], ("particle 7", *RUNAWAY)),
    "all particles at 2000 m/s": ([last("velocity all set 0 0 2000")], RUNAWAY),
    "a jet of 1e6 m/s": ([("0/U", r"inlet .*", "inlet { type fixedValue; value uniform (0 0 1e6); }")], RUNAWAY),
    "a jet of 1e200 m/s": ([("0/U", r"inlet .*", "inlet { type fixedValue; value uniform (0 0 1e200); }")], ("not finite", "boundary value")),
    "particles at 1e7 K": ([(SCRIPT, r"363\.15", "1e7")], ("initial_temperature must be a number > 0",)),
    "particles at nan K": ([(SCRIPT, r"363\.15", "nan")], ("initial_temperature must be a number > 0",)),
    "a particle at -5 K": ([last("run 0\ngroup one id 7\nset group one property/atom Temp -5")], ("particle 7", *TEMPERATURE)),
    "gas at 0 K": ([("0/T", r"293\.15", "0")], TRAPPED),
    "gas at a negative pressure": ([("0/p", r"uniform 101325", "uniform -101325")], GAS),
    "two particles at one place": ([extra("0.005 0.0025 0.02", "0.005 0.0025 0.02")], ("two particles at one place",)),
    "two particles a micrometre apart": ([extra("0.005 0.0025 0.02", "0.005 0.0025 0.020001")], OVERLAP),
    "springs of a millionth": ([("settings", r"^kn +\S+;", "kn 5e-4;")], (*OVERLAP, "kn")),
    "a force of 1 kN on each particle": ([last("fix push all addforce 0 0 1e3")], (TRAPPED[0], "in the gas, cell", "time step")),
    "LIGGGHTS loses particles": ([(SCRIPT, r"^fix +zhigh .*\n", ""), last("thermo 100\nthermo_modify lost error\nvelocity all set 0 0 20")],
                                 ("Lost atoms", "The fastest on this rank was particle")),
}

# the same after some restarts, of which the last must then do: name: (edit, texts)
LATER = {
    "a particle at 300 m/s": (last("group one id 7\nvelocity one set 300 0 0"), ("particle 7", *RUNAWAY)),
    "a particle at 1e6 K": (last("run 0\ngroup one id 7\nset group one property/atom Temp 1e6"), ("particle 7", *TEMPERATURE)),
}


def solve(run, ranks=1):
    """@return (exit status, log)"""
    code = hotbed.start(run, ranks).wait(timeout=300)
    return code, (run / "log.hotbedFoam").read_text(errors="replace")


def shown(run):
    """As `solve`, on one rank, without a log file."""
    done = subprocess.run([hotbed.SOLVER, "-case", run], env=hotbed.environment(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, timeout=300)
    return done.returncode, done.stdout


def lacking(log, *texts):
    """What a log was to say and does not, newlines aside."""
    flat = " ".join(log.split())
    return [f"the log lacks '{text}'" for text in texts if text not in flat]


def goes_on(run, ranks, restart):
    """Goes on with a run for a few steps. @return what is wrong: an error, another start than the restart, energy lost"""
    hotbed.change_settings(run / "settings", {"endTime": f"{restart + 5 * STEP:.7g}"})
    code, log = solve(run, ranks)
    if code != 0:
        return [f"went on with exit status {code}: {' '.join(log[log.find('ERROR'):].split())[:200]}"]
    wrong = elsewhere(log, restart)
    budget = abs(results.bed(run)["budget_error"][-1])
    return wrong if budget < 1e-8 else [*wrong, f"energy not accounted for: {budget:.1e}"]


def elsewhere(log, restart):
    """What is wrong where a run has not gone on right after a restart."""
    first = float((re.findall(r"(?m)^Time = (\S+)", log) or ["nan"])[0])
    return [] if restart < first < restart + 1.1 * STEP else [f"went on at {first} s instead of after {restart} s"]
