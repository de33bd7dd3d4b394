"""Runs that are told to end, that blow up, or whose restart is damaged. All kinds of faults: validation/validate_faults.py."""

import re
import signal
import time
import unittest

from scenes import CoupledTest, SLIM_BED, run
from fault_scenes import BLOW_UPS, SMALL


class Stopping(CoupledTest):
    example = SLIM_BED

    def running(self, name, ranks=1):
        """@return (folder, process) of a run in its time loop"""
        target = self.scene(name, ranks, **{**SMALL, "endTime": 10, "writeInterval": 10})
        process = run.start(target, ranks)
        patience = time.time() + 60
        while (target / "log.hotbedFoam").read_text().count("Time = ") < 10 and time.time() < patience:
            time.sleep(0.05)
        return target, process

    def last(self, target):
        return max(target.glob("restart/*/state"), key=lambda state: float(state.parent.name)).parent.name

    def goes_on(self, target, ranks=1):
        at = self.last(target)
        run.change_settings(target / "settings", {"endTime": f"{float(at) + 5e-4:.7g}"})
        code, log = self.solve(target, ranks)
        self.assertEqual(code, 0, log[-2000:])
        first = float(re.search(r"(?m)^Time = (\S+)", log)[1])
        self.assertTrue(float(at) < first < float(at) + 1.1e-4, f"{first} after {at}")

    def test_signals_write_a_restart(self):
        for number, ranks, expected in ((signal.SIGINT, 1, 130), (signal.SIGTERM, 1, 143), (signal.SIGUSR2, 2, 0)):
            with self.subTest(number.name):
                target, process = self.running(number.name, ranks)
                process.send_signal(number)
                self.assertEqual(process.wait(timeout=60), expected)
                self.assertIn("restart written", (target / "log.hotbedFoam").read_text())
                for rank in range(ranks if ranks > 1 else 0):
                    self.assertTrue((target / f"processor{rank}" / self.last(target) / "U").is_file())
                self.goes_on(target, ranks)

    def test_stop_at_write_now(self):
        target, process = self.running("writeNow")
        control = target / "system/controlDict"
        whole = control.read_text()
        control.write_text(whole.replace("stopAt              endTime;", "stopAt writeNow;"))
        self.assertNotEqual(control.read_text(), whole)
        self.assertEqual(process.wait(timeout=60), 0)
        control.write_text(whole)
        self.goes_on(target)

    def test_damaged_restart(self):
        target = self.scene("damaged", **{**SMALL, "endTime": "0.002"})
        self.assertEqual(self.solve(target)[0], 0)
        field = target / "0.002" / "h"
        whole = field.read_bytes()
        field.write_bytes(whole[:-300] + bytes([whole[-300] ^ 1]) + whole[-299:])
        run.change_settings(target / "settings", {"endTime": "0.0025"})
        code, log = self.solve(target)
        self.assertNotEqual(code, 0)
        self.assertIn("0.002/h is not as the run wrote it", " ".join(log.split()))
        (target / "restart/0.002/state").unlink()  # the mend it names
        self.goes_on(target)
        self.assertTrue((target / "0.002.unfinished").is_dir())

    def test_blow_up_names_the_particle(self):
        edits, texts = BLOW_UPS["a particle at 300 m/s"]
        for ranks in (1, 2):
            target = self.scene(f"fast{ranks}", ranks, edits, **{**SMALL, "endTime": "0.002"})
            code, log = self.solve(target, ranks)
            self.assertNotEqual(code, 0)
            for text in texts:
                self.assertIn(text, log)


if __name__ == "__main__":
    unittest.main(verbosity=2)
