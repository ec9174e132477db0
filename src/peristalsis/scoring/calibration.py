"""A calibration that anyone can repeat: points drawn within prior ranges, claims that are asked, what they leave free.

The first round is drawn evenly over the prior ranges (Sobol', seeded). A point goes through runs in stages and is given
up as soon as a rule of the asked claims fails. Further rounds are drawn in the box of the best points. Where all asked
claims hold, those held out are looked at. The outcome is no single best point but the points that hold: a constant over
whose range they are spread is left free by what was measured. All follows from the file, the seed and kept runs.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigurationError
from ..inputs.parameters import Parameter
from .claim import Claim
from .outcome import Condition
from .rules import Measured
from .runs import Bench
from .score import score
from .source import ParameterSet
from .space import Free, Values, sobol_shares

SHIPPED = "shipped"
"""Name of the point that has the shipped numbers."""


@dataclass(frozen=True, slots=True)
class Aim:
    """The measured number that orders points for which as many rules hold."""

    run: str
    metric: str
    value: float


@dataclass(frozen=True, slots=True)
class Calibration:
    """All of it as data: budget, seed, claims asked and held out, stages, and what is free; see the file."""

    seed: int
    samples: int
    rounds: int
    refined: int
    kept: float
    margin: float
    claims: tuple[int, ...]
    held_out: tuple[int, ...]
    screening: tuple[tuple[str, ...], ...]
    aim: Aim
    free: tuple[Free, ...]

    def drawn(self, round_: int, low: Sequence[float], high: Sequence[float]) -> tuple[Values, ...]:
        """The points of a round within shares [low, high] of the prior ranges; the same for the same seed."""
        count = self.refined if round_ else self.samples
        drawn = sobol_shares(len(self.free), count, (self.seed, round_))
        shares = np.asarray(low) + (np.asarray(high) - np.asarray(low)) * drawn
        return tuple(
            {one.name: one.at(float(share)) for one, share in zip(self.free, row, strict=True)} for row in shares
        )

    def shares(self, values: Values) -> NDArray[np.float64]:
        """Where a point lies in the prior ranges, (n_free,): 0 at their lower ends, 1 at their upper ones."""
        return np.array([one.share(float(values[one.name])) for one in self.free])

    def changes(self, values: Values) -> dict[str, Any]:
        """The changes of a parameter set at a point."""
        return {key: one.stated(float(values[one.name])) for one in self.free for key in one.keys}


@dataclass(frozen=True)
class Candidate:
    """One point: its round, and what was measured; complete: whether no rule failed before all asked runs were made."""

    name: str
    values: Values
    round_: int
    measured: Measured = field(default_factory=dict)
    complete: bool = False


def read_calibration(path: Path, numbers: Mapping[str, Parameter]) -> Calibration:
    """The calibration of a file that ships with a source. numbers: where the prior ranges are, by dotted key."""
    with path.open("rb") as stream:
        stated = tomllib.load(stream)
    free = []
    for one in stated.pop("free"):
        about = numbers[one["keys"][0]]
        if about.low is None or about.high is None:
            raise ConfigurationError(f"{one['keys'][0]}: its parameter file gives no range; state one to calibrate it")
        scale = "log" if about.low > 0.0 else "linear"
        free.append(
            Free(one["name"], about.low, about.high, one["reason"], tuple(one["keys"]), about.unit or "1", scale)
        )
    screening = tuple(tuple(stage) for stage in stated.pop("screening"))
    claims, held_out = tuple(stated.pop("claims")), tuple(stated.pop("held_out"))
    aim = Aim(**stated.pop("aim"))
    return Calibration(claims=claims, held_out=held_out, screening=screening, aim=aim, free=tuple(free), **stated)


@dataclass(frozen=True)
class Search:
    """A calibration of one parameter set on one bench. say: told what is being done."""

    bench: Bench
    calibration: Calibration
    base: ParameterSet
    grids: Mapping[str, Any] = field(default_factory=dict)
    say: Callable[[str], None] = lambda words: None

    def carry_out(self) -> tuple[Candidate, ...]:
        """All points in the order in which they were drawn, the shipped one first."""
        plan = self.calibration
        found = list(self._measured([Candidate(SHIPPED, self.shipped(), 0)]))
        for round_ in range(plan.rounds + 1):
            low, high = self._box(found) if round_ else (np.zeros(len(plan.free)), np.ones(len(plan.free)))
            points = plan.drawn(round_, low.tolist(), high.tolist())
            self.say(f"round {round_}: {len(points)} points")
            names = [f"{'abcdefgh'[round_]}{place:03d}" for place in range(len(points))]
            found += self._measured([Candidate(n, values, round_) for n, values in zip(names, points, strict=True)])
        return tuple(found)

    def shipped(self) -> Values:
        """The point that has the shipped numbers."""
        numbers = (
            self.bench.source.runs[self.calibration.aim.run].configuration(self.base.reading, self.base.changes).flat()
        )
        return {one.name: float(str(numbers[one.keys[0]])) for one in self.calibration.free}

    def condition(self, candidate: Candidate) -> Condition:
        """Under what the experiments of a point are made."""
        changes = {**self.base.changes, **self.grids, **self.calibration.changes(candidate.values)}
        return Condition(self.base.reading, changes, candidate.name)

    def _box(self, found: Sequence[Candidate]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The box of the best points, widened by the margin, in shares of the prior ranges."""
        plan = self.calibration
        best = ranked(self.bench.source.claims, plan, [one for one in found if one.name != SHIPPED])
        shares = np.array([plan.shares(one.values) for one in best[: max(2, round(plan.kept * len(best)))]])
        wider = plan.margin * np.ptp(shares, axis=0)
        return np.maximum(shares.min(axis=0) - wider, 0.0), np.minimum(shares.max(axis=0) + wider, 1.0)

    def _measured(self, candidates: Sequence[Candidate]) -> list[Candidate]:
        """Points with what the stages give, each until a rule fails; then the claims held out where none did."""
        claims, plan = self.bench.source.claims, self.calibration
        rest, held_out = self.bench.source.runs_of(plan.claims), self.bench.source.runs_of(plan.held_out)
        found = {one.name: one for one in candidates}
        for stage in (*plan.screening, rest, held_out):
            going = [one for one in found.values() if not fails(claims, plan, one)]
            self.say(f"{len(going)} points: {', '.join(stage)}")
            runs = [self.bench.source.runs[name] for name in stage]
            rows = self.bench.records_under((self.condition(one), run) for one in going for run in runs)
            for one in going:
                more = {run.name: rows[one.name, run.name].summary for run in runs}
                found[one.name] = replace(one, measured={**one.measured, **more}, complete=stage is held_out)
        return list(found.values())


