"""From measured numbers to verdicts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from .claim import Claim
from .rules import Finding, Measured

HOLDS, IN_PART, FAILS, UNTESTABLE = "holds", "holds in part", "does not hold", "not testable"
NOT_RUN = "not run"
"""No verdict yet: a missing run could still change it."""


@dataclass(frozen=True, slots=True)
class Scored:
    """One claim under one reading: its verdict, and what was found for each part."""

    claim: Claim
    verdict: str
    findings: tuple[Finding, ...]

    def failing(self) -> tuple[str, ...]:
        """The parts that fail or cannot be judged, by name."""
        marks = {False: "", None: " (not testable)"}
        return tuple(
            part.name + (" (not run)" if found.missing else marks[found.holds])
            for part, found in zip(self.claim.parts, self.findings, strict=True)
            if found.holds is not True
        )

    def numbers(self) -> str:
        """The grounds, part by part."""
        words = {True: "yes", False: "no", None: "not testable"}
        return " | ".join(
            f"{part.name}: {'not run' if found.missing else words[found.holds]} ({found.numbers})"
            for part, found in zip(self.claim.parts, self.findings, strict=True)
        )


def score(claim: Claim, measured: Measured) -> Scored:
    """The verdict of a claim: all parts, some, or none."""
    findings = tuple(part.rule.judge(measured) for part in claim.parts)
    held = [found.holds for found in findings]
    if all(one is True for one in held):
        verdict = HOLDS
    elif True in held and False in held:
        verdict = IN_PART
    elif any(found.missing for found in findings):
        verdict = NOT_RUN
    elif True in held:
        verdict = IN_PART
    elif any(one is False for one in held):
        verdict = FAILS
    else:
        verdict = UNTESTABLE
    return Scored(claim, verdict, findings)


def score_all(claims: Iterable[Claim], measured: Measured) -> tuple[Scored, ...]:
    """All claims, in their order."""
    return tuple(score(claim, measured) for claim in claims)
