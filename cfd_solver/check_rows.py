"""The rows of `hotbed check`, from the facts that the solver tells of a case (check.hpp)."""

import math
from dataclasses import dataclass

OK, ADVICE, REFUSED, TOLD = "ok", "advice", "refused", ""

# Until particles have had the time to fall once through the height of their bed they are not in the contacts they will
# have: from there on a DEM step costs so much more, ((particles of a rank, factor), ...) (docs/check.md, `bench check`).
SETTLING = ((6000, 1.4), (46000, 1.8))
# Largest gas velocity in a bubbling bed over u0/voidage, for the gas step of a bed that has not settled (the same).
BUBBLES = 10
# Largest share of the particles over the mean of the ranks that goes without advice: the others wait a fifth of the DEM's time.
UNEVEN = 1.25
# The fewest coarse particles across a column whose cooling has been compared with the original's (docs/paper.md, mean temperature).
ACROSS = 8


@dataclass
class Row:
    """One line of the table. @param level OK, ADVICE, REFUSED, or TOLD for what is neither right nor wrong"""

    name: str
    level: str
    text: str


def number(value, unit=""):
    """A number as one reads it: 0.0004 s is 0.4 ms."""
    if unit in ("s", "m", "m/s") and value and abs(value) < 0.1 and unit != "m/s":
        for factor, prefix in ((1e3, "m"), (1e6, "u"), (1e9, "n")):
            if abs(value) * factor >= 0.1:
                return f"{value * factor:.3g} {prefix}{unit}"
    return f"{value:.3g} {unit}".strip() if abs(value) < 1e4 or unit else f"{value:,.0f}"


def duration(seconds):
    """Seconds, minutes or hours."""
    for name, size in (("h", 3600), ("min", 60)):
        if seconds > 2 * size:
            return f"{seconds / size:.3g} {name}"
    return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"


def scene(facts):
    """What the case consists of, what is on and what is left out."""
    count, ratio = facts["particles"], facts["ratio"]
    low, high, _ = facts["diameter"]
    size = number(high / ratio, "m") if high - low < 1e-9 * high else f"{number(low / ratio, 'm')} to {number(high / ratio, 'm')}"
    text = f"{count:,.0f} coarse, l = {ratio:g}, stand for {count * ratio**3:,.0f} of {size}" if count else "none at the start"
    yield Row("particles", TOLD, text)
    if "cells" not in facts:
        return
    drag, reaches = facts["drag"]
    heat, moving = facts["heat"], facts["moving"]
    contacts, other = [values for name, values in facts.every if name == "contact"], facts["otherContacts"]
    on = {f"drag ({drag})": drag != "none", "drag on the particles": drag != "none" and reaches and moving,
          "heat": heat, "particle motion": moving, "contacts": (contacts or other) and moving,
          **({} if other else {"friction": moving and any(c[4] > 0 for c in contacts)}), "turbulence": facts["turbulence"] != "laminar"}
    yield Row("on", TOLD, ", ".join(name for name, there in on.items() if there) or "nothing but the gas")
    out = [name for name, there in on.items() if not there]
    if out:
        yield Row("left out", TOLD, ", ".join(out))


def contacts(facts):
    """DEM steps in a contact, for each pair of types."""
    if not facts["moving"]:
        return
    found = [values for name, values in facts.every if name == "contact"]
    if facts["particles"] == 1:
        return
    if facts["otherContacts"]:
        scaled = ("" if facts["ratio"] == 1 else "; it takes its constants as those of the coarse particle, nothing scales them (stiffness "
                  "and dashpots by l^3: f_ID[4] to [7] of fix hotbed/coarsegrain)")
        yield Row("contact time", ADVICE, "no pair_style gran model hotbed in the DEM script: whether the DEM step is short "
                  f"enough for the contacts of another is not known here{scaled}")
    elif not found and facts["particles"]:
        yield Row("contact time", ADVICE, "no pair_style in the DEM script: particles pass through each other")
    elif not found:
        yield Row("contact time", ADVICE, "no particles yet: checked when they are inserted")
    for first, second, steps, least, _ in found:
        step = facts["demStep"]
        text = (f"{number(steps * step, 's')}, {steps:.3g} DEM steps of {number(step, 's')}; stable from {least:.3g}, "
                f"good from {2 * least:.3g}")
        level = REFUSED if steps < least else ADVICE if steps < 2 * least else OK
        if level != OK:
            share = steps / (least if level == REFUSED else 2 * least)
            text += f": set the DEM step to at most {step * share:.3g} s, or kn to at most {share**2:.3g} times what it is"
        yield Row(f"contact time {first:g}-{second:g}", level, text)


