"""Inputs changed at random find what breaks: `./hotbed validate fuzz [--minutes M] [--quick] [--only KIND] [--input N] [--seed S]`,
ten minutes by default, --quick ten rounds, which take half a minute.

Kinds: arguments of the styles under `liggghts`; dictionaries, settings and restarts of hotbedFoam (both programs with
sanitizers); files that the Python side reads; numbers of `hotbed new`. A finding is an end by a signal, a report of a sanitizer, a run
that does not end, a Python error that is not a CaseError, a number out of its range (docs) that is taken or one in it that is refused,
a result that is not finite. Input N of a kind is the same at each run with the same seed.
"""

import argparse
import random
import shutil
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cfd_solver"))
import results
import sanitized
from fuzz_programs import Programs
from fuzz_python import Readers

ROUND = {"styles": 3, "dictionaries": 1, "settings": 1, "restarts": 1, "files": 15, "runs": 15, "new": 15}  # inputs of each kind in turn


def main():
    parser = argparse.ArgumentParser(prog="hotbed validate fuzz", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10, metavar="M", help="how long (default 10)")
    parser.add_argument("--quick", action="store_true", help="ten rounds")
    parser.add_argument("--only", choices=ROUND, help="one kind")
    parser.add_argument("--input", type=int, metavar="N", help="with --only: input N alone, shown and kept")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="of the random numbers (default 1)")
    options = parser.parse_args()
    build = sanitized.build()
    figures = results.Figures("fuzz")
    count, found = dict.fromkeys(ROUND, 0), dict.fromkeys(ROUND, 0)
    keep = Path("results/fuzz")
    with tempfile.TemporaryDirectory(prefix="hotbed-fuzz-") as folder:
        place, reports = Path(folder), Path(folder) / "reports"
        reports.mkdir()
        programs, readers = Programs(place, reports, build), Readers(place)
        kinds = {kind: getattr(programs if hasattr(programs, kind) else readers, kind) for kind in ROUND}

        def attempt(kind, number):
            scene = place / "scene"
            shutil.rmtree(scene, ignore_errors=True)
            scene.mkdir()
            given, wrong = kinds[kind](random.Random(f"{options.seed} {kind} {number}"), scene)
            count[kind] += 1
            if wrong or options.input is not None:
                found[kind] += bool(wrong)
                kept = keep / f"{kind}-{options.seed}-{number}"
                shutil.rmtree(kept, ignore_errors=True)
                shutil.copytree(scene, kept)
                print(f"{kind} {number}, kept in {kept}:\n    {given}\n    " + "\n    ".join(wrong), flush=True)

        if options.input is not None:
            attempt(options.only, options.input)
            return 1 if found[options.only] else 0
        end, rounds = time.time() + 60 * options.minutes, 0
        while rounds < 10 if options.quick else time.time() < end:
            rounds += 1
            for kind, number in ROUND.items():
                if options.only in (None, kind):
                    for _ in range(number):
                        attempt(kind, count[kind])
    for kind in ROUND:
        if count[kind]:
            figures.add(f"{kind}: inputs with a finding", found[kind], 0, f"of {count[kind]}")
    figures.note("inputs", sum(count.values()))
    return figures.close()


if __name__ == "__main__":
    sys.exit(main())
