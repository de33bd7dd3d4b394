"""Valgrind's memcheck on short coupled runs of the build as it is, for what sanitizers do not see: use of values that were never
set. `./hotbed validate valgrind [--quick]`: --quick one rank only.

A finding is ours where the innermost function of one of its stacks (where it happened, where the memory or the value came from) is
in hotbedFoam, libhotbed_liggghts.so or a test; the others are counted. Valgrind shows a processor without AVX-512, so the kernels
run in AVX2.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
import run as hotbed
from fault_scenes import SMALL

BUILD = Path(os.environ.get("HOTBED_BUILD", ROOT / "build"))
SETTINGS = {**SMALL, "endTime": "1e-4", "writeInterval": "1e-4"}
PLANTED = "#include <cstdlib>\nint main() { int* p = new int[2]; int odd = p[1] & 1; p = nullptr; return odd ? 2 : p != nullptr; }\n"
OURS = ("hotbedFoam", "libhotbed_liggghts.so", "coupling_test", "mapping_test", "planted")
RUNTIME = re.compile(r"vgpreload|/libc\.so|/libstdc\+\+|/ld-linux")


def memcheck(folder, name, command, ranks=1):
    """Runs a program under valgrind. @return (exit status, findings of ours as text, number of others)"""
    place = folder / f"{name}-%p.xml".replace(" ", "-").replace(",", "")
    watched = ["valgrind", "--xml=yes", f"--xml-file={place}", "--track-origins=yes", "--num-callers=30", *map(str, command)]
    with open(folder / "log", "w") as log:
        code = subprocess.call([*hotbed.mpirun(ranks), *watched] if ranks > 1 else watched, cwd=folder, stdout=log,
                               stderr=subprocess.STDOUT, env={**hotbed.environment(), "OMPI_MCA_ess_singleton_isolated": "1"})
    mine, others = [], 0
    for path in sorted(folder.glob(place.name.replace("%p", "*"))):
        for error in xml.parse(path).iter("error"):
            if error.findtext("kind") in ("Leak_StillReachable", "Leak_PossiblyLost"):
                continue
            stacks = [stack.findall("frame") for stack in error.findall("stack")]
            if any(Path(inner(frames)).name in OURS for frames in stacks):
                what = error.findtext("what") or error.findtext("xwhat/text")
                mine.append(f"{what}\n" + "\n".join(f"    {f.findtext('fn')} ({f.findtext('obj')})" for s in stacks for f in s))
            else:
                others += 1
    return code, mine, others


def inner(frames):
    """Program or library of the innermost function of a stack that is not the C or C++ library's."""
    objects = [frame.findtext("obj") or "unloaded" for frame in frames]
    return next((name for name in objects if not RUNTIME.search(name)), "")


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate valgrind", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one rank")
    options = parser.parse_args()
    if not shutil.which("valgrind"):
        sys.exit("hotbed: validate valgrind needs the Debian package valgrind: apt-get install valgrind")
    figures = results.Figures("valgrind")
    with tempfile.TemporaryDirectory(prefix="hotbed-valgrind-") as place:
        folder = Path(place)
        (folder / "planted.cpp").write_text(PLANTED)
        subprocess.check_call(["g++", "-O0", "-w", "-o", folder / "planted", folder / "planted.cpp"])
        figures.add("planted: findings, of 2", len(memcheck(folder, "planted", [folder / "planted"])[1]), 2, least=True)
        others = 0
        for ranks in (1,) if options.quick else (1, 2):
            suffix = ", 2 ranks" if ranks > 1 else ""
            run = folder / f"slim-bed-{ranks}"
            hotbed.prepare(ROOT / "examples/slim_bed", run, SETTINGS, ranks=ranks)
            solve = [BUILD / "cfd_solver/hotbedFoam", "-case", run, *(["-parallel"] if ranks > 1 else [])]
            scenes = {"weights": ([BUILD / "coupling/tests/mapping_test"], None), "slim bed": (solve, "1e-4"),
                      "slim bed, on from its restart": (solve, "2e-4")}
            for name, (command, end) in scenes.items():
                if end:
                    hotbed.change_settings(run / "settings", {"endTime": end})
                code, mine, more = memcheck(folder, f"{name} {ranks}", command, ranks)
                others += more
                for text in mine:
                    print(text)
                if code:
                    print(f"exit status {code}: {(folder / 'log').read_text(errors='replace')[-1000:]}")
                figures.add(f"{name}{suffix}: findings of ours, or failed", len(mine) + (code != 0), 0)
        figures.note("findings that begin in OpenFOAM, LIGGGHTS or Open MPI", others)
    return figures.close()


if __name__ == "__main__":
    sys.exit(main())
