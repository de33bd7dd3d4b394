"""Tables and figures of the paper's campaign, from made-up runs whose distances are known."""

import contextlib
import io
import json
import shutil
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "validation"), str(ROOT / "cfd_solver")]
import paper_figures
import paper_tables
import results
import validate_paper

TIMES = (0.0, 0.1, 0.2, 0.3, 0.4)
HOT = 363.15
SETTINGS = "l {l};\nu0 {u0};\nwidth 0.02;\ndepth 0.01;\nheight 0.1;\ncellsHeight 80;\ndeltaTDEM 2.5e-6;\n"


def make_up(folder, l, u0, nusselt, cooling):
    """A run of 4000 particles in a bed of 50 mm. @param nusselt mean of their numbers; @param cooling mean of all layers [K]"""
    (folder / "DEM/post").mkdir(parents=True)
    (folder / "postProcessing/hotbed/0").mkdir(parents=True)
    (folder / "settings").write_text(SETTINGS.format(l=l, u0=u0))
    (folder / "postProcessing/hotbed/0/bed.csv").write_text("time_s,T_mean_K,Nu_mean\n" + "".join(
        f"{t},{HOT - cooling * t / 0.4},{nusselt}\n" for t in TIMES))
    random = np.random.default_rng(1)
    x, y, z, Nu = random.uniform(0, (0.02, 0.01, 0.05, 1), (4000, 4)).T
    for t in TIMES:
        rows = np.c_[np.arange(4000), x, y, z, np.full(4000, 2.5e-4 * l), HOT - cooling * t / 0.4 * (0.5 + Nu), Nu - 0.5 + nusselt]
        (folder / f"DEM/post/particles{round(t / 2.5e-6)}.txt").write_text(
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n4000\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n"
            "ITEM: ATOMS id x y z radius f_Temp f_Nusselt\n" + "".join(" ".join(f"{v:.9g}" for v in r) + "\n" for r in rows))
    return folder


class Paper(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = Path(cls.temporary.name)
        cls.stem = cls.folder / "paper"
        runs = {("1", "0.2", 1): (8.0, 10), ("2", "0.2", 1): (8.4, 11), ("2", "0.2", 1.000001): (8.4, 11), ("1", "0.3", 1): (7.0, 12),
                ("2", "0.3", 1): (7.0, 12)}
        cls.folders = {key: make_up(cls.folder / "-".join(map(str, key)), float(key[0]), key[1], *numbers)
                       for key, numbers in runs.items()}
        cls.made = paper_tables.make(cls.stem, cls.folders, np.linspace(0.1, 0.4, 50), 0.2)

    def test_distances_are_those_of_the_made_up_runs(self):
        found = paper_tables.distances(self.stem, HOT)
        self.assertEqual(len(found), 6)
        for name, value in found.items():
            with self.subTest(name):
                expected = 0 if "u0 = 0.3" in name or "repeats" in name else 0.4 / 8 if "Nusselt" in name else 1 / 10
                self.assertAlmostEqual(value, expected, delta=2e-4)

    def test_a_ratio_is_compared_with_the_finest_of_the_table(self):
        for u0, cooled, nusselt in ((0.2, 1 / 10, 0.4 / 8), (0.3, 0, 0)):
            figures = results.Figures("made_up")
            with contextlib.redirect_stdout(io.StringIO()):
                means, _ = validate_paper.compare(figures, u0, 2.6, paper_tables.Table(self.stem), 0.2)
            rows = {row["name"]: row for row in figures.rows}
            for what, expected in (("temperature, of the drop, beyond its bar", cooled), ("Nusselt number", nusselt)):
                with self.subTest(what, u0=u0):
                    row = rows[f"u0 = {u0:g} m/s, l = 2 against 1: mean {what}"]
                    self.assertAlmostEqual(row["value"], expected, delta=1e-6)
                    self.assertEqual(row["pass"], expected == 0)
            self.assertEqual(sorted(np.round(means, 6)), [8, 8.4, 8.4] if u0 == 0.2 else [7, 7])

    def test_densities_integrate_to_one(self):
        for table, x, y in (("nusselt", "Nu", "density"), ("temperature", "T_K", "density_per_K")):
            for key, lines in paper_tables.Table(self.stem, table).runs.items():
                with self.subTest(table, key=key):
                    if table == "temperature":
                        lines = lines[lines["time_s"] == 0.4]
                    self.assertAlmostEqual(lines[y].sum() * np.diff(lines[x])[0], 1, delta=6e-3)

    def test_runs_that_are_elsewhere_keep_their_lines_if_they_have_the_same_end(self):
        stem, again = self.folder / "pieces", ("2", "0.3", 1)
        tables = ("", "temperature", "profile", "nusselt")
        for table in tables:
            shutil.copy(paper_tables.path(self.stem, table), paper_tables.path(stem, table))
        before = {table: paper_tables.lines_by_key(stem, table) for table in tables}
        paper_tables.make(stem, {again: self.folders[again]}, np.linspace(0.1, 0.4, 50), 0.2)
        for table in tables:
            now = paper_tables.lines_by_key(stem, table)
            self.assertEqual(set(now), set(before[table]))
            for key in set(now) - {tuple(map(str, again))}:
                self.assertEqual(now[key], before[table][key])
        paper_tables.make(stem, {again: self.folders[again]}, np.linspace(0.1, 0.3, 50), 0.2)
        self.assertEqual(set(paper_tables.lines_by_key(stem, "")), {tuple(map(str, again))})

    def test_figures_of_runs_that_are_elsewhere_stay_with_their_date(self):
        with contextlib.redirect_stdout(io.StringIO()):
            before, now = (results.Figures("made_up", self.folder) for _ in range(2))
            for run, of in (("l = 1: ", before), ("l = 2: ", before), ("l = 3: ", before), ("l = 2: ", now)):
                of.add(run + "energy", 2 if of is now else 1, 3)
            before.close()
            now.keep(("l = 1: ", "l = 2: "))
            now.close()
        written = json.loads(now.path().read_text())
        rows = {row["name"]: row for row in written["figures"]}
        self.assertEqual({name: row["value"] for name, row in rows.items()}, {"l = 1: energy": 1, "l = 2: energy": 2})
        self.assertEqual([rows[f"l = {l}: energy"].get("date") for l in (1, 2)], [written["date"], None])

    def test_pictures_are_drawn_from_the_tables_alone(self):
        for made, number in (((({}), []), 5), (self.made, 7)):
            with tempfile.TemporaryDirectory() as place:
                paper_figures.draw(self.stem, *made, 0.2, place)
                self.assertEqual(len(list(Path(place).glob("paper_fig*.png"))), number)


if __name__ == "__main__":
    unittest.main(verbosity=2)
