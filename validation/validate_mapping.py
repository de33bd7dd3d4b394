"""Where the mapping puts the particles' volume on meshes of any cells, against kernel masses computed by sampling in Python.
`./hotbed validate mapping [--quick]`: --quick takes kernelSamples 1 and 2 only.

On each mesh: a few particles away from the walls, a few that touch them, and particles of the size of their surroundings
that fill the mesh evenly, one in each of the tetrahedra of which the cells are made; `misplaced` is the part of their volume that
lies in other cells than it should. The kernel is 3 mm wide, cells about 1.3 mm.
"""

import argparse
import shutil
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cfd_solver"))
import run as hotbed
import results
from mapping_scenes import MESHES, Mesh, graded

DIAMETER, WINDOW, SOLIDS = 1e-3, 3e-3, 0.4
PROPERTIES = """FoamFile { version 2.0; format ascii; class dictionary; object couplingProperties; }
demScript "DEM/in.bed"; drag none; heatTransfer none; kernel Deen; windowLength %g; kernelSamples %d; writeRestart no;
"""
SCRIPT = """units si
atom_style granular
boundary f f f
newton off
communicate single vel yes
atom_modify sort 0 0
neighbor 1e-4 bin
read_data DEM/particles.data
timestep 1e-3
"""
FIELD = "FoamFile {{ version 2.0; format ascii; class {}; object {}; }}\ndimensions [{}];\ninternalField uniform {};\nboundaryField {{ outlet {{ {} }} \".*\" {{ {} }} }}\n"


def make(case, mesh):
    """A case at rest on a mesh."""
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(ROOT / "examples/fixed_bed", case, ignore=shutil.ignore_patterns("DEM", "*.py", "README*"))
    (case / "DEM").mkdir()
    (case / "DEM/in.bed").write_text(SCRIPT)
    still, fixed = "type zeroGradient;", "type fixedValue; value uniform {};"
    for name, kind, dimensions, value, outlet in (
            ("T", "volScalarField", "0 0 0 1 0 0 0", "293", still), ("p", "volScalarField", "1 -1 -2 0 0 0 0", "101325", fixed.format("101325")),
            ("U", "volVectorField", "0 1 -1 0 0 0 0", "(0 0 0)", still)):
        (case / "0" / name).write_text(FIELD.format(kind, name, dimensions, value, outlet, "type noSlip;" if name == "U" else still))
    for name, value in (("deltaT", "1e-3"), ("endTime", "1e-3"), ("writeInterval", "1e-3"), ("height", "1")):
        hotbed.change_settings(case / "settings", {name: value})
    hotbed.change_settings(case / "system/controlDict", {"writePrecision": "16"})
    mesh(case)


def solids(case, positions, diameters, samples):
    """Solid volume of each cell [m3] that a run finds, and of each cell over all [m3] by OpenFOAM."""
    (case / "constant/couplingProperties").write_text(PROPERTIES % (WINDOW, samples))
    box = "".join(f"{a - 1e-3:.6g} {b + 1e-3:.6g} {name}lo {name}hi\n" for a, b, name in zip(positions.min(axis=0), positions.max(axis=0), "xyz"))
    (case / "DEM/particles.data").write_text(f"particles\n\n{len(positions)} atoms\n\n1 atom types\n\n{box}\nAtoms\n\n" + "".join(
        "%d 1 %.17g 1000 %.17g %.17g %.17g\n" % (n + 1, d, *x) for n, (x, d) in enumerate(zip(positions, diameters))))
    hotbed.run_case(case)
    hotbed.tool(case, "postProcess", "-func", "writeCellVolumes", "-time", "0.001")
    volume = results.field(case / "0.001/V")
    return (1 - results.field(case / "0.001/voidage")) * volume, volume


def few(mesh, walls):
    """Particles away from the walls, or touching them."""
    random = np.random.default_rng(5)
    centre = random.permutation(np.unique(mesh.tets[:, 0], axis=0))[:300]
    wall = mesh.nearest(centre, WINDOW)
    distance = np.linalg.norm(centre - wall, axis=1)
    if not walls:
        return centre[distance > 0.87 * WINDOW][:6]
    near = np.flatnonzero(distance < 0.8 * DIAMETER)[:6]
    return wall[near] + 0.5 * DIAMETER * (centre - wall)[near] / distance[near, None]


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate mapping", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="kernelSamples 1 and 2")
    options = parser.parse_args()
    figures = results.Figures("mapping")
    folder = Path("results") / "mapping" / ("validate-quick" if options.quick else "validate")
    volume = np.pi / 6 * DIAMETER**3
    for name, make_mesh in MESHES.items():
        case = folder / name.replace(" ", "_").replace(",", "")
        make(case, make_mesh)
        mesh = Mesh(case)
        scenes = {"away from walls": few(mesh, False), "at walls": few(mesh, True)}
        reference = {kind: volume * sum(mesh.kernel_masses(x, WINDOW / 2) for x in places) for kind, places in scenes.items()}
        boxes, before = make_mesh is graded, {}
        for samples in ((1, 2) if options.quick and not boxes else (1, 2, 4) if not boxes else (2,)):
            label = name if boxes else f"{name}, kernelSamples {samples}"
            # exact on boxes, to what the reference is; else of second order, from a quarter of a particle at one box a cell
            for kind, places in scenes.items():
                found, _ = solids(case, places, np.full(len(places), DIAMETER), samples)
                total = volume * len(places)
                misplaced = np.abs(found - reference[kind]).sum() / 2 / total
                figures.add(f"{label}: misplaced, {kind}", misplaced, 2e-3 if boxes else 0.5 * before.get(kind, 0.6))
                before[kind] = misplaced
                figures.add(f"{label}: volume in cells less particles', {kind}", abs(found.sum() / total - 1), 1e-13)
            sizes = np.cbrt(6 / np.pi * SOLIDS * mesh.volumes)
            found, cells = solids(case, mesh.tets.mean(axis=1), sizes, samples)
            rms = np.sqrt(np.average((found / cells - SOLIDS)**2, weights=cells))
            figures.add(f"{label}: even packing, voidage, rms deviation", rms, 0.04 if samples == 1 else 0.01)
            figures.note(f"{label}: even packing, voidage, largest deviation", np.abs(found / cells - SOLIDS).max())
    sys.exit(figures.close())


if __name__ == "__main__":
    main()
