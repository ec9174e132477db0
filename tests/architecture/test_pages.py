"""What the pages say of the package's make-up: every module has its place, every exit code its meaning."""

import re
from pathlib import Path

import peristalsis
from peristalsis import errors

PACKAGE = Path(peristalsis.__file__).parent
DOCS = Path(__file__).parents[2] / "docs"
FOUND_BY_BEING_THERE = ("scenarios", "plots/figures", "sections")
"""Folders whose files are named by what they are, one a scenario, figure or section; the page names the folder."""

BESIDE = tuple(PACKAGE.parents[1] / name for name in ("verification", "benchmarks"))
"""Packages of the repository beside the package."""


def test_every_module_is_in_the_architecture() -> None:
    """In the row of its folder, or as `folder/module`."""
    page = (DOCS / "architecture.md").read_text(encoding="utf-8")
    missing = []
    files = [(file.relative_to(PACKAGE), False) for file in PACKAGE.rglob("*.py")]
    files += [(file.relative_to(home.parent), True) for home in BESIDE for file in home.rglob("*.py")]
    for place, beside in files:
        if place.stem.startswith("_") or place.parent.as_posix().endswith(FOUND_BY_BEING_THERE):
            continue
        row = f"| `{place.parts[0]}/`" if beside or len(place.parts) > 1 else "| top level |"
        rows = [line for line in page.splitlines() if line.startswith(row)]
        if not any(re.search(rf"[`/]{place.stem}`", line) for line in rows):
            missing.append(place.as_posix())
    assert not missing
    assert all(f"`{folder}" in page or f"`{folder.split('/')[-1]}/`" in page for folder in FOUND_BY_BEING_THERE)


def test_exit_codes_of_the_page_are_those_of_the_errors() -> None:
    """No code of an error is left out, none is made up, and each error's status word is explained."""
    page = (DOCS / "conventions.md").read_text(encoding="utf-8")
    table = re.search(r"^\| exit code of the command \|.*?\n\n", page, re.MULTILINE | re.DOTALL)
    assert table is not None
    said = {int(code) for code in re.findall(r"^\| (\d+) \|", table[0], re.MULTILINE)}
    classes = [errors.PeristalsisError]
    for one in classes:
        classes.extend(one.__subclasses__())
    assert said == {0} | {one.exit_code for one in classes}
    assert all(f"`{one.status}`" in page for one in classes)
