"""Searches and sensitivities as records: what is varied, over what, and what is asked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .experiment import Experiment


@dataclass(frozen=True, slots=True)
class Search:
    """One threshold: scan all `values`, then bisect the last change from `below` to `above` to `tolerance`.

    key: the parameter, or "ratio" for the pellet's radius over the tube's. predicate: `arrives`, `does_not_arrive` or
    `sticks` (see `holds`). expected: whether the predicate is false below the threshold and true above it.
    """

    name: str
    title: str
    key: str
    unit: str
    values: tuple[float, ...]
    predicate: str
    tolerance: float = 0.02

    def run(self, value: float) -> Experiment:
        """The run at one value."""
        name = f"{self.name}={value:.6g}"
        if self.key == "ratio":
            return Experiment(name, ratio=value)
        return Experiment(name, changes={self.key: f"{value!r} {self.unit}"})

    def holds(self, metrics: Mapping[str, object]) -> bool:
        """The predicate, on the metrics of a run that did not break off."""
        arrives = metrics["transit_s"] is not None
        if self.predicate == "arrives":
            return arrives
        if self.predicate == "does_not_arrive":
            return not arrives
        stops = metrics.get("stops")
        return not arrives or (isinstance(stops, int | float) and stops >= 1)


@dataclass(frozen=True, slots=True)
class Axis:
    """One parameter of a factorial: the name of its metrics, its title in tables, key, unit and levels."""

    name: str
    title: str
    key: str
    unit: str
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """A full factorial over two parameters: shares of the variance of the mean velocity.

    The mean velocity is travel over transit, or over the whole run where the pellet does not arrive: defined always.
    """

    name: str
    title: str
    first: Axis
    second: Axis

    def run(self, first: float, second: float) -> Experiment:
        """The run at one point."""
        name = f"{self.name}={first:.6g},{second:.6g}"
        levels = ((self.first, first), (self.second, second))
        return Experiment(name, changes={axis.key: f"{value!r} {axis.unit}" for axis, value in levels})
