"""Every key of the dictionaries and every argument of the styles, read from the tables of docs, and what may be wrong with each."""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
HUGE = "1e300"
WHOLE = 2147483647  # the largest of OpenFOAM
WRONG = {"m": "[0 0 1 0 0 0 0]", "s": "[0 1 0 0 0 0 0]", "-": "[0 1 0 0 0 0 0]"}
RIGHT = {"m": "[0 1 0 0 0 0 0]", "s": "[0 0 1 0 0 0 0]", "-": "[0 0 0 0 0 0 0]"}
TABLES = {"key": "constant/couplingProperties", "key of controlDict": "system/controlDict", "command of the DEM script": "DEM script",
          "property/global": "property/global", "keyword": "model hotbed", "argument": None}


@dataclass
class Key:
    """One row of a table. `owner` is the dictionary or style, `values` how many words follow the name."""
    owner: str
    name: str
    values: int
    unit: str
    required: bool
    range: str

    @property
    def choices(self):
        return re.findall(r"`(\w+)`", self.range) if self.range.startswith("`") else []

    def holds(self, number):
        """Whether a number is in the range."""
        limits = re.findall(r"([<>]=?) (\S+)", self.range.replace(",", ""))
        tests = {">": number.__gt__, ">=": number.__ge__, "<": number.__lt__, "<=": number.__le__}
        return all(tests[sign](1.0 if limit.startswith("`") else float(limit)) for sign, limit in limits)

    @property
    def largest(self):
        found = re.search(r"<= ([\d.e]+)", self.range)
        return float(found[1]) if found else None


@dataclass
class Try:
    """`name` and `value` as they are written, None for left out; `runs`: whether this is allowed."""
    what: str
    name: str
    value: str
    runs: bool


def documented():
    """All keys of the tables of docs, in their order."""
    keys = []
    for page in [ROOT / "docs/case.md", *sorted((ROOT / "docs").glob("fix_*.md")), ROOT / "docs/pair_gran_hotbed.md"]:
        style = page.stem.replace("fix_nve_sphere_", "nve/sphere/").replace("fix_hotbed_", "hotbed/")
        for table in re.findall(r"(?m)(^\|.*\| default \| range \|\n\|[-|]+\n(?:\|.*\n)+)", page.read_text()):
            head, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
            owner = TABLES[head[0].replace("`", "")] or style
            for name, _, unit, default, allowed in rows:
                name, *values = name.strip("`").split()
                keys.append(Key(owner, name, len(values) or 1, unit, default.startswith("required"), allowed))
    return keys


def misspelt(name):
    """The name with its last two letters in the other order, or one left out where they are the same."""
    return name[:-2] + name[-1] + name[-2] if name[-1] != name[-2] else name[:-1]


def tries(key, base, dictionary):
    """What is tried with a key. @param base  a value that runs, one word for each value; @param dictionary  of OpenFOAM"""
    words = base.split() if key.values > 1 else [base]
    theirs = key.name in ("deltaT", "adjustTimeStep", "purgeWrite")  # OpenFOAM's: reads them first
    kept = key.name == "purgeWrite"
    yield Try("missing", None, None, not key.required)
    if not kept:  # OpenFOAM knows of none under another name either
        yield Try("misspelt", misspelt(key.name), base, False)
    if not dictionary:
        yield Try("value missing", key.name, " ".join(words[:-1]), False)
    else:
        yield Try("two values", key.name, f"{base} {base}", False)
        if not theirs:
            yield Try("a dictionary", key.name, None, False)
    if key.range == "a file":
        for what, value in ("no such file", '"nothing"'), ("a folder", '"DEM"'), ("empty", '""'), ("a number", "3"), ("a list", "(1 2)"):
            yield Try(what, key.name, value, False)
        return
    for value in key.choices:
        yield Try(f"'{value}'", key.name, value, True)
    if key.choices:
        for value in (misspelt(key.choices[0] + "e"), "3", "-1", "0.5", "nan", HUGE):
            yield Try(value, key.name, value, False)
        if dictionary:
            yield Try("a dimension", key.name, f"{WRONG['-']} {key.choices[0]}", False)
        return
    numbers = ["-1", "0", HUGE] + ([f"{1.001 * key.largest:.7g}"] if key.largest else [])
    if key.unit == "whole":
        numbers[3:] = [str(WHOLE), f"{key.largest:.0f}" if key.largest else "1", "2.5"]
    for place in range(len(words)):
        for number in [*numbers, "nan", "inf", "wide", "3x"]:
            value = " ".join(number if n == place else word for n, word in enumerate(words))
            good = re.fullmatch(r"[\d.e+-]+", number) is not None and key.holds(float(number))
            if key.unit == "whole":
                good = good and number.lstrip("-").isdigit() and not (kept and number == "1")
            yield Try(f"{number}{f' in place {place + 1}' if len(words) > 1 else ''}", key.name, value, good)
    if dictionary and key.unit in WRONG:
        yield Try("wrong dimension", key.name, f"{WRONG[key.unit]} {base}", False)
        if key.name != "deltaT":  # OpenFOAM's own, a plain number
            yield Try("right dimension", key.name, f"{RIGHT[key.unit]} {base}", True)
    elif dictionary:
        yield Try("a dimension", key.name, f"{WRONG['-']} {base}", False)
