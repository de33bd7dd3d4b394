"""The report of error against run time: bars that hold what they promise, the right choice, and a page that needs nothing else;
on made-up numbers and on tiny runs."""

import json
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "validation"), str(ROOT / "cfd_solver")]
import report
import report_errors
import report_page

TINY = ["--set", "l=2.5", "height=0.03", "endTime=0.3", "writeInterval=0.3"]


class MadeUpBed(report_errors.Record):
    """Uncorrelated noise about a mean Nusselt number, temperature that falls evenly."""

    def __init__(self, random, nusselt):
        lines = 2000
        self.end, self.start, self.dumps, self.read = 1.0, 0.4, {}, {}
        self.bed = np.zeros(lines, [(n, float) for n in ("time_s", "T_mean_K", "Nu_mean")])
        self.bed["time_s"] = np.linspace(0, 1, lines)
        self.bed["T_mean_K"] = 360 - 20 * self.bed["time_s"]
        self.bed["Nu_mean"] = nusselt + random.normal(0, 1, lines)


def row(group, seconds, **errors):
    return {"group": group, "choice": group != "reference", "folder": True, "seconds": seconds, "label": group,
            "errors": {f: report_errors.Error(*e) for f, e in errors.items()}}


class Errors(unittest.TestCase):
    def test_a_difference_that_is_not_there_is_hardly_ever_claimed(self):
        random, claimed = np.random.default_rng(1), 0
        for _ in range(200):
            error = report_errors.against_run(MadeUpBed(random, 10), MadeUpBed(random, 10))["nusselt"]
            claimed += error.value >= error.bar
        self.assertLess(claimed, 25, "5 % are 10 of 200")

    def test_a_difference_that_is_there_is_measured(self):
        random = np.random.default_rng(1)
        error = report_errors.against_run(MadeUpBed(random, 11), MadeUpBed(random, 10))["nusselt"]
        self.assertAlmostEqual(error.value, 0.1, delta=error.bar)
        self.assertLess(error.bar, 0.05)

    def test_bars_from_repeats_claim_as_rarely(self):
        random, claimed = np.random.default_rng(1), 0
        for _ in range(200):
            a, b, c, other = (MadeUpBed(random, random.normal(10, 1)) for _ in range(4))
            claimed += report_errors.against_run(other, a)["nusselt"].value >= report_errors.of_repeats([a, b, c])["nusselt"]
        self.assertLess(claimed, 25)


class Choice(unittest.TestCase):
    def test_cheapest_counts_the_bar(self):
        rows = [row("reference", 1, nusselt=(0, 0)), row("bar too large", 2, nusselt=(0.01, 0.06)),
                row("known", 4, nusselt=(0.03, 0.04)), row("better", 8, nusselt=(0.002, 0.001))]
        self.assertEqual(report.cheapest(rows, 0.05, ["nusselt"])["label"], "known")
        self.assertEqual(report.cheapest(rows, 0.01, ["nusselt"])["label"], "better")
        self.assertIsNone(report.cheapest(rows, 0.001, ["nusselt"]))

    def test_front(self):
        rows = [row("a", 1, gas=(0.1, 0)), row("b", 2, gas=(0.1, 0)), row("c", 3, gas=(0.05, 0)), row("d", 4, gas=(0.07, 0))]
        front = report_page.front(rows, lambda r: r["errors"]["gas"].known)
        self.assertEqual([r["label"] for r in front], ["a", "c"])

    def test_an_error_below_its_bar_is_not_shown(self):
        self.assertEqual(report_page.shown(report_errors.Error(0.01, 0.03)), "≤ 3 %")
        self.assertEqual(report_page.shown(report_errors.Error(0.03, 0.01)), "3 ± 1 %")


class Page(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = Path(self._folder.name)

    def tearDown(self):
        self._folder.cleanup()

    def report(self, *arguments):
        """@return (folder, JSON) of a report"""
        done = subprocess.run([sys.executable, report.__file__, *map(str, arguments), "--at-once", "1", "--results",
                               self.folder / "results"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        folder = Path(done.stdout.splitlines()[-1]).parent
        return folder, json.loads((folder / "report.json").read_text())

    def test_fixed_bed_against_the_exact_solution(self):
        order = ["fixed_bed", "--vary", "cellsHeight=10,20,40", "windowLength=1e-5", *TINY]
        folder, found = self.report(*order)
        runs = {r["changes"].get("cellsHeight"): r for r in found["rows"] if "cellsHeight" in r["changes"]}
        for figure in ("gas", "particles"):
            errors = [runs[cells]["errors"][figure]["error"] for cells in ("10", "20", "40")]
            self.assertEqual(errors, sorted(errors, reverse=True), "errors fall with the cells")
        failed = [r["changes"] for r in found["rows"] if r.get("failed")]
        self.assertEqual(failed, [{"windowLength": "1e-5"}])

        right = [r for r in found["rows"] if not r.get("failed") and r["largest_heat_error"] <= 0.05]
        name = " ".join(f"{k}={v}" for k, v in min(right, key=lambda r: r["wall_time_s"])["changes"].items())
        self.assertRegex(found["sentence"], rf"the cheapest within 5 %.* is {re.escape(name)} \(")

        page = (folder / "index.html").read_text()
        self.assertIn("the cheapest within 5 %", page)
        self.assertIn("the run failed", page)
        self.assertNotRegex(page, "https?://|<script|<link|@import|url\\(")
        sources = re.findall(r"""\b(?:src|srcset|href)\s*=\s*["']?([^"'>]{0,30})""", page)
        self.assertEqual(len(sources), 4)
        for source in sources:
            self.assertTrue(source.startswith("data:image/png;base64,"), source)
        for picture in ("front", "figures"):
            self.assertTrue((folder / f"{picture}.png").read_bytes().startswith(b"\x89PNG"))

        logs = {p: p.stat().st_mtime_ns for p in folder.rglob("log.hotbedFoam") if "windowLength" not in str(p)}
        self.report(*order)
        self.assertEqual(logs, {p: p.stat().st_mtime_ns for p in logs}, "finished runs are not repeated")

    def test_own_case_against_its_finest_run(self):
        case = self.folder / "mine"
        shutil.copytree(ROOT / "examples" / "fixed_bed", case)
        _, found = self.report(case, "--vary", "deltaT=5e-3,2e-2", "l=3", *TINY, "cellsHeight=20")
        self.assertEqual(found["rows"][0]["group"], "reference")
        self.assertEqual(found["rows"][0]["changes"], {})
        errors = {r["changes"].get("deltaT"): r["errors"]["temperature"]["error"] for r in found["rows"]
                  if "deltaT" in r["changes"]}
        self.assertLess(errors["5e-3"], errors["2e-2"])

    def test_refusals(self):
        for arguments, expected in {("nothing",): "neither one of fixed_bed, slim_bed nor the folder of a case",
                                    (ROOT / "examples/fluidized_bed",): "say what to vary",
                                    ("fixed_bed", "--vary", "cells=3"): "no setting 'cells'",
                                    ("fixed_bed", "--vary", "u0=0.2"): "give a --reference",
                                    ("fixed_bed", "--vary", "l"): "write name=value",
                                    ("fixed_bed", "--vary", "l=2,1", "endTime=1"): "endTime is the same for all runs of a report: --set endTime=..."}.items():
            with self.subTest(expected):
                done = subprocess.run([sys.executable, report.__file__, *map(str, arguments)], cwd=self.folder,
                                      capture_output=True, text=True)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn(expected, done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
