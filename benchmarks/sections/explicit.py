"""The paper's explicit scheme beside the default: quoted from the evidence, where it is made."""

from __future__ import annotations

import re
from pathlib import Path

from ..section import Bench, Figure, Findings, Section

EVIDENCE = Path(__file__).resolve().parents[2] / "docs" / "evidence" / "explicit.md"
HEADING = "At the error of the default"
LINK = (
    "Quoted from [docs/evidence/explicit.md](../evidence/explicit.md), where schemes, grids and errors are explained."
)


def run(bench: Bench) -> Findings:
    """The part of docs/evidence/explicit.md on equal errors, if this is a checkout that has it."""
    if not EVIDENCE.is_file():
        return Findings((), notes=("docs/evidence/explicit.md is not part of this installation.",))
    return quoted(EVIDENCE.read_text(encoding="utf-8"))


def quoted(page: str) -> Findings:
    """The part under HEADING as it stands, and the last column of its table as figures."""
    parts = re.split(r"^## +(.+)$", page, flags=re.MULTILINE)
    found = dict(zip(parts[1::2], parts[2::2], strict=True)).get(HEADING)
    if found is None:
        return Findings((), notes=(f"docs/evidence/explicit.md has no part named {HEADING!r}.",))
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in found.splitlines() if line[:1] == "|"]
    figures = [
        Figure(f"explicit scheme, mass {row[0]}, at the default's error", float(row[-1]), "times the default's time")
        for row in rows[2:]
    ]
    return Findings(tuple(figures), notes=(LINK, found.strip()))


SECTION = Section(
    name="explicit",
    title="The paper's explicit scheme",
    about="The scheme that the paper describes, explicit differences of second order, against the default.",
    run=run,
    place=30,
)
