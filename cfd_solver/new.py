"""Writes a case of a fluidised bed from a few numbers: examples/slim_bed with other settings. The verb `new` of ./hotbed."""

import argparse
import math
import re
import shutil
import sys
from pathlib import Path

import run as hotbed
from check_rows import ACROSS
from follow import COMMAND

EXAMPLE = hotbed.ROOT / "examples" / "slim_bed"
GRAVITY = 9.81
PACKED = 0.4         # voidage of a settled bed
OVERLAP = 0.01       # of the diameter, in the head-on impact of two original particles that sets kn
MOST = 20_000        # coarse particles where l is not given
CELL = 2.5           # original diameters in a cell, and at least one coarse one

# molar mass [g/mol], heat capacity [J/kg/K], Prandtl number; Sutherland's law: viscosity [Pa s] at a temperature [K], its
# constant [K] (White, Viscous Fluid Flow, table 1-2)
GASES = {"nitrogen": (28.0134, 1040, 0.72, 1.663e-5, 273.0, 107.0), "air": (28.96, 1006, 0.71, 1.716e-5, 273.0, 111.0)}


def viscosity(gas, temperature):
    """Dynamic viscosity of a gas by Sutherland's law [Pa s]."""
    *_, at, reference, constant = GASES[gas]
    return at * (temperature / reference) ** 1.5 * (reference + constant) / (temperature + constant)


def digits(value, count=2):
    """A number of few digits."""
    return float(f"{value:.{count}g}")


def round_step(seconds):
    """The longest step of few digits that is not longer, of which write times are whole numbers."""
    power = 10.0 ** math.floor(math.log10(seconds))
    return float(f"{max(f for f in (1, 1.25, 1.6, 2, 2.5, 3.2, 4, 5, 8) if f * power <= seconds * (1 + 1e-9)) * power:.6g}")


def design(o):
    """name -> value of the settings of a case. Raises CaseError where the numbers do not go together.

    kn: a head-on impact at the speed of a fall through the bed's height, or at u0, overlaps by OVERLAP of the diameter.
    DEM step: a contact has 10 of them, more where it is strongly damped. Gas step: as the Courant number allows, up to 160 of
    them.
    """
    width, depth, height = o.size
    section, ball = width * depth, math.pi / 6 * o.diameter**3
    packed_height = o.static_height or (o.solids / (1 - PACKED) / section if o.solids else height / 4)
    solids = o.solids or packed_height * section * (1 - PACKED)
    if solids > section * height:
        raise hotbed.CaseError(f"the particles' volume of {solids:.3g} m3 is more than the column's, {section * height:.3g} m3: set a "
                               "greater --size, or a smaller --static-height or --solids")
    room = math.floor(2 * min(width, depth) / (ACROSS * o.diameter) * (1 + 1e-9)) / 2  # the largest l that `check` does not advise against
    ratio = o.l or max(1.0, min(math.ceil(2 * (solids / ball / MOST) ** (1 / 3)) / 2, room))
    coarse = ratio * o.diameter
    if 3 * coarse > min(width, depth, height):
        raise hotbed.CaseError(f"the bed of {width:g} x {depth:g} m is narrower than the kernel, three coarse particles of "
                               f"{coarse:g} m: set --l to at most {min(width, depth, height) / 3 / o.diameter:.3g}, or a larger --size")
    lattice = 1.02 * coarse  # of the particles at the start, see DEM/in.bed
    filled = math.ceil(solids / (math.pi / 6 * coarse**3) / (int(width / lattice) * int(depth / lattice))) * lattice
    if filled > height:
        raise hotbed.CaseError(f"the particles fill {filled:.3g} m at the start, more than the height of {height:g} m: set a "
                               f"greater height in --size, or a smaller --static-height or --solids")
    if solids < math.pi / 6 * coarse**3:
        raise hotbed.CaseError(f"the particles' volume of {solids:.3g} m3 is less than one coarse particle: set a larger "
                               "--static-height or --solids, or a smaller --l")
    mass = o.density * ball
    speed = max(math.sqrt(2 * GRAVITY * packed_height), o.u0)
    kn = digits(mass / 2 * (speed / (OVERLAP * o.diameter)) ** 2)
    step = round_step(math.pi * math.sqrt(mass / (2 * kn)) / (10 / o.restitution ** (1 / 3)))
    cell = max(CELL * o.diameter, coarse)
    cells = [max(1, int(extent / cell * (1 + 1e-9))) for extent in o.size]
    return {"l": ratio, "u0": o.u0, "deltaT": digits(10 * step, 6), "maxDeltaT": digits(160 * step, 6), "deltaTDEM": step,
            "kn": kn, "endTime": o.end, "writeInterval": digits(o.end / 10, 6), "width": width, "depth": depth, "height": height,
            "cellsWidth": cells[0], "cellsDepth": cells[1], "cellsHeight": cells[2], "solids": digits(solids, 9)}


def replace(path, *changes):
    """Replaces regular expressions in a file of the copy; each must be there."""
    text = path.read_text()
    for pattern, replacement in changes:
        text, found = re.subn(pattern, lambda match: match.expand(replacement), text)
        if not found:
            raise hotbed.CaseError(f"{path} is not what `hotbed new` knows: nothing matches '{pattern}'")
    path.write_text(text)


