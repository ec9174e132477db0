"""Inputs that change in time: steps, ramps and tables of a parameter, as one line of text.

    lumen.pressure: ramp 0.1 kPa at 0 s, 0.2 kPa at 2 s
    longitudinal.slow_calcium: step 0.004 mS/cm^2 at 0 s, 0.006 mS/cm^2 at 1 s
    lumen.pressure: table pressure.csv
    *: table experiment.csv

A step holds each value from its time on, a ramp is linear between its times; both keep the first value before and the
last one after. A table is a ramp read from a CSV file whose header names the columns with their units, such as
"time [s],value [kPa]"; with * every column is a parameter, and named after it (`tables`).
"""

from __future__ import annotations

import bisect
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import cast

from .. import units
from ..errors import ConfigurationError, shown, suggestion
from ..paths import located
from . import tables
from .choices import is_channel

SHAPES = ("step", "ramp", "table")
MOST_WRITTEN = 4000
"""Values of all protocols together that are written out in a configuration, whose text has a limit."""

CHANGEABLE_SECTIONS = ("pacemaker", "trigger", "reflex", "rings")
FIXED_KEYS = (
    "pacemaker.kind",
    "pacemaker.cell_rate",
    "pacemaker.cell_slow_calcium",
    "rings.enabled",
    "rings.positions",
    "trigger.gate",
    "reflex.kind",
)
CHANGEABLE_KEYS = (
    "pellet.viscous_friction",
    "pellet.dry_friction",
    "pellet.static_friction_factor",
    "pellet.friction_coefficient",
    "pellet.friction_frame",
    "pellet.viscous_friction_coefficient",
    "pellet.fast_friction_share",
    "pellet.friction_fall_speed",
    "pellet.load_weight",
    "pellet.load_stiffness",
    "lumen.pressure",
    "wall.viscosity",
    "tissue.warming",
    *(
        f"{layer}.{name}"
        for layer in ("longitudinal", "circular")
        for name in (
            "active",
            "threshold",
            "slow_calcium",
            "fast_calcium",
            "calcium_potassium",
            "potassium",
            "leak",
            "conductivity_scale",
        )
    ),
)
"""What may change during a run: pressure, friction, load, temperature, muscle force, conductances and conduction, and
the drivers."""


def changeable(key: str) -> bool:
    """Whether a parameter may change while a run is under way."""
    section = key.partition(".")[0]
    return key in CHANGEABLE_KEYS or is_channel(key) or (section in CHANGEABLE_SECTIONS and key not in FIXED_KEYS)


@dataclass(frozen=True, slots=True)
class Protocol:
    """One parameter over time: values in its canonical unit at increasing times [s]; shape "step" or "ramp".

    file: name of the table that holds them, if they are too many for a line of text; they are arrays then.
    """

    parameter: str
    shape: str
    times: Sequence[float]
    values: Sequence[float]
    file: str = ""

    def at(self, time: float) -> float:
        """The value at a time [s]; steps take their new value from their time on."""
        k = bisect.bisect_right(self.times, time * (1.0 + 1e-12) + 1e-12) - 1
        if k < 0:
            return float(self.values[0])
        if self.shape == "step" or k == len(self.times) - 1:
            return float(self.values[k])
        share = (time - self.times[k]) / (self.times[k + 1] - self.times[k])
        return float(self.values[k] + min(max(share, 0.0), 1.0) * (self.values[k + 1] - self.values[k]))

    def extremes(self) -> tuple[float, float]:
        """The least and the largest value."""
        if self.file:
            import numpy as np

            return float(np.min(self.values)), float(np.max(self.values))
        return min(self.values), max(self.values)

    def text(self, unit: str) -> str:
        """The protocol as a line of text that `parse` reads back identically."""
        if self.file:
            return f"{self.parameter}: {'step' if self.shape == 'step' else 'table'} {self.file}"
        knots = (
            f"{_number(value, unit)} at {units.format_quantity(time, 's')}"
            for time, value in zip(self.times, self.values, strict=True)
        )
        return f"{self.parameter}: {self.shape} {', '.join(knots)}"


def parse(text: object, numbers: Mapping[str, str]) -> Protocol:
    """The protocol of a line of text that names its parameter: `parse_all` without "*"."""
    return parse_all(text, numbers)[0]


