"""The searches and the sensitivities that the paper's claims need."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..searches import Axis, Search, Sensitivity
from .runs import DRY, ETA

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


def _frictions(name: str, title: str, viscous: tuple[float, ...], dry: tuple[float, ...]) -> Sensitivity:
    return Sensitivity(
        name,
        title,
        Axis("viscous", "viscous friction", ETA, "mN*s/cm", viscous),
        Axis("dry", "dry friction", DRY, "mN", dry),
    )


def _spaced(low: float, high: float, count: int = 5) -> tuple[float, ...]:
    return tuple(float(f"{low * (high / low) ** (k / (count - 1)):.6g}") for k in range(count))


SENSITIVITIES: Mapping[str, Sensitivity] = MappingProxyType(
    {
        one.name: one
        for one in (
            _frictions(
                "equal_percentages",
                "both frictions from half to double their normal value",
                _spaced(115.0, 460.0),
                _spaced(10.0, 40.0),
            ),
            _frictions(
                "paper_ranges",
                "the ranges of the paper's Fig. 3: viscous 90 to 1200, dry 2 to 800",
                _spaced(90.0, 1200.0),
                _spaced(2.0, 800.0),
            ),
        )
    }
)
