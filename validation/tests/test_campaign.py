"""Which runs of a campaign count as done, and the bars of its means."""

import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
from scipy.stats import ttest_ind

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "validation"), str(ROOT / "cfd_solver")]
import campaign
import results

TABLE = "Timing (1 rank, 9 steps)\n    whole run    1.00\n"
LOG = "Time = 4.9998  Courant 1\nTime = 5.0001  Courant 1\n" + TABLE


class Campaign(unittest.TestCase):
    def done(self, log, end, restarts=()):
        """Of a run that was to end at 5 s and is wanted until `end`."""
        with tempfile.TemporaryDirectory() as place:
            run = Path(place)
            (run / "settings").write_text("endTime 5;\n")
            (run / "log.hotbedFoam").write_text(log)
            for time in restarts:
                (run / f"restart/{time}").mkdir(parents=True)
                (run / f"restart/{time}/state").touch()
            return campaign.done(run, {"endTime": end})

    def test_a_run_is_done_when_it_came_to_its_end_and_not_when_it_was_stopped(self):
        self.assertTrue(self.done(LOG, "5"))
        self.assertTrue(self.done(LOG.replace("5.0001", "4.99994"), "5"))
        self.assertTrue(self.done(LOG, "2.5"))
        self.assertFalse(self.done(LOG, "6"))
        self.assertFalse(self.done(LOG.replace("5.0001", "4.9999"), "5"))  # stopAt writeNow, at 4.9999 s
        self.assertFalse(self.done("Time = 3\n", "5"))
        self.assertFalse(self.done("\nStopped by signal 15 at 0.7 s, restart written\n" + TABLE, "5", ["0.5", "0.7"]))
        self.assertTrue(self.done("\nStopped by signal 15 at 0.7 s, restart written\n" + TABLE, "0.5", ["0.5", "0.7"]))

    def test_pieces_of_two_versions_go_together_with_the_columns_of_both(self):
        with tempfile.TemporaryDirectory() as place:
            with self.assertRaises(ValueError):
                results.bed(place)
            for start, text in (("0", "time_s,a,b\n1,10,100\n2,20,200\n3,30,300\n"),
                                ("2", "time_s,new,b\n3,0,301\n4,0,400\n5,0"), ("4", "time_")):
                folder = Path(place) / "postProcessing/hotbed" / start
                folder.mkdir(parents=True)
                (folder / "bed.csv").write_text(text)
            bed = results.bed(place)
            self.assertEqual(bed.dtype.names, ("time_s", "b"))
            self.assertEqual(bed.tolist(), [(1, 100), (2, 200), (3, 301), (4, 400)])

    def test_bar_of_a_mean_is_students(self):
        deviation, freedom = campaign.spread([np.array([1.0, 3.0]), np.array([2.0, 2.0, 5.0])])
        self.assertEqual(freedom, 3)
        self.assertAlmostEqual(deviation, (8 / 3)**0.5)
        self.assertAlmostEqual(campaign.bar(1.0, 3, 4), 3.182446 / 2, places=5)  # tables of the distribution

    def test_bar_from_blocks_is_students(self):
        self.assertAlmostEqual(campaign.bar_from_blocks([0.3], [0.4]), 2.306004 * 0.5, places=6)  # 8 degrees of freedom
        self.assertAlmostEqual(campaign.bar_from_blocks([0.3, 0.3]), 2.306004 * 0.3 / 2**0.5, places=6)

    def test_bar_of_a_difference_is_that_of_welchs_test(self):
        a, b = np.array([27.5, 21.0, 19.0, 23.6, 17.0, 17.9]), np.array([27.1, 22.0, 20.8, 23.4])
        bar = campaign.bar_of_difference(a, b)
        # where the difference is as large as its bar, the test's probability is 5 %
        shifted = a - a.mean() + b.mean() + bar
        self.assertAlmostEqual(ttest_ind(shifted, b, equal_var=False).pvalue, 0.05, places=10)


if __name__ == "__main__":
    unittest.main(verbosity=2)
