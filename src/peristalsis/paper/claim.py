"""What a claim of the paper is: a statement, its place, its parts with their rules, and what it served for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from .rules import Rule

Use = Literal["prediction", "calibrated", "chosen"]
"""What a claim is worth: a prediction, or one that served to calibrate the wave or to choose a reading or unit."""


@dataclass(frozen=True, slots=True)
class Part:
    """One thing that a claim says, and the rule that decides it."""

    name: str
    rule: Rule


@dataclass(frozen=True, slots=True)
class Claim:
    """One claim: its number, what the paper says in our words, where, and its parts."""

    number: int
    statement: str
    place: str
    parts: tuple[Part, ...]
    use: Use = "prediction"
    remark: str = ""

    def runs(self) -> tuple[str, ...]:
        """The runs and studies it needs."""
        return tuple(dict.fromkeys(run for part in self.parts for run in part.rule.runs()))
