"""The pages: every link leads to a file and a heading that are there, every page of docs is in the README's list, and the pages
of styles have their headings in LIGGGHTS' order."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted(ROOT.glob("docs/*.md")), *sorted(ROOT.glob("examples/*/README.md"))]
STYLE = ["Syntax", "Examples", "Description", "Restrictions", "Related", "Default"]


def prose(page):
    """A page without its blocks of code and its words in code."""
    return re.sub(r"`[^`\n]*`", "", re.sub(r"(?ms)^```.*?^```", "", page.read_text()))


def anchors(page):
    """Names that a browser jumps to, made of the headings as GitHub does."""
    text = re.sub(r"(?ms)^```.*?^```", "", page.read_text())
    found = []
    for heading in re.findall(r"(?m)^#+ +(.*?) *$", text):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        name = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        found.append(f"{name}-{found.count(name)}" if name in found else name)
    return found


wrong = []
for page in PAGES:
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if re.match(r"https?://", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        if not file.exists():
            wrong.append(f"{page.relative_to(ROOT)}: {target} is not there")
        elif anchor and anchor not in anchors(file):
            wrong.append(f"{page.relative_to(ROOT)}: {target} has no heading '{anchor}'")
listed = set(re.findall(r"\]\((docs/[^)#]+)", (ROOT / "README.md").read_text()))
wrong += [f"README.md does not name {page.relative_to(ROOT)}" for page in ROOT.glob("docs/*.md") if str(page.relative_to(ROOT)) not in listed]
for page in [*ROOT.glob("docs/fix_*.md"), *ROOT.glob("docs/pair_*.md")]:
    headings = re.findall(r"(?m)^## (.*)$", page.read_text())
    if headings != STYLE:
        wrong.append(f"{page.relative_to(ROOT)}: headings are {', '.join(headings)}, not {', '.join(STYLE)}")
print("\n".join(wrong) or f"{len(PAGES)} pages, all links lead somewhere")
sys.exit(bool(wrong))
