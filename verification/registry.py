"""Finds the problems: every module of this package that defines PROBLEMS; a new family is a new file."""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from types import MappingProxyType

import verification as home
from peristalsis.errors import ConfigurationError, shown, suggestion

from .problem import Problem

FAMILIES = ("E", "B", "M", "C", "F", "X")
TITLES = {
    "E": "Cable and cell",
    "B": "Bidomain",
    "M": "Membrane shell",
    "C": "Contact",
    "F": "Friction",
    "X": "Coupled model",
}
"""First letters of the ids, in the order of the tables, and what they stand for."""


@lru_cache(maxsize=1)
def problems() -> Mapping[str, Problem]:
    """Every problem by id, in the order of the families."""
    found: dict[str, Problem] = {}
    for module in pkgutil.iter_modules(home.__path__):
        if module.ispkg:
            continue
        for problem in getattr(importlib.import_module(f"{home.__name__}.{module.name}"), "PROBLEMS", ()):
            if problem.id in found:
                raise ValueError(f"{problem.id} is defined twice; give {problem.title!r} an id of its own")
            found[problem.id] = problem
    return MappingProxyType({key: found[key] for key in sorted(found, key=_place)})


def chosen(ids: Iterable[str] = (), full: bool = False) -> tuple[Problem, ...]:
    """The problems with these ids, or those of the quick tier, or of both; ConfigurationError for an unknown id."""
    known = problems()
    named = tuple(ids)
    for name in named:
        if name not in known:
            raise ConfigurationError(f"problem = {shown(name)}: no such problem; {suggestion(name, known)}")
    if named:
        return tuple(known[name] for name in dict.fromkeys(named))
    return tuple(problem for problem in known.values() if full or problem.tier == "quick")


def _place(name: str) -> tuple[int, int, str]:
    letter, number, rest = re.fullmatch(r"([A-Z])(\d+)(\w*)", name).groups()  # type: ignore[union-attr]
    return FAMILIES.index(letter), int(number), rest
