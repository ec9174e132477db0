"""The paper's explicit scheme beside the default: quoted from the evidence, where it is made."""

from __future__ import annotations

import csv
from pathlib import Path

from ..section import Bench, Findings, Section, Table

EVIDENCE = Path(__file__).resolve().parents[4] / "docs" / "evidence"
STEM = "explicit"


def run(bench: Bench) -> Findings:
    """The table of docs/evidence/explicit.csv, if this is a checkout that has it."""
    file = EVIDENCE / f"{STEM}.csv"
    if not file.is_file():
        return Findings((), notes=(f"{file.name} is not in docs/evidence of this installation.",))
    with file.open(encoding="utf-8", newline="") as opened:
        head, *rows = csv.reader(opened)
    shown = tuple(tuple(_cell(cell) for cell in row) for row in rows)
    link = f"Quoted from [docs/evidence/{STEM}.md](../evidence/{STEM}.md), where schemes and errors are explained."
    return Findings((), (Table(link, tuple(head), shown),))


def _cell(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text


SECTION = Section(
    name="explicit",
    title="The paper's explicit scheme",
    about="The scheme that the paper describes, explicit differences of second order, against the default.",
    run=run,
    place=30,
)