def parse_all(text: object, numbers: Mapping[str, str]) -> list[Protocol]:
    """The protocols of a line of text, more than one if it is a table of all. numbers: as in `tables.read`.

    Raises ConfigurationError naming what is wrong and how to write it.
    """
    if not isinstance(text, str):
        raise ConfigurationError(f"protocols = {shown(text)}: give each as text; {_EXAMPLE}")
    key, colon, rest = text.partition(":")
    key = key.strip()
    shape, _, body = rest.strip().partition(" ")
    if not colon or not body.strip():
        raise ConfigurationError(f"protocols = {shown(text)}: not a parameter, a shape and its values; {_EXAMPLE}")
    if key != "*" or shape != "table":
        _check_key(key, numbers)
    if shape not in SHAPES:
        raise ConfigurationError(f"protocols: {shown(shape)} is not one of {', '.join(SHAPES)}; {_EXAMPLE}")
    if shape == "table":
        courses = tables.read(located(body.strip()), key, numbers)
        for name in courses:
            _check_key(name, numbers)
        return [_of_course(name, "ramp", one) for name, one in courses.items()]
    if shape == "step" and tables.is_name(located(body.strip())):
        (one,) = tables.read(located(body.strip()), key, numbers).values()
        return [_of_course(key, "step", one)]
    if body.count(",") >= tables.MOST_KNOTS:  # before each is read
        raise ConfigurationError(
            f"protocols: {key} has more than {tables.MOST_KNOTS} values; thin them out, or give them as a table"
        )
    knots = [_knot(part, key, numbers[key]) for part in body.split(",")]
    times, values = tuple(time for time, _ in knots), tuple(value for _, value in knots)
    if any(later <= earlier for earlier, later in pairwise(times)) or times[0] < 0.0:
        raise ConfigurationError(f"protocols: the times of {key} do not increase from 0 s on; put them in order")
    return [Protocol(key, shape, times, values)]


def shortened(protocols: Sequence[Protocol]) -> list[Protocol]:
    """The same, the longest kept as tables where all their values would make the text of a configuration too long."""
    found = list(protocols)
    while sum(len(one.times) for one in found if not one.file) > MOST_WRITTEN:
        place = max((k for k, one in enumerate(found) if not one.file), key=lambda k: len(found[k].times))
        found[place] = _kept(found[place])
    return found


def _kept(protocol: Protocol) -> Protocol:
    import numpy as np

    one = tables.hold(np.array(protocol.times), np.array(protocol.values))
    return _of_course(protocol.parameter, protocol.shape, one)


def _of_course(key: str, shape: str, one: tables.Course) -> Protocol:
    return Protocol(key, shape, cast("Sequence[float]", one.times), cast("Sequence[float]", one.values), one.name)


def _check_key(key: str, numbers: Mapping[str, str]) -> None:
    if key not in numbers:
        raise ConfigurationError(f"protocols: {shown(key)} is not a numeric parameter; {suggestion(key, numbers)}")
    if not changeable(key):
        known = [name for name in numbers if changeable(name)]
        raise ConfigurationError(f"protocols: {key} cannot change during a run; {suggestion(key, known)}")


_EXAMPLE = "write for example 'lumen.pressure: ramp 0.1 kPa at 0 s, 0.2 kPa at 2 s'"


def _number(value: float, unit: str) -> str:
    return repr(value) if unit == units.DIMENSIONLESS else units.format_quantity(value, unit)


def _knot(part: str, key: str, unit: str) -> tuple[float, float]:
    value, at, time = part.rpartition(" at ")
    if not at:
        raise ConfigurationError(f"protocols: {shown(part.strip())} of {key} has no ' at '; {_EXAMPLE}")
    return units.parse(time.strip(), "s", f"protocols, time of {key}"), _value(value.strip(), unit, key)


def _value(text: str, unit: str, key: str) -> float:
    return tables.number(text, key) if unit == units.DIMENSIONLESS else units.parse(text, unit, f"protocols, {key}")


def values_at(protocols: Iterable[Protocol], time: float) -> dict[str, float]:
    """Every protocol's value at a time [s], by parameter."""
    return {protocol.parameter: protocol.at(time) for protocol in protocols}
