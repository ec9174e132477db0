"""What a claim is: a statement, its place in the source, its parts with their rules, and what it served for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from .rules import Rule

Use = Literal["prediction", "calibrated", "chosen", "plausibility"]
"""What a claim is worth: a prediction, one that served to calibrate or to choose a number, or a bound that any sound
model keeps."""


@dataclass(frozen=True, slots=True)
class Part:
    """One thing that a claim says, and the rule that decides it."""

    name: str
    rule: Rule


@dataclass(frozen=True, slots=True)
class Claim:
    """One claim: its number, what the source says in our words, where, and its parts."""

    number: int
    statement: str
    place: str
    parts: tuple[Part, ...]
    use: Use = "prediction"
    remark: str = ""

    def runs(self) -> tuple[str, ...]:
        """The runs and studies it needs."""
        return tuple(dict.fromkeys(run for part in self.parts for run in part.rule.runs()))


@dataclass(frozen=True, slots=True)
class Untestable:
    """A statement of the source that no rule can decide, where it stands, and why it cannot be tested."""

    statement: str
    place: str
    reason: str


@dataclass(frozen=True, slots=True)
class Explanation:
    """Why a claim does not hold under a parameter set; `command` shows it.

    nearest: the nearest condition in which the failing part was seen to hold. shown: the command for that.
    """

    claim: int
    reading: str
    reason: str
    command: str
    nearest: str = "none seen"
    shown: str = "–"
