"""The build with sanitizers that `validate sanitizers` and `validate fuzz` run, and what it reports."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import run as hotbed

ROOT = Path(__file__).resolve().parent.parent
SUPPRESSIONS = ROOT / "validation" / "sanitizers.supp"
OURS = re.compile(r"^(coupling|liggghts_fixes|cfd_solver)/|/planted\.cpp")
THEIRS = re.compile(r"libsanitizer|^/usr/include/|/openfoam/|/liggghts/")  # templates, and what the runtime puts in front


def build():
    """Configures and builds build-sanitize beside the build folder. @return the folder"""
    plain = Path(os.environ.get("HOTBED_BUILD", ROOT / "build")).resolve()
    folder = plain.parent / "build-sanitize"
    for command in (["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DHOTBED_SANITIZE=ON", f"-DOPENFOAM_HEADERS={plain}/openfoam"],
                    ["ninja", "-C", folder]):
        print(f"hotbed: {command[0]}, build with sanitizers in {folder}", file=sys.stderr, flush=True)
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode:
            sys.exit(f"hotbed: {command[0]} failed:\n{done.stdout[-4000:]}")
    return folder


def environment(reports, leaks=False):
    """What a process is to be started with, so that the sanitizers write their findings into the folder `reports`.

    The one for undefined behaviour aborts, which the other one reports: it can write to a file only what that one hands it.
    """
    common = f"log_path={reports}/report"
    return {"ASAN_OPTIONS": f"{common}:detect_leaks={int(leaks)}:suppressions={SUPPRESSIONS}:print_suppressions=0:handle_abort=2:"
                            "handle_segv=2:allocator_may_return_null=1",
            "UBSAN_OPTIONS": f"{common}:abort_on_error=1:print_stacktrace=1",
            "LSAN_OPTIONS": "exitcode=0:print_suppressions=0",  # what is not ours leaks in each process
            "OMPI_MCA_ess_singleton_isolated": "1"}  # Open MPI starts no daemon for a run on one rank


def preload():
    """What must be loaded first under a program that is not built with the sanitizers."""
    return subprocess.check_output(["g++", "-print-file-name=libasan.so"], text=True).strip()


def prepare(example, run, settings, ranks=1):
    """A prepared example whose gas leaves through inletOutlet: pressureInletOutletVelocity squares a field of vectors, for which
    Debian's libOpenFOAM reads eight bytes behind the last one. That is not ours and ends a run under AddressSanitizer."""
    case = run.parent / "case"
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(ROOT / "examples" / example, case)
    velocity = (case / "0/U").read_text()
    (case / "0/U").write_text(velocity.replace("pressureInletOutletVelocity;", "inletOutlet; inletValue uniform (0 0 0);"))
    hotbed.prepare(case, run, settings, ranks=ranks, overwrite=True)


def ours(stack):
    """Whether the innermost function of a stack that is no template of others is one of ours."""
    places = [m[1] for m in re.finditer(r"(?m)^ +#\d+ .* in .* \(?(\S+?)\)?$", stack)]
    inner = next((place for place in places if not THEIRS.search(place)), "")
    return bool(OURS.search(inner))


def reported(reports):
    """@return (findings: each its first line and stack, memory leaked where we asked for it: likewise, other leaks: number)"""
    findings, leaks, others = [], [], 0
    for path in sorted(Path(reports).iterdir()):
        text = path.read_text(errors="replace")
        blocks = re.findall(r"(?m)^(?:Direct|Indirect) leak of .*\n(?: +#.*\n)*", text)
        mine = [block for block in blocks if ours(block)]
        leaks += mine
        others += len(blocks) - len(mine)
        if "ERROR: AddressSanitizer" in text:
            findings.append("\n".join(re.findall(r"(?m)^.*ERROR: AddressSanitizer.*|^ +#.*", text)[:16]))
    return findings, leaks, others
