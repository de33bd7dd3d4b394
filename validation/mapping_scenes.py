"""Meshes of `./hotbed validate mapping`, their geometry, and kernel masses on them computed apart from Hotbed."""

import re
from pathlib import Path

import numpy as np
from scipy.stats import beta, qmc

import run as hotbed

HEADER = "FoamFile { version 2.0; format ascii; class dictionary; object blockMeshDict; }\nscale 1;\n"
CYLINDER = Path(__file__).resolve().parent.parent / "examples" / "cylinder_bed"


def cylinder(case):
    """O-grid, from the example."""
    (case / "system/blockMeshDict").write_text((CYLINDER / "system/blockMeshDict").read_text().replace(
        '#include "../settings"', "radius 0.008; height 0.008; cellsCore 6; cellsRing 3; cellsHeight 6;")
        .replace("inlet   { type patch;", "inlet   { type wall;"))
    hotbed.tool(case, "blockMesh")


def sector(case):
    """A sixth of a cylinder, of prisms at the axis."""
    x, y, h = 0.016 * np.cos(np.pi / 6), 0.008, 0.008
    (case / "system/blockMeshDict").write_text(HEADER + f"""
vertices ((0 0 0) ({x} {-y} 0) ({x} {y} 0) (0 0 {h}) ({x} {-y} {h}) ({x} {y} {h}));
blocks (hex (0 1 2 0 3 4 5 3) (11 9 6) simpleGrading (1 1 1));
edges (arc 1 2 (0.016 0 0) arc 4 5 (0.016 0 {h}));
boundary
(
    outlet {{ type patch; faces ((3 4 5 3)); }}
    walls {{ type wall; faces ((0 0 2 1) (0 1 4 3) (0 3 5 2) (1 2 5 4)); }}
);
""")
    hotbed.tool(case, "blockMesh")


def graded(case):
    """Boxes of sizes up to 1:5."""
    (case / "system/blockMeshDict").write_text(HEADER + """
vertices ((0 0 0) (0.014 0 0) (0.014 0.01 0) (0 0.01 0) (0 0 0.01) (0.014 0 0.01) (0.014 0.01 0.01) (0 0.01 0.01));
blocks (hex (0 1 2 3 4 5 6 7) (12 8 8) simpleGrading (5 1 0.2));
boundary
(
    outlet { type patch; faces ((4 5 6 7)); }
    walls { type wall; faces ((0 3 2 1) (0 1 5 4) (1 2 6 5) (2 3 7 6) (3 0 4 7)); }
);
""")
    hotbed.tool(case, "blockMesh")


def polyhedra(case):
    """Duals of a box of tetrahedra, six to a cube, inner corners moved at random."""
    n, size = (9, 7, 7), 0.0014
    random = np.random.default_rng(3)
    index = np.stack(np.meshgrid(*(np.arange(m + 1) for m in n), indexing="ij"), -1).reshape(-1, 3)
    inner = np.all((index > 0) & (index < np.array(n)), axis=1)
    points = size * (index + inner[:, None] * random.uniform(-0.15, 0.15, index.shape))
    number = lambda i: ((i[..., 0] * (n[1] + 1)) + i[..., 1]) * (n[2] + 1) + i[..., 2]
    steps = [np.eye(3, dtype=int)[list(order)] for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))]
    low = index[np.all(index < np.array(n), axis=1)]
    tets = np.concatenate([number(np.stack([low, low + s[0], low + s[0] + s[1], low + 1], 1)) for s in steps])
    side = np.linalg.det(points[tets[:, 1:]] - points[tets[:, :1]]) < 0
    tets[side] = tets[side][:, [0, 2, 1, 3]]
    faces = np.sort(np.concatenate([tets[:, [1, 2, 3]], tets[:, [0, 2, 3]], tets[:, [0, 1, 3]], tets[:, [0, 1, 2]]]), axis=1)
    faces, count = np.unique(faces, axis=0, return_counts=True)
    faces = faces[count == 1]
    top = np.all(index[faces][..., 2] == n[2], axis=1)
    elements = ["2 2 %d %d %d %d %d" % (t, t, *(f + 1)) for f, t in zip(faces, np.where(top, 1, 2))]
    elements += ["4 2 3 3 %d %d %d %d" % tuple(t + 1) for t in tets]
    (case / "tets.msh").write_text("\n".join([
        "$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "3", '2 1 "outlet"', '2 2 "walls"', '3 3 "gas"', "$EndPhysicalNames",
        "$Nodes", f"{len(points)}", *("%d %.12g %.12g %.12g" % (i + 1, *p) for i, p in enumerate(points)), "$EndNodes",
        "$Elements", f"{len(elements)}", *(f"{i + 1} {e}" for i, e in enumerate(elements)), "$EndElements", ""]))
    (case / "system/blockMeshDict").unlink()
    hotbed.tool(case, "gmshToFoam", "tets.msh")
    hotbed.tool(case, "polyDualMesh", "60", "-concaveMultiCells", "-overwrite")


