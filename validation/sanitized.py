"""The build with sanitizers that `validate sanitizers` and `validate fuzz` run, and what it reports."""

import os
import re
import subprocess
import sys
from pathlib import Path

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
    """What a process is to be started with, so that the sanitizers write their findings into the folder `reports`."""
    return {"ASAN_OPTIONS": f"detect_leaks={int(leaks)}:log_path={reports}/address:suppressions={SUPPRESSIONS}:"
                            "print_suppressions=0:allocator_may_return_null=1",
            "LSAN_OPTIONS": "exitcode=0:print_suppressions=0",  # what is not ours leaks in each process
            "UBSAN_OPTIONS": f"print_stacktrace=1:log_path={reports}/undefined",
            "OMPI_MCA_ess_singleton_isolated": "1"}  # Open MPI starts no daemon for a run on one rank


def preload():
    """What must be loaded first under a program that is not built with the sanitizers."""
    return subprocess.check_output(["g++", "-print-file-name=libasan.so"], text=True).strip()


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
        if re.search(r"runtime error:|ERROR: AddressSanitizer", text):
            findings.append("\n".join(re.findall(r"(?m)^.*(?:runtime error|ERROR: AddressSanitizer).*|^ +#.*", text)[:16]))
    return findings, leaks, others
