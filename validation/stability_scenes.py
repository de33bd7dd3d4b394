"""The scenes of `./hotbed validate stability`: small copies of examples and of validation/hot_sphere, changed in one thing."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
SLIM_BED, FIXED_BED = ROOT / "examples" / "slim_bed", ROOT / "examples" / "fixed_bed"
HOT_SPHERE = ROOT / "validation" / "hot_sphere"
GRAVITY, COLD, HOT = 9.81, 293.15, 363.15
# of the slim bed's particles and gas
DENSITY, DIAMETER, VISCOSITY, GAS_DENSITY, STIFFNESS, STEP = 1040.0, 5e-4, 1.8e-5, 101325 / (8314.46 / 28.0134 * COLD), 500.0, 2.5e-5

# a bed of 269 coarse particles (l = 2.5) in 8 x 4 x 24 cells as large as they are
SLIM = {"l": 2.5, "width": 0.01, "depth": 0.005, "height": 0.03, "cellsWidth": 8, "cellsDepth": 4, "cellsHeight": 24,
        "solids": 2.75e-7, "endTime": 0.0015}
SLIM_EDITS = [
    ("constant/couplingProperties", r"^kernelWidth", "bedInterval 1;\nwriteRestart no;\nkernelWidth"),
    ("system/controlDict", r"^adjustTimeStep.*", "adjustTimeStep no;"),
    ("DEM/in.bed", r"^dump .*", "dump particles all custom ${snapshot} DEM/post/particles*.txt id x y z vx vy vz radius f_Temp"),
    ("DEM/in.bed", r"^variable +every .*", "variable every equal round(${writeInterval}/${deltaTDEM})\n"
     "variable snapshot equal ceil(${every}/20)"),
]
FIXED = {"l": 2.5, "height": 0.03, "cellsHeight": 20, "endTime": 0.1}
FIXED_EDITS = [("DEM/in.fixed_bed", r"^timestep", "dump particles all custom ${every} DEM/post/particles*.txt id x y z vx vy vz radius f_Temp\ntimestep")]


@dataclass
class Scene:
    """One row of the table."""

    kind: str            # rows of a kind differ in one number
    value: str           # that number
    case: Path = SLIM_BED
    settings: dict = field(default_factory=dict)
    edits: list = field(default_factory=list)  # (file, pattern, replacement)
    ranks: int = 1
    quick: bool = False  # belongs to --quick
    speed: float = 0.0   # [m/s] that something else than inlet gas and gravity explains
    range: tuple = (COLD, HOT)  # [K] of inlet, initial gas and particles
    leaves: str = ""     # "some" or "all": particles leave through the top
    refused: tuple = ()  # texts of the error; empty: it must run
    warned: tuple = ()   # texts of a warning
    then: list = None    # edits after which the run goes on from its restart, twice as long

    @property
    def name(self):
        return f"{self.kind}: {self.value}"


def slim(kind, value, settings=None, edits=(), **more):
    return Scene(kind, value, SLIM_BED, {**SLIM, **(settings or {})}, [*SLIM_EDITS, *edits], **more)


def fixed(kind, value, settings=None, edits=(), **more):
    return Scene(kind, value, FIXED_BED, {**FIXED, **(settings or {})}, [*FIXED_EDITS, *edits],
                 **{"range": (293.0, 393.0), **more})


def beetstra(voidage, reynolds):
    """Eq 5, written out here."""
    solids = 1 - voidage
    creeping = 10 * solids / voidage**2 + voidage**2 * (1 + 1.5 * np.sqrt(solids))
    top = 1 / voidage + 3 * voidage * solids + 8.4 * reynolds**-0.343
    return creeping + 0.413 * reynolds / (24 * voidage**2) * top / (1 + 10**(3 * solids) * reynolds**(-(1 + 4 * solids) / 2))


def relaxation(diameter, density, viscosity, u0, voidage=0.45):
    """m/B of an original particle at superficial velocity u0 [s]."""
    reynolds = GAS_DENSITY * u0 * diameter / viscosity
    return density * diameter**2 / (18 * viscosity * voidage * beetstra(voidage, max(reynolds, 1e-9)))


def minimum_fluidisation(diameter, density=DENSITY, viscosity=VISCOSITY):
    """Wen and Yu [m/s]."""
    archimedes = GAS_DENSITY * (density - GAS_DENSITY) * GRAVITY * diameter**3 / viscosity**2
    reynolds = archimedes * 0.0408 / (33.7 + np.sqrt(33.7**2 + 0.0408 * archimedes))
    return reynolds * viscosity / (GAS_DENSITY * diameter)


U_MF = minimum_fluidisation(DIAMETER)


def script(pattern, replacement):
    return ("DEM/in.bed", pattern, replacement)


def kn(value):
    return ("settings", r"^kn +\S+;", f"kn {value:.12g};")


def density(value):
    return script(r"density 1040", f"density {value:g}")


def original_diameter(value):
    return script(r"diameter 5e-4", f"diameter {value:.12g}")


def viscosity(value):
    """At the same heat conductivity."""
    return ("constant/thermophysicalProperties", r"mu 1\.8e-5; Pr 0\.72", f"mu {value:.12g}; Pr {0.72 * value / VISCOSITY:.12g}")


def gravity(direction):
    size = 1 if any(direction) else 0
    return [("constant/g", r"\(0 0 -9\.81\)", "(%g %g %g)" % tuple(GRAVITY * d for d in direction)),
            script(r"gravity 9\.81 vector 0 0 -1", f"gravity {GRAVITY * size:g} vector " +
                   ("%g %g %g" % tuple(direction) if size else "0 0 -1"))]


OPEN_TOP = [script(r"^fix +zhigh .*\n", ""), script(r"^thermo .*", "thermo 1000000\nthermo_modify lost ignore")]


def temperatures(particles, gas):
    return [script(r"initial_temperature 363\.15", f"initial_temperature {particles}"), ("0/T", r"293\.15", f"{gas}")]


def stiffness():
    kind = "hot sphere, stiffness h A dt/(m c) and of the gas"
    for b in (1e-8, 1e-4, 1.0, 1e4, 1e8):
        for g in (1e-6, 1.0, 1e6):
            yield Scene(kind, f"{b:.0e} and {g:.0e}", HOT_SPHERE, {"endTime": 50}, sphere(b, b / g), quick=b in (1e-8, 1e8) and g != 1.0)
    kind = "fixed bed, stiffness h A dt/(m c)"
    base = 0.09  # at the settings of the case
    for b in (1e-8, 1e-4, 1.0, 1e4, 1e8):
        yield fixed(kind, f"{b:.0e}", edits=[("DEM/in.fixed_bed", r"peratomtype 1500", f"peratomtype {1500 * base / b:.6g}")],
                    quick=b in (1e-8, 1e8))
    kind = "fixed bed, stiffness of the gas"
    base = 0.5
    for g in (1e-6, 1e-3, 1.0, 1e3, 1e6):
        f = base / g  # heat capacity of the gas, at the same conductivity
        yield fixed(kind, f"{g:.0e}", edits=[("constant/thermophysicalProperties", r"Cp 1000", f"Cp {1000 * f:.6g}"),
                                             ("constant/thermophysicalProperties", r"Pr 0\.72", f"Pr {0.72 * f:.6g}")],
                    quick=g in (1e-6, 1e6))
    kind = "slim bed, heat conductivity of the gas and heat capacity of particles"
    for k, c in ((1e-6, 1), (1e6, 1), (1e6, 1e-3), (1e3, 1e-6), (1e-3, 1e6)):
        yield slim(kind, f"x {k:.0e} and {c:.0e}", edits=[
            ("constant/thermophysicalProperties", r"Pr 0\.72", f"Pr {0.72 / k:.6g}"),
            script(r"peratomtype 779", f"peratomtype {779 * c:.6g}")], quick=(k, c) in ((1e6, 1e-3), (1e-3, 1e6)))


def sphere(b, ratio):
    """See validate_hot_sphere.py. @param ratio heat capacity of the gas over that of the sphere"""
    capacity = 800.0 * np.pi / 6 * 1e-9 * 1500.0
    voidage = 1 - np.pi / 6 * 1e-3
    nusselt = 7 - 10 * voidage + 5 * voidage**2
    return [("settings", r"^viscosity +\S+;", f"viscosity {b * capacity / (nusselt * np.pi * 1e-3) * 0.72 / 1000:.17g};"),
            ("settings", r"^rho +\S+;", f"rho {ratio * capacity / (voidage * 1e-6 * 1000):.17g};")]


# hot particles that are dropped into cold gas blow it up within a step or two, and light ones with it: where the motion is what
# is looked at, they start as cold as the gas and the inlet is hot
CALM = [("DEM/in.bed", r"initial_temperature 363\.15", f"initial_temperature {COLD}"), ("0/T", r"(?<=fixedValue; value uniform )293\.15", f"{HOT}")]

CONSTANT_DENSITY = [("constant/thermophysicalProperties", r"perfectGas", "rhoConst"),
                    ("constant/thermophysicalProperties", r"^( *)thermodynamics", f"    equationOfState {{ rho {GAS_DENSITY:.6g}; }}\n    thermodynamics")]


def particles():
    for kind, edits in (("drag relaxation time over the gas step", []), ("the same, gas of constant density", CONSTANT_DENSITY)):
        for ratio in (1e-4, 1e-2, 1.0, 1e2, 1e4):
            # by the viscosity, slower gas as it thickens; thin gas that drags by inertia only: heavier particles too
            rho = DENSITY if ratio < 1e3 else 2e4
            mu, u0 = thick(ratio, rho)
            yield slim(kind, f"{ratio:.0e} (viscosity {mu:.2g} Pa s)", {"u0": f"{u0:.6g}"},
                       [*CALM, *edits, viscosity(mu), density(rho), kn(STIFFNESS * rho / DENSITY)], quick=ratio in (1e-4, 1e4))
    kind = "particle density [kg/m3], kn in proportion"
    for rho in (0.1, 1.0, 30.0, 2e4):
        yield slim(kind, f"{rho:g}", edits=[*CALM, density(rho), kn(STIFFNESS * rho / DENSITY)], quick=rho in (0.1, 2e4))
    yield slim(kind, "0.1, gas of constant density", edits=[*CALM, *CONSTANT_DENSITY, density(0.1), kn(STIFFNESS * 0.1 / DENSITY)])
    yield slim("particle density [kg/m3], kn as for 1040", "0.1", edits=[density(0.1)], quick=True,
               refused=("in.bed", "timestep", "at most"))
    kind = "particle diameter [m], mesh in proportion, 1.5 u_mf, kn for the same contact time"
    for d in (1e-5, 1e-4, 2e-3, 1e-2):
        f = d / DIAMETER
        yield slim(kind, f"{d:g}", {**scaled(f), "u0": f"{1.5 * minimum_fluidisation(d):.6g}"},
                   [*CALM, original_diameter(d), kn(STIFFNESS * f**3)], quick=d in (1e-5, 1e-2))
    kind = "particle diameter [m], mesh as it is (1.25 mm), l = 1, 1.5 u_mf, kn for the same contact time"
    for d in (1e-5, 1e-4):
        yield slim(kind, f"{d:g}", {"l": 1, "solids": f"{500 * np.pi / 6 * d**3:.6g}", "u0": f"{1.5 * minimum_fluidisation(d):.6g}"},
                   [*CALM, original_diameter(d), kn(STIFFNESS * (d / DIAMETER)**3),
                    script(r"^neighbor .*", "atom_modify sort 0 0\nneighbor 1e-4 bin")],
                   quick=d == 1e-5)
    d = 1e-2
    yield slim(kind, f"{d:g} (8 cells wide)", {
        "l": 1, "width": 0.025, "depth": 0.025, "height": 0.05, "cellsWidth": 20, "cellsDepth": 20, "cellsHeight": 40, "endTime": 0.0005,
        "solids": f"{12 * np.pi / 6 * d**3:.6g}", "u0": f"{1.5 * minimum_fluidisation(d):.6g}"}, [*CALM, original_diameter(d), kn(STIFFNESS * (d / DIAMETER)**3)])
    kind = "coarse particle, cells wide"
    for width, n in ((0.1, (2, 1, 4)), (0.3, (6, 3, 12))):
        yield slim(kind, f"{width:g}", {"width": 0.025, "depth": 0.0125, "height": 0.05, "cellsWidth": n[0], "cellsDepth": n[1],
                                        "cellsHeight": n[2], "solids": 2e-6}, quick=width == 0.1)
    for width, n in ((1.0, (4, 4, 10)), (2.5, (10, 10, 25)), (5.0, (20, 20, 50))):
        yield slim(kind, f"{width:g}", {"width": 0.005, "depth": 0.005, "height": 0.0125, "cellsWidth": n[0], "cellsDepth": n[1],
                                        "cellsHeight": n[2], "solids": 8e-8}, quick=width == 5)
    kind = "coarse-graining ratio l"
    for l in (1, 1.5, 3, 4.5):
        yield slim(kind, f"{l}", {"l": l}, quick=l == 1)
    yield slim(kind, "10", {"l": 10, "width": 0.02, "depth": 0.01, "cellsWidth": 16, "cellsDepth": 8, "solids": 8e-7}, quick=True)


def thick(ratio, rho):
    """Viscosity that makes the drag relaxation time `ratio` gas steps, and a flow that the bed can bear [m/s]."""
    low, high = 1e-9, 1e6
    for _ in range(200):
        mu = np.sqrt(low * high)
        u0 = min(0.2, 0.2 * VISCOSITY / mu)
        low, high = (mu, high) if relaxation(DIAMETER, rho, mu, u0) / STEP > ratio else (low, mu)
    return mu, u0


def scaled(f):
    lengths = {k: f"{SLIM[k] * f:.12g}" for k in ("width", "depth", "height")}
    return {**lengths, "solids": f"{SLIM['solids'] * f**3:.12g}"}


def packing():
    kind = "fixed bed, voidage"
    for voidage in (0.2, 0.3, 0.95):
        solids = 1 - voidage
        yield fixed(kind, f"{voidage:g}", edits=[
            ("DEM/in.fixed_bed", r"0\.6(?=/v_volume)", f"{solids:g}"), ("DEM/in.fixed_bed", r"\(0\.6\*v_width", f"({solids:g}*v_width")],
            quick=voidage == 0.2)
    kind = "moving bed, overlapping at the start, voidage"
    for voidage in (0.2, 0.35):
        # simple cubic, what the springs hold sets the particles in motion: six of them a particle, shared by two
        spacing = (np.pi / 6 / (1 - voidage))**(1 / 3)
        d = 2.5 * DIAMETER
        spring = np.sqrt(3 * STIFFNESS * 2.5**3 * ((1 - spacing) * d)**2 / (DENSITY * np.pi / 6 * d**3))
        yield slim(kind, f"{voidage:g} (springs hold {spring:.1f} m/s)", edits=[script(r"1\.02\*", f"{spacing:.6g}*")], speed=spring, quick=voidage == 0.2)
    yield slim("particles in the domain", "1", {"solids": f"{np.pi / 6 * (2.5 * DIAMETER)**3:.12g}"}, quick=True)
    yield slim("particles in the domain", "7", {"solids": f"{7 * np.pi / 6 * (2.5 * DIAMETER)**3:.12g}"})


def steps():
    kind = "gas step, times 2.5e-5 s"
    for f, end in ((0.1, 0.00015), (10, 0.01), (30, 0.03), (100, 0.1)):
        yield slim(kind, f"{f:g}", {"deltaT": f"{STEP * f:.12g}", "endTime": end}, quick=f in (0.1, 100))
    kind = "k_n, times 500 N/m, at the same DEM step"
    for f in (0.01, 0.1, 1):
        yield slim(kind, f"{f:g}", {"endTime": 0.01, "deltaT": 1e-4}, [kn(STIFFNESS * f)], quick=f == 0.01)
    yield slim(kind, "2", {"endTime": 0.01, "deltaT": 1e-4}, [kn(STIFFNESS * 2)], warned=("in.bed", "timestep", "at most"))
    for f in (10, 100):
        yield slim(kind, f"{f:g}", edits=[kn(STIFFNESS * f)], refused=("in.bed", "timestep", "at most"), quick=f == 100)


def extremes():
    kind = "temperature of particles and gas [K]"
    for hot, cold in ((793.15, COLD), (2293.15, COLD), (COLD, 2293.15)):
        yield slim(kind, f"{hot} and {cold}", {"endTime": 0.005}, temperatures(hot, cold), range=(COLD, max(hot, cold)), quick=hot == 2293.15)
    kind = "inlet velocity, times u_mf"
    for f, end in ((0, 0.005), (0.5, 0.005), (20, 0.03), (60, 0.1)):
        fast = f >= 20
        yield slim(kind, f"{f:g}", {"u0": f"{f * U_MF:.6g}", "endTime": end, "deltaT": 5e-5}, OPEN_TOP if fast else [],
                   leaves={20: "some", 60: "all"}.get(f, ""), quick=f in (0, 60))
    yield slim("gravity", "0", {"endTime": 0.005}, gravity((0, 0, 0)), quick=True)
    yield slim("gravity", "sideways", {"endTime": 0.005}, gravity((1, 0, 0)), quick=True)
    yield slim("gravity", "upwards", {"endTime": 0.005}, gravity((0, 0, 1)))
    for f in (5, 50):
        yield slim("jet into a packed bed, times u_mf", f"{f:g}", {"u0": f"{f * U_MF:.6g}", "endTime": 0.01, "deltaT": 5e-5}, jet(), quick=f == 50)
    yield slim("inlet stops within a step", "from 0.5 m/s (table)", {"u0": 0.5, "endTime": 0.01},
               [("0/U", r"inlet .*", "inlet { type uniformFixedValue; uniformValue table ((0 (0 0 1)) (0.005 (0 0 1)) (0.005001 (0 0 0)) "
                 "(1 (0 0 0))); value uniform (0 0 1); }")], quick=True, speed=1.0)
    yield slim("inlet stops within a step", "from 0.5 m/s (restart)", {"u0": 0.5, "endTime": 0.005},
               [("constant/couplingProperties", r"^writeRestart no;", "writeRestart yes;")],
               then=[(r"inletVelocity +(uniform \(0 0 \S+\)|nonuniform[^;]*);", "inletVelocity uniform (0 0 0);")])
    kind = "cells graded along the height"
    for grading in (10, 100):
        yield slim(kind, f"{grading}:1", {"endTime": 0.005}, [("system/blockMeshDict", r"simpleGrading \(1 1 1\)", f"simpleGrading (1 1 {grading})")],
                   quick=grading == 10)
    kind = "skewed cells, largest angle to the orthogonal"
    for low, high in ((0.12, 0.22), (0.07, 0.27), (0.02, 0.32)):
        angle = np.degrees(np.arctan((high - low) * SLIM["height"] / SLIM["width"]))
        yield slim(kind, f"{angle:.0f} degrees", {"endTime": 0.005, "u0": 0.4}, skewed(low, high), quick=high == 0.32)
    for k in (10, 1e3):
        yield slim("skewed cells (42 degrees), hot inlet, heat conductivity of the gas", f"x {k:g}", {"endTime": 0.005, "u0": 0.4},
                   [*skewed(0.02, 0.32), *CALM, ("constant/thermophysicalProperties", r"Pr 0\.72", f"Pr {0.72 / k:.6g}")], quick=k == 1e3)
    kind = "skewed cells (24 degrees), coarse particle, smallest cells wide"
    wide = {"width": 0.02, "depth": 0.01, "cellsWidth": 16, "cellsDepth": 8, "solids": 1.6e-6, "endTime": 0.0005}
    yield slim(kind, "4", {"l": 5, **wide}, skewed(0.12, 0.42), quick=True)
    kind = "cells across"
    for n in ((8, 1, 24), (1, 1, 24), (1, 1, 1), (8, 4, 1)):
        yield slim(kind, "%d x %d x %d" % n, dict(zip(("cellsWidth", "cellsDepth", "cellsHeight"), n)) | {"endTime": 0.005},
                   # OpenFOAM's multigrid wants more than one cell
                   [("system/fvSolution", r"GAMG;\s*smoother\s+GaussSeidel;", "PCG;\n        preconditioner DIC;")] if n == (1, 1, 1) else [],
                   quick=n == (1, 1, 1))
    kind = "ranks"
    for value, processors, split in (("4, the bed on one of DEM and of gas", "1 1 4", "1 1 4"), ("4, on one of DEM, four of gas", "1 1 4", "4 1 1"),
                                     ("4, on four of DEM, one of gas", "4 1 1", "1 1 4")):
        yield slim(kind, value, {"height": 0.06, "cellsHeight": 48}, [script(r"^newton", f"processors {processors}\nnewton"),
                   ("system/decomposeParDict", r"n \(.*?\)", f"n ({split})")], ranks=4, quick=processors != split)


def jet():
    """An inlet in the middle of the bottom, a quarter of the width."""
    return [("system/blockMeshDict", r"(?s)vertices.*", """vertices
