#!/usr/bin/python3
"""Series for ParaView: paraview.py RUN.

particles.pvd  what the DEM script dumped as text, one snapshot a file (`dump ... custom N DEM/post/NAME*.txt id x y z ...`);
               NAME.pvd for each such dump
gas.pvd        the fields at the write times after the start
The pieces are in VTK/. `hotbed run` does this by itself.
"""

import base64
import json
import re
import sys
import warnings
from pathlib import Path

import numpy as np

NUMBER = r"-?\d+\.?\d*(?:[eE][+-]?\d+)?"  # as programs write them

# columns of the dump that make up a quantity -> its name and factor; any other column keeps its name
NAMES = {("vx", "vy", "vz"): ("U", 1), ("radius",): ("d", 2), ("diameter",): ("d", 1), ("f_Temp",): ("T", 1),
         ("f_Nusselt",): ("Nu", 1)}


def read_dump(path):
    """One LIGGGHTS text dump of numbers. @return column -> values, or None where the file is not a complete one"""
    text = Path(path).read_text(errors="replace")
    head = re.match(r"ITEM: TIMESTEP\n\d+\nITEM: NUMBER OF ATOMS\n(\d+)\nITEM: BOX[^\n]*\n(?:[^\n]*\n){3}"
                    r"ITEM: ATOMS ([^\n]*)\n", text)
    if not head or not text.endswith("\n"):
        return None
    columns = head[2].split()
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # as numpy tells of what is no number
        try:
            values = np.fromstring(text[head.end():], sep=" ").reshape(int(head[1]), len(columns))
        except (ValueError, DeprecationWarning):
            return None
    return dict(zip(columns, values.T))


def point_data(dump):
    """name -> values of the quantities in a dump, apart from the position."""
    data, left = {}, [c for c in dump if c not in "xyz"]
    for columns, (name, factor) in NAMES.items():
        if all(c in left for c in columns):
            values = factor * np.array([dump[c] for c in columns]).T
            data[name] = values if len(columns) > 1 else values[:, 0]
            left = [c for c in left if c not in columns]
    with np.errstate(invalid="ignore"):  # an id that is none
        data.update((c, dump[c].astype(np.int32) if c in ("id", "type") else dump[c]) for c in left)
    return data


def array(values, name):
    """A DataArray element: 32-bit numbers, base64 behind their length in bytes."""
    with np.errstate(over="ignore"):  # what a blow-up left is infinite
        values = np.ascontiguousarray(values, np.int32 if values.dtype.kind == "i" else np.float32)
    packed = base64.b64encode(np.uint64(values.nbytes).tobytes() + values.tobytes()).decode()
    return (f'<DataArray type="{"Int32" if values.dtype.kind == "i" else "Float32"}" Name="{name}" '
            f'NumberOfComponents="{values.shape[1] if values.ndim > 1 else 1}" format="binary">{packed}</DataArray>\n')


def write_vtp(path, points, data):
    """Points with data as VTK polygonal data, each point a vertex so that it shows."""
    n = len(points)
    text = (f'<VTKFile type="PolyData" version="1.0" byte_order="{"LittleEndian" if sys.byteorder == "little" else "BigEndian"}" '
            'header_type="UInt64">\n<PolyData>\n'
            f'<Piece NumberOfPoints="{n}" NumberOfVerts="1" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="0">\n'
            f'<Points>\n{array(points, "position")}</Points>\n'
            f'<PointData>\n{"".join(array(v, name) for name, v in data.items())}</PointData>\n'
            f'<Verts>\n{array(np.arange(n), "connectivity")}{array(np.array([n]), "offsets")}</Verts>\n'
            "</Piece>\n</PolyData>\n</VTKFile>\n")
    unfinished = Path(f"{path}.unfinished")
    unfinished.write_text(text)
    unfinished.rename(path)


def write_pvd(path, files):
    """The index of a series. @param files time [s] -> path from the folder of the index"""
    rows = "".join(f'<DataSet timestep="{time:.12g}" file="{file}"/>\n' for time, file in sorted(files.items()))
    Path(path).write_text('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n'
                          f"{rows}</Collection>\n</VTKFile>\n")


def dem_timestep(run):
    """DEM step [s], from the start of the solver's log; None before it is there."""
    log = Path(run) / "log.hotbedFoam"
    if not log.exists():
        return None
    with open(log, errors="replace") as file:
        step = re.search(rf"DEM step +({NUMBER}) s\n", file.read(20000))
    return float(step[1]) if step else None


def particles(run):
    """Brings the series of each particle dump up to date; a dump that is being written waits for the next call."""
    run, series, step = Path(run), {}, dem_timestep(run)
    for source in run.glob("DEM/post/*.txt"):
        named = re.fullmatch(r"(.*?)(\d+)", source.stem)
        if named and step:
            series.setdefault(named[1].rstrip("._-") or "particles", []).append((int(named[2]), source))
    for name, sources in series.items():
        files = {}
        for number, source in sources:
            target = run / "VTK" / f"{name}_{number}.vtp"
            if not target.exists() or target.stat().st_mtime < source.stat().st_mtime:
                dump = read_dump(source)
                if dump is None or not {"x", "y", "z"} <= set(dump):
                    continue
                target.parent.mkdir(exist_ok=True)
                write_vtp(target, np.array([dump[c] for c in "xyz"]).T, point_data(dump))
            files[number * step] = target.relative_to(run)
        if files:
            write_pvd(run / f"{name}.pvd", files)


def gas(run):
    """The index of the fields that foamToVTK left in VTK/gas."""
    run, files = Path(run), {}
    for series in run.glob("VTK/gas/*.vtm.series"):
        for piece in json.loads(series.read_text())["files"]:
            files[piece["time"]] = f"VTK/gas/{Path(piece['name']).stem}/internal.vtu"
    if files:
        write_pvd(run / "gas.pvd", files)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    from run import CaseError, for_paraview

    try:
        for_paraview(sys.argv[1])
    except CaseError as problem:
        sys.exit(f"paraview.py: {problem}")


if __name__ == "__main__":
    main()