def _parts(claims: Sequence[Claim], plan: Calibration, candidate: Candidate) -> list[bool | None]:
    """What the rules of the asked claims say; None where runs are missing, False without a say."""
    asked = [score(claim, candidate.measured) for claim in claims if claim.number in plan.claims]
    return [None if found.missing else found.holds is True for one in asked for found in one.findings]


def fails(claims: Sequence[Claim], plan: Calibration, candidate: Candidate) -> bool:
    """Whether a rule of the asked claims has failed."""
    return False in _parts(claims, plan, candidate)


def holds(claims: Sequence[Claim], plan: Calibration, candidate: Candidate) -> bool:
    """Whether all rules of the asked claims hold."""
    return all(one is True for one in _parts(claims, plan, candidate))


def ranked(claims: Sequence[Claim], plan: Calibration, candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best first: by the rules that hold, then by the distance of the aim on a log scale, then by name."""

    def order(one: Candidate) -> tuple[int, float, str]:
        held = sum(found is True for found in _parts(claims, plan, one))
        value = one.measured.get(plan.aim.run, {}).get(plan.aim.metric) or 0.0
        away = abs(float(np.log(value / plan.aim.value))) if value > 0.0 else np.inf
        return -held, away, one.name

    return sorted(candidates, key=order)


def good_points(claims: Sequence[Claim], plan: Calibration, candidates: Sequence[Candidate]) -> list[Candidate]:
    """The drawn points at which all asked claims hold, the best first; the shipped one is not among them."""
    return [one for one in ranked(claims, plan, candidates) if one.name != SHIPPED and holds(claims, plan, one)]