def write(o, command):
    """Makes the case's folder. Raises CaseError."""
    settings = design(o)
    case = Path(o.name)
    if case.exists():
        raise hotbed.CaseError(f"{case} exists already: choose another name")
    shutil.copytree(EXAMPLE, case, ignore=shutil.ignore_patterns("README*", "log*", "__pycache__"))
    replace(case / "settings", (r"(?m)^(solids\s.*?;).*", r"\1 // volume of all particles [m3]"), (r"(?m)(\[N/m\]);.*", r"\1"))
    hotbed.change_settings(case / "settings", {name: f"{value:.9g}" for name, value in settings.items()})
    more = {"diameter": (o.diameter, "of the original particle [m]"), "density": (o.density, "of the particle [kg/m3]"),
            "restitution": (o.restitution, "coefficient, normal"), "friction": (o.friction, "coefficient"),
            "heatCapacity": (o.heat_capacity, "of the particle [J/kg/K]"),
            "temperature": (o.temperature, "of the particles at the start [K]"),
            "inletTemperature": (o.inlet_temperature, "of the gas at the inlet, and at the start [K]")}
    text = (case / "settings").read_text()
    (case / "settings").write_text(f"// Made by: {command}\n{text.rstrip()}\n"
                                   + "".join(f"{name:15} {value:.9g}; // {what}\n" for name, (value, what) in more.items()))
    replace(case / "DEM/in.bed", (r"\b5e-4\b", "${diameter}"), (r"density 1040\b", "density ${density}"),
            (r"(coefficientRestitution peratomtypepair 1) \S+", r"\1 ${restitution}"),
            (r"(coefficientFriction peratomtypepair 1) \S+", r"\1 ${friction}"),
            (r"(thermalCapacity peratomtype) \S+", r"\1 ${heatCapacity}"),
            (r"(initial_temperature) \S+", r"\1 ${temperature}"),
            (r"(?m)^# Hot gamma-alumina.*", "# Particles that start on a lattice above the inlet."))
    replace(case / "0/T", (r"\ndimensions", '\n#include "../settings"\n\ndimensions'), (r"293\.15", "$inletTemperature"))
    molar, capacity, prandtl, *_ = GASES[o.gas]
    replace(case / "constant/thermophysicalProperties", (r"molWeight \S+; \} // nitrogen", f"molWeight {molar}; }} // {o.gas}"),
            (r"Cp \S+;", f"Cp {capacity};"),
            (r"mu \S+; Pr \S+; \} // .*", f"mu {viscosity(o.gas, o.temperature):.4g}; Pr {prandtl}; }} "
             f"// mu at {o.temperature:g} K by Sutherland; k = mu Cp / Pr"))
    return settings


def ranged(low, high):
    """What argparse is to take: a number from low to high."""
    def number(text):
        value = float(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"must be a number >= {low:g}, <= {high:g}, not {text}")
        return value
    return number


def parser():
    positive = ranged(1e-12, 1e12)
    p = argparse.ArgumentParser(prog="hotbed new", description="Writes a case of a fluidised bed, ready to run, from a few numbers.")
    p.add_argument("name", help="folder of the new case")
    p.add_argument("--u0", type=positive, required=True, help="superficial gas velocity [m/s]; the bed bubbles at two to five "
                   "times the minimum fluidisation velocity that `hotbed check` tells")

    def number(name, default, what, allowed=positive):
        p.add_argument(name, type=allowed, default=default, help=f"{what} (default {default})")

    p.add_argument("--size", type=positive, nargs=3, metavar=("W", "D", "H"), default=[0.02, 0.01, 0.1],
                   help="width, depth, height of the column [m] (default 0.02 0.01 0.1)")
    number("--diameter", 5e-4, "of the original particle [m]")
    number("--density", 1040, "of the particle [kg/m3]")
    amount = p.add_mutually_exclusive_group()
    amount.add_argument("--solids", type=positive, help="volume of all particles [m3]")
    amount.add_argument("--static-height", type=positive,
                        help="height of the settled bed at voidage 0.4 [m] (default: a quarter of the column)")
    p.add_argument("--gas", choices=sorted(GASES), default="nitrogen", help="at 101325 Pa (default nitrogen)")
    p.add_argument("--l", type=positive, help=f"coarse-graining ratio [-] (default: for at most {MOST:,} particles)")
    number("--temperature", 363.15, "of the particles at the start [K]")
    number("--inlet-temperature", 293.15, "of the gas that comes in, and of that there is at the start [K]")
    number("--heat-capacity", 779, "of the particle [J/kg/K]")
    number("--restitution", 0.74, "coefficient, normal [-]", ranged(1e-12, 1))
    number("--friction", 0.1, "coefficient [-]", ranged(0, 1e6))
    number("--end", 0.5, "end time [s]")
    return p


def main():
    options = parser().parse_args()
    try:
        settings = write(options, " ".join([f"{COMMAND} new", *sys.argv[1:]]))
    except hotbed.CaseError as problem:
        sys.exit(f"hotbed: {problem}")
    count = settings["solids"] / (math.pi / 6 * (settings["l"] * options.diameter) ** 3)
    print(f"{options.name}: {count:,.0f} coarse particles, l = {settings['l']:g}, kn = {settings['kn']:g} N/m, "
          f"DEM step {settings['deltaTDEM']:g} s, {settings['cellsWidth']} x {settings['cellsDepth']} x {settings['cellsHeight']} "
          f"cells; numbers to change in {options.name}/settings\n"
          f"next: {COMMAND} check {options.name}, then {COMMAND} run {options.name}")


if __name__ == "__main__":
    main()