(
    (0 0 0) (#W1 0 0) (#W2 0 0) ($width 0 0) (0 $depth 0) (#W1 $depth 0) (#W2 $depth 0) ($width $depth 0)
    (0 0 $height) (#W1 0 $height) (#W2 0 $height) ($width 0 $height)
    (0 $depth $height) (#W1 $depth $height) (#W2 $depth $height) ($width $depth $height)
);
blocks
(
    hex (0 1 5 4 8 9 13 12) (3 $cellsDepth $cellsHeight) simpleGrading (1 1 1)
    hex (1 2 6 5 9 10 14 13) (2 $cellsDepth $cellsHeight) simpleGrading (1 1 1)
    hex (2 3 7 6 10 11 15 14) (3 $cellsDepth $cellsHeight) simpleGrading (1 1 1)
);
boundary
(
    inlet   { type patch; faces ((1 5 6 2)); }
    outlet  { type patch; faces ((8 9 13 12) (9 10 14 13) (10 11 15 14)); }
    walls   { type wall;  faces ((0 4 5 1) (2 6 7 3) (0 1 9 8) (1 2 10 9) (2 3 11 10) (3 7 15 11) (7 6 14 15) (6 5 13 14) (5 4 12 13) (4 0 8 12)); }
);
""".replace("#W1", f"{SLIM['width'] * 0.375:g}").replace("#W2", f"{SLIM['width'] * 0.625:g}"))]


def skewed(low, high):
    """Two blocks whose common face is oblique, within the bed: at `low` and `high` of the height at the two sides."""
    a, b = low * SLIM["height"], high * SLIM["height"]
    return [("system/blockMeshDict", r"(?s)vertices.*", f"""vertices
(
    (0 0 0)       ($width 0 0)       ($width $depth 0)       (0 $depth 0)
    (0 0 {a:g}) ($width 0 {b:g}) ($width $depth {b:g}) (0 $depth {a:g})
    (0 0 $height) ($width 0 $height) ($width $depth $height) (0 $depth $height)
);
blocks
(
    hex (0 1 2 3 4 5 6 7)   ($cellsWidth $cellsDepth 6) simpleGrading (1 1 1)
    hex (4 5 6 7 8 9 10 11) ($cellsWidth $cellsDepth 18) simpleGrading (1 1 1)
);
boundary
(
    inlet   {{ type patch; faces ((0 3 2 1)); }}
    outlet  {{ type patch; faces ((8 9 10 11)); }}
    walls   {{ type wall;  faces ((0 1 5 4) (1 2 6 5) (2 3 7 6) (3 0 4 7) (4 5 9 8) (5 6 10 9) (6 7 11 10) (7 4 8 11)); }}
);
""")]


def scenes():
    for group in (stiffness, particles, packing, steps, extremes):
        yield from group()
