"""Dependencies point one way: cfd_solver -> liggghts_fixes -> coupling; coupling/ knows neither code, liggghts_fixes/
not OpenFOAM, and only cfd_solver/ includes what is not its own and not below it."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BELOW = {"coupling": ["coupling"], "liggghts_fixes": ["liggghts_fixes", "coupling"]}
LIGGGHTS = {p.name for p in Path("/usr/include/liggghts").glob("*.h")}
FOREIGN = {"coupling": {"mpi.h", "gtest/gtest.h"}, "liggghts_fixes": LIGGGHTS | {"mpi.h", "dlfcn.h", "unistd.h", "gtest/gtest.h",
                                                               "immintrin.h"}}  # the compiler's, for inverse roots

wrong = []
for folder, below in BELOW.items():
    own = {p.name for f in below for p in (ROOT / f).rglob("*.h*")}
    for source in (ROOT / folder).rglob("*"):
        if source.suffix not in (".cpp", ".hpp", ".h"):
            continue
        for header in re.findall(r'#include\s+[<"]([^>"]+)[>"]', source.read_text()):
            standard = "." not in header
            if not standard and header not in own | FOREIGN[folder]:
                wrong.append(f"{source.relative_to(ROOT)} includes {header}")
        if folder == "coupling" and re.search(r"\b(LAMMPS_NS|Foam)::", source.read_text()):
            wrong.append(f"{source.relative_to(ROOT)} names a code that coupling/ must not know")
print("\n".join(wrong) or "dependencies point one way")
sys.exit(bool(wrong))