MESHES = {"cylinder, O-grid": cylinder, "sector with prisms": sector, "polyhedra": polyhedra, "graded boxes": graded}


def lists(path):
    """The numbers in the brackets of a list of lists of OpenFOAM, one array an entry; of a flat list one array."""
    text = re.sub(r"//.*|/\*[\s\S]*?\*/", "", path.read_text())
    text = text[text.index("}") + 1:]
    body = text[text.index("(") + 1:text.rindex(")")]
    inner = re.findall(r"\(([^)]*)\)", body)
    return [np.array(t.split(), float) for t in inner] if inner else np.array(body.split(), float)


class Mesh:
    """Tetrahedra of the cells of an OpenFOAM mesh, and triangles of its boundary."""

    def __init__(self, case):
        mesh = case / "constant/polyMesh"
        points = np.array(lists(mesh / "points"))
        faces = [f.astype(int) for f in lists(mesh / "faces")]
        owner, neighbour = (lists(mesh / name).astype(int) for name in ("owner", "neighbour"))
        self.cells = owner.max() + 1
        triangles = [[], []]  # about the faces' centres: of the cells, of the boundary
        cell = [[], []]
        for n, f in enumerate(faces):
            corners = points[f]
            fan = np.stack([np.broadcast_to(corners.mean(axis=0), corners.shape), corners, np.roll(corners, -1, axis=0)], 1)
            for c, t in [(owner[n], fan)] + ([(neighbour[n], fan[:, ::-1])] if n < len(neighbour) else []):
                triangles[0].append(t)
                cell[0].append(np.full(len(t), c))
            if n >= len(neighbour):
                triangles[1].append(fan)
        surface, self.cell = np.concatenate(triangles[0]), np.concatenate(cell[0])
        self.boundary = np.concatenate(triangles[1])
        area = np.linalg.norm(np.cross(surface[:, 1] - surface[:, 0], surface[:, 2] - surface[:, 0]), axis=1)
        centre = np.stack([np.bincount(self.cell, area * x) for x in surface.mean(axis=1).T], 1) / np.bincount(self.cell, area)[:, None]
        self.tets = np.concatenate([centre[self.cell][:, None], surface], axis=1)  # [tets, 4, 3]
        self.volumes = np.abs(np.linalg.det(self.tets[:, 1:] - self.tets[:, :1])) / 6
        self.volume = np.bincount(self.cell, self.volumes)
        self.inverse = np.linalg.inv(np.swapaxes(self.tets[:, 1:] - self.tets[:, :1], 1, 2))
        self.low, self.high = self.tets.min(axis=1), self.tets.max(axis=1)

    def locate(self, x):
        """Cell of each point, -1 outside."""
        found = np.full(len(x), -1)
        order = np.argsort(x[:, 0])
        sorted_x = x[order]
        near = np.flatnonzero(np.all((self.high >= x.min(axis=0)) & (self.low <= x.max(axis=0)), axis=1))
        for t in near:
            some = slice(*np.searchsorted(sorted_x[:, 0], (self.low[t, 0], self.high[t, 0])))
            w = (sorted_x[some] - self.tets[t, 0]) @ self.inverse[t].T
            found[order[some][np.all(w >= 0, axis=1) & (w.sum(axis=1) <= 1)]] = self.cell[t]
        return found

    def nearest(self, x, reach):
        """Nearest point of the boundary to each point, at most `reach` beyond the box around all points."""
        best, where = np.full(len(x), np.inf), np.zeros_like(x)

        def offer(candidate, valid=True):
            d = np.sum((candidate - x)**2, axis=1)
            better = (d < best) & valid
            best[better], where[better] = d[better], candidate[better]

        low, high = self.boundary.min(axis=1), self.boundary.max(axis=1)
        for a, b, c in self.boundary[np.all((high >= x.min(axis=0) - reach) & (low <= x.max(axis=0) + reach), axis=1)]:
            normal = np.cross(b - a, c - a)
            normal /= np.linalg.norm(normal)
            foot = x - np.outer((x - a) @ normal, normal)
            inside = np.all([np.cross(q - p, foot - p) @ normal >= 0 for p, q in ((a, b), (b, c), (c, a))], axis=0)
            offer(foot, inside)
            for p, q in ((a, b), (b, c), (c, a)):
                along = np.clip((x - p) @ (q - p) / np.sum((q - p)**2), 0, 1)
                offer(p + along[:, None] * (q - p))
        return where

    def kernel_masses(self, x, half_width, points=2**15):
        """Mass of Deen's kernel in each cell, from points spread as the kernel is (each coordinate a beta distribution), those
        beyond the walls mirrored at the nearest point of the boundary."""
        u = qmc.Sobol(3, seed=1).random(points)
        at = x + half_width * (2 * beta.ppf(u, 3, 3) - 1)
        cell = self.locate(at)
        outside = cell < 0
        if np.any(outside):
            at[outside] = 2 * self.nearest(at[outside], half_width / 2) - at[outside]
            cell[outside] = self.locate(at[outside])
        return np.bincount(cell[cell >= 0], minlength=self.cells) / np.count_nonzero(cell >= 0)