def gas_steps(facts, control):
    """The gas step as a number of DEM steps, and its Courant number."""
    step, wanted = facts["demStep"], float(control["deltaT"])
    count = wanted / step
    whole = max(1, round(count))
    if abs(count - whole) > 1e-6 * count:
        yield Row("gas step", REFUSED, f"deltaT is {count:.6g} DEM steps of {step:g} s: set it to a whole number of them, "
                  f"{whole * step:.6g} s")
        return
    if "cells" not in facts:
        return
    velocity = facts["u0"] / facts["voidage"][0]
    cell = facts["cell"][1]
    if not adjusts(control):
        courant = velocity * wanted / cell
        level = OK if courant <= 1 else ADVICE
        yield Row("gas step", level, f"{number(wanted, 's')}, {whole} DEM steps; Courant number {courant:.2g} at "
                  f"u0/voidage = {velocity:.3g} m/s" + ("" if level == OK else ": set deltaT to at most "
                  f"{max(1, math.floor(wanted / courant / step)) * step:.3g} s to resolve what travels with the gas"))
        return
    limit, longest = courant_limit(control), float(control["maxDeltaT"] or "inf")
    text = f"{number(wanted, 's')} at first, then up to {number(settled_step(facts, control), 's')} as maxCo {limit:g}"
    text += f" and maxDeltaT {number(longest, 's')} allow" if longest < math.inf else " allows"
    whole_cell = cell / max(velocity, 1e-300)  # time in which the gas crosses a cell
    text += f"; Courant number {min(longest / whole_cell, limit):.2g} at u0/voidage = {velocity:.3g} m/s"
    if limit > 1:
        yield Row("gas step", ADVICE, f"{text}: set maxCo to at most 1 to resolve what travels with the gas")
    elif limit * whole_cell < step:
        yield Row("gas step", ADVICE, f"{text}: one DEM step is longer than maxCo allows")
    else:
        yield Row("gas step", OK, text)


def output(control):
    """How often fields and restarts are written."""
    if control["writeControl"] not in ("adjustableRunTime", "runTime"):
        return
    interval, simulated = float(control["writeInterval"]), float(control["endTime"]) - float(control["startTime"] or 0)
    times = math.floor(simulated / interval * (1 + 1e-9))
    yield Row("output", TOLD, f"written every {number(interval, 's')}, {times} times" if times else
              "left out: the run ends before the first write time")


def adjusts(control):
    return control["adjustTimeStep"] in ("yes", "on", "true", "y", "t")


def courant_limit(control):
    return float(control["maxCo"] or 1)


def settled_step(facts, control):
    """Gas step of the bed once it bubbles [s]: as measured where it does so already, else from u0."""
    if not adjusts(control):
        return float(control["deltaT"])
    if settled(facts):
        steps, _, time, _ = facts["steps"]
        return time / steps
    even = facts["u0"] / facts["voidage"][0] / facts["cell"][1]
    return step_at(max(facts.get("courantRate", 0), (BUBBLES if facts["moving"] else 1) * even), facts, control)


def step_at(rate, facts, control):
    """Gas step where a step of a second had the Courant number `rate` [s]."""
    if not adjusts(control):
        return float(control["deltaT"])
    wanted = min(float(control["maxDeltaT"] or "inf"), courant_limit(control) / max(rate, 1e-300))
    return max(1, math.floor(wanted / facts["demStep"] * (1 + 1e-9))) * facts["demStep"]


def fall_time(facts):
    """Time of a fall through the height of the bed [s], 0 where nothing moves."""
    if not facts["moving"] or not facts["particles"] or not facts["voidage"][0] < 1:
        return 0.0
    return math.sqrt(2 * facts["solids"] / (1 - facts["voidage"][0]) / facts["section"] / 9.81)


