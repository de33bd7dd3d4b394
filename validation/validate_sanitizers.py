"""Address and undefined-behaviour sanitizers look at every memory access and operation of our code: in the unit tests, in the
styles under the unmodified `liggghts`, and in coupled runs. `./hotbed validate sanitizers [--quick]`: --quick leaves out all tests
of the styles but one.

OpenFOAM, LIGGGHTS and Open MPI are the stock ones, in which only calls such as memcpy and malloc are looked at; findings of theirs
that are passed over stand in sanitizers.supp. Memory that is lost counts where a function of ours asked for it.
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
import sanitized
from fault_scenes import SMALL

# what must be found, so that nothing found means something
PLANTED = {"use after free": "int* p = new int[2]; delete[] p; return p[0];",
           "shift too far": "return argc << (argc + 40);",
           "memory lost": "volatile int* p = new int[argc]; p = nullptr; return p != nullptr;"}
SHORT = {**SMALL, "endTime": "0.0003", "writeInterval": "0.0001"}
# name: (example, settings, ranks)
RUNS = {"slim bed": ("slim_bed", SHORT, 1),
        "slim bed, 2 ranks": ("slim_bed", SHORT, 2),
        "slim bed, plain exchange, cells read at their centres": ("slim_bed", {**SHORT, "exchange": "implicit", "temperatureGradient": "off"}, 1),
        "cylinder bed, 2 ranks": ("cylinder_bed", {"l": "2.5", "endTime": "0.0002", "writeInterval": "0.0002"}, 2),
        "fixed bed, 2 ranks": ("fixed_bed", {"l": "2.5", "height": "0.03", "cellsHeight": "20", "endTime": "0.02", "writeInterval": "0.02"}, 2)}


def planted(folder):
    """Compiles and runs programs with a known fault. @return number of reports of each kind that reported() finds"""
    found = [0, 0]
    for name, code in PLANTED.items():
        (folder / "planted.cpp").write_text(f"int main(int argc, char**) {{ {code} }}\n")
        subprocess.check_call(["g++", "-g1", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined", "-w", "-o",
                               folder / "planted", folder / "planted.cpp"])
        reports = fresh(folder / "reports")
        subprocess.run([folder / "planted"], env={**os.environ, **sanitized.environment(reports, leaks=True)}, capture_output=True)
        findings, leaks, _ = sanitized.reported(reports)
        print(f"planted, {name}: {len(findings)} findings, {len(leaks)} leaks")
        found[0] += len(findings)
        found[1] += len(leaks)
    return found


def fresh(folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def tests(build, pattern, environment):
    """Runs tests of the build by ctest. @return (number, names of those that failed)"""
    junit = build / "sanitizers.xml"
    subprocess.run(["ctest", "--test-dir", build, "-R", pattern, "--output-junit", junit], env={**os.environ, **environment},
                   stdout=subprocess.DEVNULL)
    cases = xml.parse(junit).findall("testcase")
    return len(cases), [case.get("name") for case in cases if case.get("status") != "run"]


def coupled(folder, name, example, settings, ranks):
    """Runs a case and goes on with it from its restart. @return what is wrong"""
    run = folder / "run"
    sanitized.prepare(example, run, settings, ranks)
    wrong = []
    for further in (1, 1.5):
        hotbed.change_settings(run / "settings", {"endTime": f"{further * float(settings['endTime']):g}"})
        code = hotbed.start(run, ranks).wait(timeout=600)
        log = (run / "log.hotbedFoam").read_text(errors="replace")
        times = len(re.findall(r"(?m)^Time = ", log))
        if code != 0 or times == 0:
            wrong.append(f"exit status {code} after {times} steps: {log[-500:]}")
    return wrong


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate sanitizers", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer tests of the styles")
    options = parser.parse_args()
    build = sanitized.build()
    figures = results.Figures("sanitizers")
    with tempfile.TemporaryDirectory(prefix="hotbed-sanitizers-") as place:
        folder = Path(place)
        found = planted(folder)
        figures.add("planted: findings, of 2", found[0], 2, least=True)
        figures.add("planted: leaks, of 1", found[1], 1, least=True)

        reports = fresh(folder / "reports")
        for name, pattern in (("unit tests of coupling", r"^coupling\."),
                              ("styles under liggghts", r"^liggghts_fixes\." + ("(plugin|Contact)" if options.quick else ""))):
            number, failed = tests(build, pattern, sanitized.environment(reports))
            figures.add(f"{name}: failed, of {number} tests", len(failed) + (number == 0), 0, " ".join(failed))
        os.environ.update(sanitized.environment(reports, leaks=True))
        hotbed.SOLVER = build / "cfd_solver" / "hotbedFoam"
        for name, scene in RUNS.items():
            wrong = coupled(folder, name, *scene)
            figures.add(f"{name}, and on from its restart: failed", len(wrong), 0, "; ".join(wrong))
        findings, leaks, others = sanitized.reported(reports)
        for text in findings + leaks:
            print(text)
        figures.add("findings", len(findings), 0)
        figures.add("memory lost that our functions asked for", len(leaks), 0)
        figures.note("memory lost by OpenFOAM, LIGGGHTS and Open MPI, blocks in all processes", others)
    return figures.close()


if __name__ == "__main__":
    sys.exit(main())
