"""Pure predicates on measured numbers. A claim is made of them, so that its verdict follows by itself."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

Measured = Mapping[str, Mapping[str, Any]]
"""Run or study -> metric -> number, text or None (undefined). `status` is always there."""

RESOLVED = 0.01
"""Smallest difference of times that counts [1]: the shipped grids leave 0.5 % on a transit, so two runs leave 1 %."""

UNUSABLE = ("refused", "diverged", "interrupted", "failed")
"""Ends of a run that say nothing about the pellet."""

UNITS = {"_mm_s": "mm/s", "_cm_s": "cm/s", "_cm": "cm", "_s": "s", "_kpa": "kPa", "_kPa": "kPa", "_mN": "mN"}
"""Ending of a metric's name to its unit, longer endings first; a name without one of them is of no unit."""


@dataclass(frozen=True, slots=True)
class Finding:
    """What a rule found: True, False, or None where it cannot be judged; `numbers` says on what grounds.

    missing: the rule was not judged because its run has not been made; else because it cannot be. margin: how far the
    number lies on the side that is asked for, as a share of the bound; negative on the other side, infinite where no
    number decides, and nan where nothing was judged. decisive: the grounds of the one rule among several that sets it.
    """

    holds: bool | None
    numbers: str
    missing: bool = False
    margin: float = math.nan
    decisive: str = ""


class Rule(Protocol):
    """A predicate on measured numbers."""

    def judge(self, measured: Measured) -> Finding:
        """Apply the rule."""

    def runs(self) -> tuple[str, ...]:
        """The runs and studies it reads."""


class _Unusable(Exception):
    """A run that is missing or says nothing; carries the finding."""

    def __init__(self, finding: Finding) -> None:
        self.finding = finding


def _of(measured: Measured, run: str) -> Mapping[str, Any]:
    if run not in measured:
        raise _Unusable(Finding(None, f"{run}: not run", missing=True))
    metrics = measured[run]
    if metrics["status"] in UNUSABLE:
        raise _Unusable(Finding(None, f"{run}: {metrics['status']} ({metrics.get('error') or 'no reason given'})"))
    return metrics


def shown(value: Any, metric: str = "") -> str:
    """A measured value with its unit."""
    if value is None:
        return "undefined"
    if isinstance(value, float | int) and not isinstance(value, bool):
        unit = next((unit for ending, unit in UNITS.items() if metric.endswith(ending)), "")
        return f"{value:.4g} {unit}".strip()
    return str(value)


def _certain(holds: bool) -> float:
    """The margin of what no number decides."""
    return math.inf if holds else -math.inf


def _ending(metrics: Mapping[str, Any]) -> str:
    if metrics.get("transit_s") is not None:
        return f"{metrics['transit_s']:.3f} s"
    return f"{metrics['status'].replace('_', ' ')} after {metrics['travel_cm']:.2f} cm"


@dataclass(frozen=True, slots=True)
class Within:
    """A metric lies in [low, high]; an undefined one does not."""

    run: str
    metric: str
    low: float = -math.inf
    high: float = math.inf

    def judge(self, measured: Measured) -> Finding:
        """Compare."""
        try:
            value = _of(measured, self.run).get(self.metric)
        except _Unusable as reason:
            return reason.finding
        bounds = {
            (True, True): f"{self.low:.4g} to {self.high:.4g}",
            (True, False): f"at least {self.low:.4g}",
            (False, True): f"at most {self.high:.4g}",
            (False, False): "any number",
        }[math.isfinite(self.low), math.isfinite(self.high)]
        holds = value is not None and self.low <= value <= self.high
        numbers = f"{self.run}: {self.metric} {shown(value, self.metric)} (asked: {bounds})"
        return Finding(holds, numbers, margin=-math.inf if value is None else self._margin(value))

    def _margin(self, value: float) -> float:
        size = max((abs(one) for one in (self.low, self.high) if math.isfinite(one)), default=0.0) or 1.0
        return min(value - self.low, self.high - value) / size

    def runs(self) -> tuple[str, ...]:
        """The one run."""
        return (self.run,)


@dataclass(frozen=True, slots=True)
class Ends:
    """A run ends in one of the given ways: expelled, arrested, in_transit."""

    run: str
    ways: tuple[str, ...]

    def judge(self, measured: Measured) -> Finding:
        """Compare."""
        try:
            metrics = _of(measured, self.run)
        except _Unusable as reason:
            return reason.finding
        holds = metrics["status"] in self.ways
        return Finding(holds, f"{self.run}: {_ending(metrics)}", margin=_certain(holds))

    def runs(self) -> tuple[str, ...]:
        """The one run."""
        return (self.run,)