def settled(facts):
    """Whether the measured steps came so far that the particles could fall through the height of their bed."""
    return "steps" in facts and facts["steps"][3] >= fall_time(facts)


def relaxation(facts, control):
    """Stiffness of drag and heat: both are implicit, any gas step is stable."""
    step = settled_step(facts, control)
    for name, key, what in (("drag", "dragTime", "velocity"), ("heat", "heatTime", "temperature")):
        if key not in facts or (key == "heatTime" and not facts["heat"]):
            continue
        particle, gas = facts[key]
        text = (f"particle follows the gas in {number(particle, 's')}, gas the particles in {number(gas, 's')}: "
                f"{step / particle:.2g} and {step / gas:.2g} times a gas step, implicit")
        if facts["moving"] and step > particle:
            yield Row(f"{name} stiffness", ADVICE, f"{text}; how particles come to the gas' {what} is not resolved: for that, "
                      f"gas steps of at most {number(particle, 's')}")
        else:
            yield Row(f"{name} stiffness", OK, text)


def mapping(facts):
    """Kernel, cells and particles against each other."""
    kernel, cell, largest = facts["kernel"], facts["cell"][0], facts["diameter"][1]
    if not facts["particles"]:
        return
    text = f"{number(kernel, 'm')} wide, {kernel / cell:.2g} cells, {kernel / largest:.2g} particles"
    if kernel > facts["domain"]:
        yield Row("kernel", ADVICE, f"{text}; wider than the domain of {number(facts['domain'], 'm')}: "
                  "set a smaller kernelWidth, windowLength or l")
    elif kernel < 2 * largest:
        yield Row("kernel", ADVICE, f"{text}: narrow, the voidage is rough and may be refused; set kernelWidth to 3")
    else:
        yield Row("kernel", OK, text)
    ratio = cell / largest
    text = f"smallest extent {number(cell, 'm')}, {ratio:.2g} particles; {facts['cells']:,.0f} cells"
    if ratio < 0.99:
        yield Row("cells", ADVICE, f"{text}: finer than the particles, which costs and shows nothing more, the kernel smooths "
                  f"over {number(kernel, 'm')}")
    elif ratio > 4 and facts["voidage"][0] < 0.9:
        yield Row("cells", ADVICE, f"{text}: coarse, bubbles of a few cells are lost; one to three particles show them")
    else:
        yield Row("cells", OK, text)
    mean, least = facts["voidage"]
    yield Row("voidage", OK if least > 0.3 else ADVICE, f"{mean:.3g} where the particles are, at least {least:.3g}"
              + ("" if least > 0.3 else ": particles overlap, or the kernel is narrow (kernelWidth)"))


def fluidisation(facts):
    """Velocities and pressure drop."""
    if "minimumFluidisation" not in facts or not facts["u0"]:
        return
    own, wen_yu, packed = facts["minimumFluidisation"]
    u0 = facts["u0"]
    weight = facts["mass"] * facts["gravity"] / facts["section"]
    drop = facts["fixedBedDrop"]
    if facts["moving"] and facts["gravity"]:
        terminal = facts["terminal"]
        text = (f"u0 = {u0:.3g} m/s is {u0 / own:.3g} times {own:.3g} m/s ({facts['drag'][0]} at voidage {packed:g}; "
                f"Wen and Yu: {wen_yu:.3g} m/s); terminal velocity {terminal:.3g} m/s")
        if u0 > terminal:
            yield Row("fluidisation", ADVICE, f"{text}: particles are carried out")
        elif u0 < own:
            yield Row("fluidisation", ADVICE, f"{text}: the bed stays packed")
        else:
            yield Row("fluidisation", OK, text)
            yield from column(facts)
        if u0 >= own:
            yield Row("pressure drop", TOLD, f"{number(weight)} Pa, the weight of the particles over the cross-section")
            return
    yield Row("pressure drop", TOLD, f"{number(drop)} Pa, a fixed bed at voidage {facts['voidage'][0]:.3g}")


