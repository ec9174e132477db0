"""The shapes a region can have, as data. Where a shape lies is computed in `sampling`.

A shape is a class here, with a unit and bounds for each number, and one function there.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

RING = 360.0
"""Degrees around the tube."""


def measure(unit: str, default: float | None = None, **bounds: float) -> Any:
    """A number of a shape: its unit, and its bounds gt, ge and le."""
    about = {"unit": unit, "bounds": bounds}
    return field(metadata=about) if default is None else field(default=default, metadata=about)


def _place() -> Any:
    return measure("cm", ge=0.0, le=200.0)


def _angle(default: float | None = None) -> Any:
    return measure("deg", default, ge=-RING, le=RING)


@dataclass(frozen=True, slots=True)
class Band:
    """All around the ring, between two places along the tube [cm]."""

    NAME: ClassVar[str] = "band"
    z_from: float = _place()
    z_to: float = _place()

    def varies_around(self) -> bool:
        """Whether it differs around the ring."""
        return False

    def problem(self, length: float, radius: float) -> str | None:
        """Why it does not fit a tube of this length and radius [cm], and what to do; None if it does."""
        return _interval(self.z_from, self.z_to, length)


@dataclass(frozen=True, slots=True)
class Box:
    """Between two places along the tube [cm] and two angles [deg], from the first in rising order to the second."""

    NAME: ClassVar[str] = "box"
    z_from: float = _place()
    z_to: float = _place()
    angle_from: float = _angle()
    angle_to: float = _angle()

    @property
    def extent(self) -> float:
        """Angle that it spans [deg], in (0, 360]; 0 if both ends are the same."""
        span = self.angle_to - self.angle_from
        return min(span, RING) if span >= 0.0 else span % RING or RING

    def varies_around(self) -> bool:
        """Whether it differs around the ring."""
        return self.extent < RING

    def problem(self, length: float, radius: float) -> str | None:
        """Why it does not fit a tube of this length and radius [cm], and what to do; None if it does."""
        if self.extent == 0.0:
            return f"angle_from and angle_to are both {self.angle_from:g} deg; for the whole ring use 0 deg and 360 deg"
        return _interval(self.z_from, self.z_to, length)


@dataclass(frozen=True, slots=True)
class Disc:
    """Round about a point: all that is nearer to it than a radius [cm] along the undeformed surface."""

    NAME: ClassVar[str] = "disc"
    z: float = _place()
    angle: float = _angle()
    radius: float = measure("cm", gt=0.0, le=200.0)

    def varies_around(self) -> bool:
        """Whether it differs around the ring."""
        return True

    def problem(self, length: float, radius: float) -> str | None:
        """Why it does not fit a tube of this length and radius [cm], and what to do; None if it does."""
        return _inside("z", self.z, length)


@dataclass(frozen=True, slots=True)
class Stripes:
    """Bands along the whole tube, evenly spread around the ring, like taeniae: the first is centred at `phase`."""

    NAME: ClassVar[str] = "stripes"
    number: int = measure("", ge=1, le=1000)
    width: float = measure("cm", gt=0.0, le=200.0)
    phase: float = _angle(0.0)

    def varies_around(self) -> bool:
        """Whether it differs around the ring."""
        return True

    def problem(self, length: float, radius: float) -> str | None:
        """Why it does not fit a tube of this length and radius [cm], and what to do; None if it does."""
        ring = 2.0 * 3.141592653589793 * radius
        if self.number * self.width < ring:
            return None
        return (
            f"{self.number} stripes of {self.width:g} cm fill the ring of {ring:.4g} cm; use fewer or narrower ones, "
            "or the shape band"
        )


@dataclass(frozen=True, slots=True)
class Map:
    """Factors on a grid: rising places [cm], rising angles [deg], one row of values a place.

    Linear in between, constant beyond the first and the last place, periodic around the ring.
    """

    NAME: ClassVar[str] = "map"
    z: tuple[float, ...]
    angle: tuple[float, ...]
    values: tuple[tuple[float, ...], ...]

    def varies_around(self) -> bool:
        """Whether it differs around the ring."""
        return any(value != row[0] for row in self.values for value in row)

    def problem(self, length: float, radius: float) -> str | None:
        """Why it does not fit a tube of this length and radius [cm], and what to do; None if it does."""
        return _inside("z", self.z[-1], length)


Shape = Band | Box | Disc | Stripes | Map


def _inside(key: str, place: float, length: float) -> str | None:
    if place <= length:
        return None
    return f"{key} = {place:g} cm lies beyond the anal end; use at most wall.length = {length:g} cm"


def _interval(low: float, high: float, length: float) -> str | None:
    if low >= high:
        return f"z_from = {low:g} cm is not before z_to = {high:g} cm; exchange them"
    return _inside("z_to", high, length)