@dataclass(frozen=True, slots=True)
class Later:
    """The pellet of `run` arrives later than that of `than` by more than a share `by`; never is later than any time.

    If neither arrives, the one that has gone less far by more than that share is the later one.
    """

    run: str
    than: str
    by: float = RESOLVED

    def judge(self, measured: Measured) -> Finding:
        """Compare."""
        try:
            ours, other = _of(measured, self.run), _of(measured, self.than)
        except _Unusable as reason:
            return reason.finding
        numbers = f"{self.run}: {_ending(ours)}; {self.than}: {_ending(other)}"
        mine, theirs = ours.get("transit_s"), other.get("transit_s")
        if mine is None and theirs is None:
            gone, reach = ours["travel_cm"], other["travel_cm"]
            margin = 1.0 - self.by - gone / reach if reach else -math.inf
            return Finding(gone < (1.0 - self.by) * reach, numbers, margin=margin)
        if mine is None or theirs is None:
            return Finding(mine is None, numbers, margin=_certain(mine is None))
        return Finding(mine > (1.0 + self.by) * theirs, numbers, margin=mine / theirs - 1.0 - self.by)

    def runs(self) -> tuple[str, ...]:
        """Both runs."""
        return (self.run, self.than)


@dataclass(frozen=True, slots=True)
class InTime:
    """The pellet of `run` arrives, and within (1 - below) to (1 + above) times the transit of `than`, which arrives."""

    run: str
    than: str
    above: float
    below: float = 1.0

    def judge(self, measured: Measured) -> Finding:
        """Compare."""
        try:
            ours, other = _of(measured, self.run), _of(measured, self.than)
        except _Unusable as reason:
            return reason.finding
        numbers = f"{self.run}: {_ending(ours)}; {self.than}: {_ending(other)}"
        mine, theirs = ours.get("transit_s"), other.get("transit_s")
        if mine is None or theirs is None:
            return Finding(False, numbers, margin=-math.inf)
        holds = (1.0 - self.below) * theirs <= mine <= (1.0 + self.above) * theirs
        share = mine / theirs - 1.0
        return Finding(holds, numbers, margin=min(share + self.below, self.above - share))

    def runs(self) -> tuple[str, ...]:
        """Both runs."""
        return (self.run, self.than)


@dataclass(frozen=True, slots=True)
class Exceeds:
    """A metric is at least `factor` times a metric of another run and more than `excess` above it."""

    run: str
    metric: str
    than: str
    factor: float = 1.0
    excess: float = 0.0
    other_metric: str | None = None

    def judge(self, measured: Measured) -> Finding:
        """Compare."""
        metric = self.other_metric or self.metric
        try:
            mine, theirs = _of(measured, self.run).get(self.metric), _of(measured, self.than).get(metric)
        except _Unusable as reason:
            return reason.finding
        numbers = f"{self.run}: {self.metric} {shown(mine, self.metric)}; {self.than}: {metric} {shown(theirs, metric)}"
        if mine is None or theirs is None:
            return Finding(False, numbers, margin=-math.inf)
        above = self.excess or (1.0 if isinstance(mine, int) else 0.0)  # of counts, the next one
        bound = max(self.factor * theirs, theirs + above)
        holds = mine >= self.factor * theirs and mine > theirs + self.excess
        return Finding(holds, numbers, margin=(mine - bound) / (abs(bound) or 1.0))

    def runs(self) -> tuple[str, ...]:
        """Both runs."""
        return (self.run, self.than)


@dataclass(frozen=True, slots=True)
class _Joined:
    """Several rules as one; one finding of `decides` settles it, and None of any rule leaves the rest open."""

    rules: tuple[Rule, ...]
    decides: ClassVar[bool]

    def judge(self, measured: Measured) -> Finding:
        """Apply all of them."""
        found = [rule.judge(measured) for rule in self.rules]
        holds: bool | None = not self.decides
        if any(one.holds is self.decides for one in found):
            holds = self.decides
        elif any(one.holds is None for one in found):
            holds = None
        texts = "; ".join(dict.fromkeys(one.numbers for one in found))
        judged = [one for one in found if not math.isnan(one.margin)]
        if holds is None or not judged:
            return Finding(holds, texts, holds is None and any(one.missing for one in found))
        sets = (max if self.decides else min)(judged, key=lambda one: one.margin)
        return Finding(holds, texts, margin=sets.margin, decisive=sets.decisive or sets.numbers)

    def runs(self) -> tuple[str, ...]:
        """All of them."""
        return tuple(dict.fromkeys(run for rule in self.rules for run in rule.runs()))


@dataclass(frozen=True, slots=True)
class AllOf(_Joined):
    """Every one of the rules holds."""

    decides = False


@dataclass(frozen=True, slots=True)
class AnyOf(_Joined):
    """At least one of the rules holds."""

    decides = True


@dataclass(frozen=True, slots=True)
class Not:
    """The rule does not hold."""

    rule: Rule

    def judge(self, measured: Measured) -> Finding:
        """Turn it around."""
        found = self.rule.judge(measured)
        holds = None if found.holds is None else not found.holds
        return Finding(holds, found.numbers, found.missing, -found.margin, found.decisive)

    def runs(self) -> tuple[str, ...]:
        """Those of the rule."""
        return self.rule.runs()