def column(facts):
    """Room for the coarse particles of a fluidised bed; whether there is any for the original ones is not a matter of l."""
    ratio, across = facts["ratio"], facts["across"] / facts["diameter"][1]
    if ratio <= 1:
        return
    text = f"{number(facts['across'], 'm')} across, {across:.3g} coarse particles"
    if across > 0.999 * ACROSS:
        yield Row("column", OK, text)
    else:
        yield Row("column", ADVICE, f"{text}: fewer than {ACROSS} have not been compared with the original; set l to at "
                  f"most {max(across * ratio / ACROSS, 1):.3g}, or compare with a smaller one")


def gravity(facts):
    """Gravity stands in two places."""
    if facts["moving"] and facts["gravityApart"] > 1e-3 * max(facts["gravity"], facts["gravityApart"]):
        yield Row("gravity", ADVICE, f"that of constant/g and that of the DEM script are {number(facts['gravityApart'], 'm/s2')} apart: "
                  "make them the same")


def shares(facts, ranks):
    """How particles and cells are shared out among ranks, at the start."""
    if ranks == 1 or not facts["particles"]:
        return
    particles, cells = facts["imbalance"]
    text = f"the rank with most particles has {particles:.3g} times the mean, that with most cells {cells:.3g} times"
    if particles > UNEVEN and facts["moving"]:
        yield Row("shares", ADVICE, f"{text}: add 'fix balance all hotbed/balance' to the DEM script, or cut along other "
                  "directions (system/decomposeParDict, processors)")
    else:
        yield Row("shares", OK, text)


def cost(facts, control, peak, ranks):
    """Memory and time."""
    if peak:
        yield Row("memory", TOLD, f"{peak:.0f} MiB on each of {ranks} ranks" if ranks > 1 else f"{peak:.0f} MiB")
    if "cost" not in facts:
        return
    seconds, gas, dem = wall_time(facts, control, ranks)
    text = (f"about {duration(seconds)} for {control['endTime']} s with -np {ranks} on processors of its own: "
            f"{gas:,.0f} gas steps, {dem:,.0f} DEM steps")
    if not settled(facts):
        # the second half of what is run is measured
        _, _, time, _ = facts["steps"]
        enough = facts["cost"][0] + 2 * fall_time(facts) * facts["cost"][1] / time
        text += f"; the bed had not settled when it was measured, with --seconds {enough:.2g} it will have" if enough < seconds else ""
    yield Row("time", TOLD, text)


def wall_time(facts, control, ranks=1):
    """@return (seconds of the whole run, gas steps, DEM steps)"""
    steps, dem_steps, _, _ = facts["steps"]
    begin, measured, share = facts["cost"]
    gas_cost, dem_cost = measured * (1 - share) / steps, measured * share / dem_steps
    simulated = float(control["endTime"]) - float(control["startTime"] or 0)
    gas, dem = simulated / settled_step(facts, control), simulated / facts["demStep"]
    if settled(facts):
        return begin + gas * gas_cost + dem * dem_cost, gas, dem
    # until it settles as measured, then as the beds of the examples do
    calm = min(fall_time(facts), simulated) / simulated
    gas = (1 - calm) * gas + calm * simulated / step_at(facts["courantRate"], facts, control)
    return begin + gas * gas_cost + dem * dem_cost * (calm + (1 - calm) * dearer(facts["particles"] / ranks)), gas, dem


def dearer(particles):
    """Cost of a DEM step of a settled bed over that of its start, for so many particles on a rank."""
    (few, low), (many, high) = SETTLING
    share = math.log(max(particles, 1) / few) / math.log(many / few)
    return low + (high - low) * min(max(share, 0.0), 1.0)


def rows(facts, control, peak, refused, ranks):
    """The whole table."""
    table = list(scene(facts)) if "particles" in facts else []
    if "particles" in facts:
        table += [*output(control), *contacts(facts), *gas_steps(facts, control)]
    if "cells" in facts:
        table += [*relaxation(facts, control), *mapping(facts), *fluidisation(facts), *gravity(facts), *shares(facts, ranks), *cost(facts, control, peak, ranks)]
    if refused:
        table.append(Row("solver", REFUSED, refused))
    else:
        table.append(Row("solver", OK, "the case is set up and its first steps run"))
    return table
