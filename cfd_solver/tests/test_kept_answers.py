"""Gas steps in which particles answer as closures told for an earlier one (`closureCo`) err less than gas steps as long as closures are
kept, and the less the shorter they are kept. Reference: short steps, closures in each. That ranks agree with kept answers, and
that new particles do not wait for theirs, is in test_moving_bed and test_in_and_out."""

import unittest

import numpy as np

from scenes import SlimBedTest, TIGHT  # first: it finds the modules below
import results

START = 0.002  # [s], gas and particles have met by then
DUMP = ("DEM/in.bed", r"^dump .*", "dump particles all custom 2400 DEM/post/particles*.txt id f_Temp f_Nusselt\n"
        'dump_modify particles sort id format "%d %.17g %.17g"')
COLUMNS = ("T_mean_K", "Nu_mean", "pressure_drop_Pa", "z_mean_m")


class KeptAnswers(SlimBedTest):
    def solved(self, closureCo, step):
        """@return (bed.csv, temperature and Nusselt number by particle at the end, part of the gas steps with closures)"""
        edits = [("constant/couplingProperties", r"^kernelWidth", f"closureCo {closureCo};\nkernelWidth"), DUMP, *TIGHT]
        run, log = self.bed(f"closureCo{closureCo},{step}", edits=edits, endTime="0.006", deltaT=step, maxDeltaT=step)
        bed = results.bed(run)
        self.assertLess(bed["mismatch"].max(), 1e-13)
        self.assertLess(np.abs(bed["budget_error"]).max(), 1e-8)
        return bed, np.loadtxt(run / "DEM/post/particles2400.txt", skiprows=9)[:, 1:], results.evaluated(log)

    def test_they_err_less_than_steps_as_long(self):
        bed, particles, part = self.solved(0, "1e-5")
        self.assertEqual(part, 1.0)
        off = {}
        for closureCo, step, most in ((0.1, "1e-5", 0.4), (0.2, "1e-5", 0.2), (0, "5e-5", 1.0)):
            other, rows, part = self.solved(closureCo, step)
            self.assertLessEqual(part, most)
            after = other["time_s"] > START
            at = other["time_s"][after]
            off[closureCo] = {name: np.sqrt(np.mean((other[name][after] - np.interp(at, bed["time_s"], bed[name])) ** 2)) for name in COLUMNS}
            off[closureCo].update(zip(("T by particle", "Nu by particle"), np.sqrt(np.mean((rows - particles) ** 2, axis=0))))
            print(f"steps of {step} s, closureCo {closureCo}, closures in {part:.0%} of the steps: off by, rms, "
                  + ", ".join(f"{value:.2g} ({name})" for name, value in off[closureCo].items()))
        for name, step in off[0].items():
            self.assertLess(off[0.2][name], 0.5 * step, name)
            self.assertLess(off[0.1][name], off[0.2][name], name)


if __name__ == "__main__":
    unittest.main(verbosity=2)
