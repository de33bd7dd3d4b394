"""The page of a run: its figures against the files of the run and the scene, the state of a run that goes, was stopped or was
killed, and a folder that holds none."""

import json
import re
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ("validation", "cfd_solver", "cfd_solver/tests")]
import report
import run as hotbed
from scenes import CoupledTest, SLIM_BED

WIDTH, DEPTH, SOLIDS = 0.01, 0.005, 2.75e-7
SMALL = {"l": 2.5, "width": WIDTH, "depth": DEPTH, "height": 0.03, "cellsWidth": 8, "cellsDepth": 4, "cellsHeight": 24,
         "solids": SOLIDS, "maxDeltaT": 1e-4}


def report_of(folder, *words):
    """@return (exit status, what is printed)"""
    done = subprocess.run([sys.executable, report.__file__, folder, *words], capture_output=True, text=True, cwd="/")
    return done.returncode, done.stdout + done.stderr


class RunPage(CoupledTest):
    example = SLIM_BED

    def page(self, target):
        """@return (HTML, JSON) of a run"""
        code, text = report_of(target)
        self.assertEqual(code, 0, text)
        self.assertEqual(text.strip(), str(target.resolve() / "report.html"))
        page = (target / "report.html").read_text()
        self.assertNotRegex(page, "https?://|<script|<link|@import|url\\(")
        for source in re.findall(r"""\b(?:src|srcset|href)\s*=\s*["']?([^"'>]{0,40})""", page):
            self.assertRegex(source, r"^data:image/(png|svg\+xml);base64,")
        return page, json.loads((target / "report.json").read_text())

    def test_a_finished_run(self):
        noisy = [("DEM/in.bed", r"^timestep", 'print "WARNING: a made-up one"\ntimestep')]
        target = self.scene("u0=0.2,l=2.5", edits=noisy, **SMALL, endTime=0.004, writeInterval=0.001)
        code, log = self.solve(target)
        self.assertEqual(code, 0, log[-2000:])
        page, found = self.page(target)
        self.assertEqual((found["state"], found["ranks"], found["pieces"]), ("finished", 1, 1))
        figures = found["figures"]
        self.assertAlmostEqual(figures["simulated_s"], 0.004, delta=1e-12)
        self.assertEqual(figures["dem_steps"], 1600)
        self.assertEqual(figures["gas_steps"], log.count("\nTime = "))
        self.assertAlmostEqual(figures["gas_step_mean_s"] * figures["gas_steps"], 0.004, delta=1e-12)
        number = round(SOLIDS / (np.pi / 6 * 1.25e-3**3))
        self.assertEqual(figures["particles"], number)
        weight = number * np.pi / 6 * 1.25e-3**3 * 1040 * 9.81 / (WIDTH * DEPTH)
        self.assertAlmostEqual(figures["weight_mean_Pa"], weight, delta=1e-9 * weight)
        rows = np.genfromtxt(target / "postProcessing/hotbed/0/bed.csv", delimiter=",", names=True)
        self.assertEqual(figures["temperature_mean_K"], rows["T_mean_K"][-1])
        self.assertEqual(figures["overlap_largest"], rows["overlap_max"].max())
        late = rows[rows["time_s"] >= 0.0016]
        self.assertGreaterEqual(figures["nusselt_mean"], late["Nu_mean"].min())
        self.assertLessEqual(figures["nusselt_mean"], late["Nu_mean"].max())

        self.assertEqual({s["name"]: s["value"] for s in found["settings"]}["l"], "2.5")
        self.assertEqual(found["coupling"]["drag"], "Beetstra")
        self.assertRegex(found["versions"]["Hotbed"], r"^\d+\.\d+\.\d+$")
        self.assertTrue({"OpenFOAM", "LIGGGHTS", "MPI"} <= set(found["versions"]))
        for name in ("OpenFOAM", "LIGGGHTS", "MPI"):
            self.assertRegex(log, rf"(?m)^    {name} +{re.escape(found['versions'][name])}$")
        self.assertIn("Energy budget [J]", [name for name, _ in found["budget"]])
        self.assertNotIn("Solving", str(found["budget"]))
        whole = found["timing"][-1]
        self.assertEqual(whole["phase"], "whole run")
        self.assertAlmostEqual(sum(r["mean_s"] for r in found["timing"] if not r["part"]), 2 * whole["mean_s"], delta=0.2)
        self.assertEqual(found["wall_s"], whole["mean_s"])
        self.assertEqual(found["warnings"], {"LIGGGHTS: a made-up one": 1})
        for text in ("Finished: 0.004 s", "particle temperature over time", "weight of the bed", "Nusselt number over time",
                     "bed height over time", "largest overlap over time", "Courant number over time", "gas step over time",
                     "by particle temperature", "by Nusselt number", "a made-up one", "neighbour lists"):
            self.assertIn(text, page)

    def test_going_stopped_and_killed(self):
        target = self.scene("slow", **SMALL, endTime=1000, writeInterval=0.002)

        def start(until):
            process = hotbed.start(target)
            deadline = time.time() + 200
            while not any(float(p.parent.name) >= until for p in target.glob("restart/*/state")) and time.time() < deadline:
                time.sleep(0.1)
            return process

        process = start(0.002)
        page, found = self.page(target)
        self.assertEqual(found["state"], "going", found["sentence"])
        self.assertIn("no timing table", page)
        process.send_signal(signal.SIGUSR2)
        self.assertEqual(process.wait(100), 0)
        _, found = self.page(target)
        self.assertEqual(found["state"], "stopped")
        self.assertRegex(found["sentence"], r"of 1000 s\. It goes on from its restart of \S+ s")
        first = found["figures"]["simulated_s"]
        self.assertEqual(found["timing"][-1]["phase"], "whole run")

        process = start(first + 0.003)
        process.kill()
        process.wait(100)
        page, found = self.page(target)
        self.assertEqual((found["state"], found["pieces"]), ("ended", 2))
        self.assertGreater(found["figures"]["simulated_s"], first)
        # steps of both pieces follow each other
        self.assertEqual(found["figures"]["dem_steps"], round(found["figures"]["simulated_s"] / 2.5e-6))

    def test_failed(self):
        target = self.scene("failed", edits=[("constant/couplingProperties", r"^drag .*", "drag Bestra;")], **SMALL)
        self.assertNotEqual(self.solve(target)[0], 0)
        _, found = self.page(target)
        self.assertEqual(found["state"], "failed")
        self.assertIn("drag must be one of", found["sentence"])

    def test_no_run(self):
        code, text = report_of(self.folder)
        self.assertNotEqual(code, 0)
        for missing in ("system/controlDict", "log.hotbedFoam"):
            self.assertIn(missing, text)
        code, text = report_of(SLIM_BED.parent / "fluidized_bed")
        self.assertNotEqual(code, 0)
        self.assertIn("is a case, not the folder of a run (log.hotbedFoam is missing there): say what to vary", text)
        (self.folder / "log.hotbedFoam").write_text("")
        code, text = report_of(self.folder)
        self.assertNotEqual(code, 0)
        self.assertIn("holds no run: system/controlDict is missing there", text)


if __name__ == "__main__":
    unittest.main(verbosity=2)
