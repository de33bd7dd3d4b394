"""The series for ParaView of a run that stopped and went on: what the dumps and the fields hold, at their times."""

import base64
import subprocess
import sys
import unittest
import xml.etree.ElementTree as ElementTree

import numpy as np

from scenes import CoupledTest, ROOT, run  # first: it finds the modules below
import paraview
import results

SLIM_BED = ROOT / "examples" / "slim_bed"
TYPES = {"Float32": np.float32, "Int32": np.int32, "UInt8": np.uint8}


def pieces(pvd):
    """[(time, path)] of a series."""
    return [(float(d.get("timestep")), pvd.parent / d.get("file")) for d in ElementTree.parse(pvd).iter("DataSet")]


def arrays(path, part):
    """name -> values of the arrays in a part (Points, PointData, ...) of a VTK XML file."""
    values = {}
    for item in ElementTree.parse(path).find(f".//{part}"):
        if item.get("format") == "ascii":
            flat = np.array(item.text.split(), float)
        else:
            packed = base64.b64decode("".join(item.text.split()))
            flat = np.frombuffer(packed[8:], TYPES[item.get("type")])
            assert np.frombuffer(packed[:8], np.uint64)[0] == flat.nbytes
        n = int(item.get("NumberOfComponents", 1))
        values[item.get("Name")] = flat.reshape(-1, n) if n > 1 else flat
    return values


class Series(CoupledTest):
    example = SLIM_BED

    def command(self, *arguments):
        done = subprocess.run([sys.executable, run.__file__, SLIM_BED, "--results", self.folder, "--set", "l=2.5",
                               "height=0.05", "cellsHeight=40", "writeInterval=0.001", *arguments],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return next((self.folder / "slim_bed").iterdir())

    def test_one_series_over_a_restart(self):
        target = self.command("--until", "0.001", "-np", "2")
        self.assertEqual([t for t, _ in pieces(target / "gas.pvd")], [0.001])
        target = self.command("--until", "0.003", "--restart")

        series = pieces(target / "particles.pvd")
        np.testing.assert_allclose([t for t, _ in series], [0, 0.001, 0.002, 0.003], rtol=1e-9)
        for time, path in series:
            dump = paraview.read_dump(target / f"DEM/post/particles{round(time / 2.5e-6)}.txt")
            data, points = arrays(path, "PointData"), arrays(path, "Points")
            self.assertEqual(set(data), {"id", "U", "d", "T", "Nu"})
            self.assertEqual(int(ElementTree.parse(path).find(".//Piece").get("NumberOfPoints")), 3072)
            close = dict(rtol=1e-6, atol=1e-30)
            np.testing.assert_allclose(points["position"], np.array([dump[c] for c in "xyz"]).T, **close)
            np.testing.assert_allclose(data["U"], np.array([dump[c] for c in ("vx", "vy", "vz")]).T, **close)
            np.testing.assert_allclose(data["d"], 2 * dump["radius"], **close)
            np.testing.assert_allclose(data["T"], dump["f_Temp"], **close)
            np.testing.assert_allclose(data["Nu"], dump["f_Nusselt"], **close)
            np.testing.assert_array_equal(data["id"], dump["id"])
            np.testing.assert_array_equal(arrays(path, "Verts")["connectivity"], np.arange(3072))

        series = pieces(target / "gas.pvd")
        np.testing.assert_allclose([t for t, _ in series], [0.001, 0.002, 0.003], rtol=1e-9)
        for time, path in series:
            data = arrays(path, "CellData")
            for name in ("T", "U", "p", "voidage"):
                np.testing.assert_allclose(data[name], results.field(target / f"{time:g}" / name), rtol=1e-6, atol=1e-30)

        try:
            from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
        except ImportError:
            return  # ParaView's own reader is not installed here
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(target / "VTK/particles_1200.vtp"))
        reader.Update()
        cloud = reader.GetOutput()
        self.assertEqual((cloud.GetNumberOfPoints(), cloud.GetPointData().GetNumberOfArrays()), (3072, 5))
        self.assertAlmostEqual(cloud.GetPointData().GetArray("T").GetValue(7), dump["f_Temp"][7], delta=1e-4)

    def test_a_dump_that_is_being_written_waits(self):
        target = self.scene(l="2.5", height="0.05", cellsHeight="40", endTime="5e-5", writeInterval="2.5e-5")
        self.assertEqual(self.solve(target)[0], 0)
        dump = target / "DEM/post/particles20.txt"
        whole = dump.read_text()
        for part in (whole[:-2], whole[:5000], whole[:30], ""):
            dump.write_text(part)
            paraview.particles(target)
            self.assertEqual([p.name for _, p in pieces(target / "particles.pvd")],
                             ["particles_0.vtp", "particles_10.vtp"])
        dump.write_text(whole)
        paraview.particles(target)
        self.assertEqual(len(pieces(target / "particles.pvd")), 3)


if __name__ == "__main__":
    unittest.main(verbosity=2)
