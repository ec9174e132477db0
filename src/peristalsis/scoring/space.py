"""What a search for a parameter set may move, as a file says it: constants with ranges, choices, the edge, the goal."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..many.studies import classes
from ..units import DIMENSIONLESS, format_quantity

DIGITS = 4
"""Significant digits of a drawn value: what is written in a table is what was run."""

BEYOND = "beyond"
"""The free constant that says how far above the edge a point lies, as a share of it."""

Values = Mapping[str, float | str]
"""Name of a free constant or choice to its value at one point."""


@dataclass(frozen=True, slots=True)
class Free:
    """One constant that moves in [low, high], evenly or by its logarithm; factor: on the reading's own numbers."""

    name: str
    low: float
    high: float
    reason: str
    keys: tuple[str, ...] = ()
    unit: str = DIMENSIONLESS
    scale: str = "linear"
    factor: bool = False

    def at(self, share: float) -> float:
        """The value at a share of the range in [0, 1]."""
        if self.scale == "log":
            value = self.low * (self.high / self.low) ** share
        else:
            value = self.low + share * (self.high - self.low)
        return min(max(_rounded(value), self.low), self.high)

    def share(self, value: float) -> float:
        """The share of the range at which a value lies."""
        if self.scale == "log":
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def stated(self, value: float) -> float | str:
        """A value as configurations take it."""
        return value if self.unit == DIMENSIONLESS else format_quantity(value, self.unit)


@dataclass(frozen=True, slots=True)
class Choice:
    """One choice among named values."""

    name: str
    key: str
    values: tuple[str, ...]
    reason: str

    def at(self, share: float) -> str:
        """The value at a share in [0, 1]."""
        return self.values[min(int(share * len(self.values)), len(self.values) - 1)]


@dataclass(frozen=True, slots=True)
class Edge:
    """Where the norm stops riding the wave along one factor on `keys`: key to the free constant that multiplies it."""

    run: str
    low: float
    high: float
    halvings: int
    rides_within: float
    keys: Mapping[str, str]
    reason: str

    def rides(self, metrics: Mapping[str, Any]) -> bool:
        """Whether the pellet of a run arrives with the wave, and not after it."""
        return classes.rides(metrics, self.rides_within)

    def regime(self, metrics: Mapping[str, Any]) -> str:
        """How a run moves its pellet, as `classes.motion` says; "" for a run that says nothing."""
        return classes.motion(metrics, self.rides_within)


@dataclass(frozen=True, slots=True)
class Objective:
    """What is asked of a point: claims that are counted, claims that are held out, and bounds on the norm's transit.

    screening: the runs by which points are sorted first. transit, target: in seconds.
    """

    claims: tuple[int, ...]
    held_out: tuple[int, ...]
    transit: tuple[float, float]
    target: float
    screening: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Space:
    """All of it, with the seed and the budget: drawn `samples`, of which so many are `screened`, `parents` refined.

    rounds: how often the best of all so far are refined; the spread of each round is `narrowing` times the last one's.
    """

    seed: int
    samples: int
    screened: int
    parents: int
    children: int
    spread: float
    rounds: int
    narrowing: float
    edge: Edge
    objective: Objective
    free: tuple[Free, ...]
    choices: tuple[Choice, ...]

    def drawn(self) -> tuple[Values, ...]:
        """The points of the scrambled Sobol' sequence; the same for the same seed."""
        size = len(self.free) + len(self.choices)
        return tuple(self._at(row) for row in sobol_shares(size, self.samples, self.seed))

    def around(self, parent: Values, place: int, round_: int = 0) -> tuple[Values, ...]:
        """Points around a parent: every free constant moved a little, choices kept. place: its rank, for the seed."""
        random = np.random.default_rng((self.seed, place, round_) if round_ else (self.seed, place))
        found = []
        for _ in range(self.children):
            steps = random.normal(scale=self.spread * self.narrowing**round_, size=len(self.free))
            moved = {
                one.name: one.at(min(max(one.share(float(parent[one.name])) + step, 0.0), 1.0))
                for one, step in zip(self.free, steps, strict=True)
            }
            found.append({**parent, **moved})
        return tuple(found)

    def changes(self, values: Values, force: float, base: Mapping[str, Any]) -> dict[str, Any]:
        """The changes of a parameter set at one point with one force. base: the reading's numbers, by dotted key."""
        changes: dict[str, Any] = {}
        for key, multiplied in self.edge.keys.items():
            changes[key] = _rounded(force * (float(values[multiplied]) if multiplied else 1.0), 6)
        for one in self.free:
            for key in one.keys:
                value = float(values[one.name]) * (float(base[key]) if one.factor else 1.0)
                changes[key] = one.stated(value)
        for choice in self.choices:
            changes[choice.key] = str(values[choice.name])
        return changes

    def beyond(self, values: Values, edge: float) -> float:
        """The force of a point whose edge is known."""
        return _rounded(edge * (1.0 + float(values[BEYOND])), 6)

    def _at(self, shares: Sequence[float]) -> Values:
        count = len(self.free)
        numbers = {one.name: one.at(float(share)) for one, share in zip(self.free, shares[:count], strict=True)}
        words = {one.name: one.at(float(share)) for one, share in zip(self.choices, shares[count:], strict=True)}
        return {**numbers, **words}


def sobol_shares(size: int, count: int, seed: int | tuple[int, ...]) -> NDArray[np.float64]:
    """The first points of a scrambled Sobol' sequence in [0, 1), (count, size); the same for the same seed."""
    from scipy.stats import qmc  # takes a second to import, and every report reads what may be drawn

    found: NDArray[np.float64] = qmc.Sobol(size, scramble=True, seed=np.random.default_rng(seed)).random(count)
    return found


def _rounded(value: float, digits: int = DIGITS) -> float:
    return float(f"{value:.{digits}g}")


def read_space(path: Path) -> Space:
    """The space of a file (TOML). Raises KeyError or TypeError for a file that is not one: they ship with a source."""
    with path.open("rb") as stream:
        stated = tomllib.load(stream)
    edge = stated.pop("edge")
    objective: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value for name, value in stated.pop("objective").items()
    }
    return Space(
        edge=Edge(**edge),
        objective=Objective(**objective),
        free=tuple(Free(**{**one, "keys": tuple(one.get("keys", ()))}) for one in stated.pop("free")),
        choices=tuple(Choice(**{**one, "values": tuple(one["values"])}) for one in stated.pop("choice")),
        **stated,
    )
