"""The searches and the sensitivities that the claims need, as data: what is varied, over what, and what is asked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from .runs import DRY, ETA, PaperRun


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

    def run(self, value: float) -> PaperRun:
        """The run at one value."""
        name = f"{self.name}={value:.6g}"
        if self.key == "ratio":
            return PaperRun(name, ratio=value)
        return PaperRun(name, changes={self.key: f"{value!r} {self.unit}"})

    def holds(self, metrics: Mapping[str, object]) -> bool:
        """The predicate, on the metrics of a run that did not break off."""
        arrives = metrics["transit_s"] is not None
        if self.predicate == "arrives":
            return arrives
        if self.predicate == "does_not_arrive":
            return not arrives
        stops = metrics.get("stops")
        return not arrives or (isinstance(stops, int | float) and stops >= 1)


SEARCHES: Mapping[str, Search] = MappingProxyType(
    {
        search.name: search
        for search in (
            Search(
                "pressure_of_arrest",
                "lumen pressure from which the pellet does not arrive",
                "lumen.pressure",
                "kPa",
                (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 8.0, 10.0, 12.0, 15.0, 17.5, 20.0, 25.0),
                "does_not_arrive",
            ),
            Search(
                "ratio_of_arrest",
                "pellet over tube radius from which the pellet arrives",
                "ratio",
                "1",
                (0.9, 0.95, 1.0, 1.02, 1.04, 1.06, 1.08, 1.1, 1.13, 1.2),
                "arrives",
            ),
            Search(
                "dry_friction_of_arrest",
                "dry friction from which the pellet does not arrive",
                DRY,
                "mN",
                (20.0, 100.0, 200.0, 300.0, 450.0, 565.0, 700.0, 800.0, 1000.0, 1250.0, 1600.0, 2000.0),
                "does_not_arrive",
            ),
            Search(
                "dry_friction_of_stick_slip",
                "dry friction from which the pellet sticks on its way, or does not arrive",
                DRY,
                "mN",
                (20.0, 100.0, 200.0, 300.0, 450.0, 565.0, 700.0, 800.0, 1000.0, 1250.0, 1600.0, 2000.0),
                "sticks",
            ),
        )
    }
)


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """A full factorial over viscous and dry friction: shares of the variance of the mean velocity.

    The mean velocity is travel over transit, or over the whole run where the pellet does not arrive: defined always.
    """

    name: str
    title: str
    viscous: tuple[float, ...]
    dry: tuple[float, ...]

    def run(self, viscous: float, dry: float) -> PaperRun:
        """The run at one point."""
        name = f"{self.name}={viscous:.6g},{dry:.6g}"
        return PaperRun(name, changes={ETA: f"{viscous!r} mN*s/cm", DRY: f"{dry!r} mN"})


def _spaced(low: float, high: float, count: int = 5) -> tuple[float, ...]:
    return tuple(float(f"{low * (high / low) ** (k / (count - 1)):.6g}") for k in range(count))


SENSITIVITIES: Mapping[str, Sensitivity] = MappingProxyType(
    {
        one.name: one
        for one in (
            Sensitivity(
                "equal_percentages",
                "both frictions from half to double their normal value",
                _spaced(115.0, 460.0),
                _spaced(10.0, 40.0),
            ),
            Sensitivity(
                "paper_ranges",
                "the ranges of the paper's Fig. 3: viscous 90 to 1200, dry 2 to 800",
                _spaced(90.0, 1200.0),
                _spaced(2.0, 800.0),
            ),
        )
    }
)
