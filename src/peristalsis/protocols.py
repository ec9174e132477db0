"""Inputs that change in time: steps, ramps and tables of a parameter, as one line of text.

    lumen.pressure: ramp 0.1 kPa at 0 s, 0.2 kPa at 2 s
    longitudinal.slow_calcium: step 0.004 mS/cm^2 at 0 s, 0.006 mS/cm^2 at 1 s
    lumen.pressure: table pressure.csv

A step holds each value from its time on, a ramp is linear between its times; both keep the first value before and the
last one after. A table is a ramp read from a CSV file whose header names the two columns with their units, such as
"time [s], value [kPa]".
"""

from __future__ import annotations

import bisect
import csv
import errno
import io
import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from . import units
from .disk import read_regular
from .errors import ConfigurationError, shown, suggestion
from .paths import located

SHAPES = ("step", "ramp", "table")
MOST_KNOTS = 1000
LARGEST_TABLE = 1_000_000

CHANGEABLE_SECTIONS = ("pacemaker", "trigger", "reflex")
CHANGEABLE_KEYS = (
    "pellet.viscous_friction",
    "pellet.dry_friction",
    "pellet.static_friction_factor",
    "pellet.friction_coefficient",
    "pellet.friction_frame",
    "lumen.pressure",
    "wall.viscosity",
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
"""What may change during a run: pressure, friction, muscle force, conductances and conduction, and the drivers."""


def changeable(key: str) -> bool:
    """Whether a parameter may change while a run is under way."""
    section = key.partition(".")[0]
    fixed = ("pacemaker.kind", "pacemaker.cell_rate", "pacemaker.cell_slow_calcium")
    return key in CHANGEABLE_KEYS or (section in CHANGEABLE_SECTIONS and key not in fixed)


@dataclass(frozen=True, slots=True)
class Protocol:
    """One parameter over time: values in its canonical unit at increasing times [s]; shape "step" or "ramp"."""

    parameter: str
    shape: str
    times: tuple[float, ...]
    values: tuple[float, ...]

    def at(self, time: float) -> float:
        """The value at a time [s]; steps take their new value from their time on."""
        k = bisect.bisect_right(self.times, time * (1.0 + 1e-12) + 1e-12) - 1
        if k < 0:
            return self.values[0]
        if self.shape == "step" or k == len(self.times) - 1:
            return self.values[k]
        share = (time - self.times[k]) / (self.times[k + 1] - self.times[k])
        return self.values[k] + min(max(share, 0.0), 1.0) * (self.values[k + 1] - self.values[k])

    def text(self, unit: str) -> str:
        """The protocol as a line of text that `parse` reads back identically."""
        knots = (
            f"{_number(value, unit)} at {units.format_quantity(time, 's')}"
            for time, value in zip(self.times, self.values, strict=True)
        )
        return f"{self.parameter}: {self.shape} {', '.join(knots)}"


def parse(text: object, numbers: dict[str, str]) -> Protocol:
    """A protocol from its line of text. numbers: every numeric parameter with its canonical unit.

    Raises ConfigurationError naming what is wrong and how to write it.
    """
    if not isinstance(text, str):
        raise ConfigurationError(f"protocols = {shown(text)}: give each as text; {_EXAMPLE}")
    key, colon, rest = text.partition(":")
    key = key.strip()
    shape, _, body = rest.strip().partition(" ")
    if not colon or not body.strip():
        raise ConfigurationError(f"protocols = {shown(text)}: not a parameter, a shape and its values; {_EXAMPLE}")
    if key not in numbers:
        raise ConfigurationError(f"protocols: {shown(key)} is not a numeric parameter; {suggestion(key, numbers)}")
    if not changeable(key):
        known = [name for name in numbers if changeable(name)]
        raise ConfigurationError(f"protocols: {key} cannot change during a run; {suggestion(key, known)}")
    if shape not in SHAPES:
        raise ConfigurationError(f"protocols: {shown(shape)} is not one of {', '.join(SHAPES)}; {_EXAMPLE}")
    if body.count(",") >= MOST_KNOTS:  # before each is read
        raise ConfigurationError(f"protocols: {key} has more than {MOST_KNOTS} values; thin them out")
    if shape == "table":
        knots = _read_table(located(body.strip()), key, numbers[key])
    else:
        knots = [_knot(part, key, numbers[key]) for part in body.split(",")]
    times, values = tuple(time for time, _ in knots), tuple(value for _, value in knots)
    if len(times) > MOST_KNOTS:
        raise ConfigurationError(f"protocols: {key} has {len(times)} values, more than {MOST_KNOTS}; thin them out")
    if any(later <= earlier for earlier, later in pairwise(times)) or times[0] < 0.0:
        raise ConfigurationError(f"protocols: the times of {key} do not increase from 0 s on; put them in order")
    return Protocol(key, "step" if shape == "step" else "ramp", times, values)


_EXAMPLE = "write for example 'lumen.pressure: ramp 0.1 kPa at 0 s, 0.2 kPa at 2 s'"


def _number(value: float, unit: str) -> str:
    return repr(value) if unit == units.DIMENSIONLESS else units.format_quantity(value, unit)


def _knot(part: str, key: str, unit: str) -> tuple[float, float]:
    value, at, time = part.rpartition(" at ")
    if not at:
        raise ConfigurationError(f"protocols: {shown(part.strip())} of {key} has no ' at '; {_EXAMPLE}")
    return units.parse(time.strip(), "s", f"protocols, time of {key}"), _value(value.strip(), unit, key)


def _value(text: str, unit: str, key: str) -> float:
    if unit == units.DIMENSIONLESS:
        try:
            return units.parse(float(text), unit, f"protocols, {key}")
        except ValueError:
            raise ConfigurationError(f"protocols: {shown(text)} is not a plain number for {key}; give one") from None
    return units.parse(text, unit, f"protocols, {key}")


def _read_table(path: Path, key: str, unit: str) -> list[tuple[float, float]]:
    try:
        text = read_regular(path, LARGEST_TABLE, follow=True).decode("utf-8-sig")
        rows = [row for row in csv.reader(io.StringIO(text, newline="")) if any(cell.strip() for cell in row)]
    except (OSError, ValueError, csv.Error) as error:
        if isinstance(error, OSError) and error.errno == errno.EFBIG:
            raise ConfigurationError(f"{shown(str(path))} is larger than {LARGEST_TABLE} bytes; thin it out") from None
        cause = error.strerror if isinstance(error, OSError) else str(error)
        raise ConfigurationError(f"{shown(str(path))} cannot be read: {cause}; check the file of {key}") from None
    if len(rows) < 2 or any(len(row) != 2 for row in rows):
        raise ConfigurationError(f"{shown(str(path))}: not a header and rows of two columns; {_HEADER}")
    given = [re.search(r"\[([^\]]+)\]", cell) for cell in rows[0]]
    names = [found.group(1) if found else units.DIMENSIONLESS for found in given]
    if given[0] is None or (given[1] is None and unit != units.DIMENSIONLESS):
        raise ConfigurationError(f"{shown(str(path))}: the header has no units; {_HEADER}")
    found: list[tuple[float, float]] = []
    for time, value in rows[1:]:
        text = value.strip() if unit == units.DIMENSIONLESS else f"{value.strip()} {names[1]}"
        seconds = units.parse(f"{time.strip()} {names[0]}", "s", f"{path.name}, time")
        found.append((seconds, _value(text, unit, key)))
    return found


_HEADER = "write a first line such as 'time [s],value [kPa]'"


def values_at(protocols: Iterable[Protocol], time: float) -> dict[str, float]:
    """Every protocol's value at a time [s], by parameter."""
    return {protocol.parameter: protocol.at(time) for protocol in protocols}
