"""From the thirteen equations of the paper to code, problems and tests: found by scanning, not by hand."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

import peristalsis

from .registry import problems
from .report import table

PACKAGE = Path(peristalsis.__file__).parent
NOT_CODE = ("paper",)
"""Folders of the package that cite equations without computing them for a run."""

HERE = Path(__file__).parent
BESIDE = ("exact/kernel.py",)
"""Files of this folder that compute equations of the paper which no run needs."""

_CITATION = re.compile(r"Eqs?\.\s+((?:\(\d+\)(?:\s*-\s*|,\s*(?:and\s+)?|\s+and\s+|\s+with\s+)?)+)")
_RANGE = re.compile(r"\((\d+)\)(?:\s*-\s*\((\d+)\))?")


@dataclass(frozen=True)
class Traced:
    """One equation of the paper: what it says, how it is read, tests by name, and why code is missing if it is."""

    number: int
    title: str
    reading: str
    tests: tuple[str, ...]
    awaited: str
    code: tuple[str, ...]
    problems: tuple[str, ...]


def cited(text: str) -> set[int]:
    """Numbers of the equations that a text cites, such as "Eqs. (20)-(22) and (31)"."""
    found: set[int] = set()
    for run in _CITATION.findall(text):
        for first, last in _RANGE.findall(run):
            found |= set(range(int(first), int(last or first) + 1))
    return found


@lru_cache(maxsize=1)
def citations() -> Mapping[int, tuple[str, ...]]:
    """Equation to the modules that cite it, as paths within the package (`verification/...` beside it)."""
    found: dict[int, list[str]] = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        place = file.relative_to(PACKAGE)
        if place.parts[0] in NOT_CODE:
            continue
        for number in cited(file.read_text(encoding="utf-8")):
            found.setdefault(number, []).append(place.as_posix())
    for name in BESIDE:
        for number in cited((HERE / name).read_text(encoding="utf-8")):
            found.setdefault(number, []).append(f"{HERE.name}/{name}")
    return MappingProxyType({number: tuple(places) for number, places in found.items()})


def traced() -> Iterator[Traced]:
    """The thirteen equations in order."""
    with Path(__file__).with_name("trace.toml").open("rb") as file:
        entries = tomllib.load(file)
    for key, entry in entries.items():
        number = int(key)
        yield Traced(
            number,
            entry["title"],
            entry["reading"],
            tuple(entry["tests"]),
            entry.get("awaited", ""),
            citations().get(number, ()),
            tuple(problem.id for problem in problems().values() if number in problem.equations),
        )


def missing() -> list[str]:
    """What the trace lacks, one sentence each; empty when every equation is accounted for."""
    found = []
    entries = {one.number: one for one in traced()}
    for number in range(1, 14):
        one = entries.get(number)
        if one is None:
            found.append(f"equation ({number}) is not in trace.toml; add it")
        elif not one.code and not one.awaited:
            found.append(f"equation ({number}), {one.title}: no code cites it; cite it where it is computed")
        elif one.code and one.awaited:
            found.append(f"equation ({number}) is cited by {one.code[0]}; drop `awaited` in trace.toml, name tests")
        elif one.code and not (one.tests and one.problems):
            found.append(f"equation ({number}), {one.title}: it has code but no test or no problem; name them")
    return found


def page() -> str:
    """The table as a page."""
    rows = (
        (
            f"({one.number})",
            one.title,
            ", ".join(f"`{place}`" for place in one.code) or f"none: {one.awaited}",
            ", ".join(one.problems) or "–",
            ", ".join(f"`{test.rpartition('/')[2]}`" for test in one.tests) or "–",
            one.reading,
        )
        for one in traced()
    )
    return (
        "# Equations, code, tests\n\n"
        'Made by `make verify`; do not edit. Code is found by its citations ("Eq. (4)"), problems by the '
        "equations that they name; tests and readings stand in `verification/trace.toml`. A test fails where an "
        "equation has no code or nothing that tests it. The equations themselves, printed and read: "
        "[equations](../equations.md).\n\n"
        + table(("equation", "what", "code", "problems", "tests", "how it is read"), rows)
    )
