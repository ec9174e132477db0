"""What is fitted: keys of a configuration, within bounds, in coordinates that are of order one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ... import units
from ...errors import ConfigurationError, shown, suggestion
from ...inputs.config import FIELDS, KEYS, Configuration

SPAN = 20.0
"""Bounds that are not stated are this many times the value at the start, and its part, within what the field allows."""
MOST = 12


@dataclass(frozen=True)
class Free:
    """A parameter to be found, the same under all of its keys.

    start, low, high: in the unit of the parameter. logarithmic: whether its coordinate is the logarithm, as for one
    that is above 0; otherwise it is the value over `scale`.
    """

    keys: tuple[str, ...]
    unit: str
    start: float
    low: float
    high: float
    logarithmic: bool
    scale: float

    @property
    def name(self) -> str:
        """As it was asked for."""
        return "+".join(self.keys)

    def coordinate(self, value: float) -> float:
        """The coordinate in which it is looked for."""
        return math.log(value) if self.logarithmic else value / self.scale

    def value(self, coordinate: float) -> float:
        """The value, in the unit of the parameter, never outside of the bounds by rounding."""
        if not self.coordinate(self.low) < coordinate < self.coordinate(self.high):
            return self.low if coordinate <= self.coordinate(self.low) else self.high
        found = math.exp(coordinate) if self.logarithmic else coordinate * self.scale
        return min(max(float(found), self.low), self.high)

    def changes(self, coordinate: float) -> dict[str, object]:
        """What it changes in a configuration."""
        text = units.written(self.value(coordinate), self.unit)
        return dict.fromkeys(self.keys, text)

    def text(self, value: float) -> str:
        """A value with its unit, for people."""
        return f"{value:.4g}" + ("" if self.unit == units.DIMENSIONLESS else f" {self.unit}")


def free_parameters(
    names: Sequence[str], configuration: Configuration, bounds: Mapping[str, tuple[object, object]] | None = None
) -> tuple[Free, ...]:
    """The parameters of names such as "pellet.dry_friction" or, tied, "longitudinal.leak+circular.leak".

    bounds: smallest and largest value by name. Raises ConfigurationError.
    """
    if not names or len(names) > MOST:
        raise ConfigurationError(f"free: {len(names)} parameters; name one to {MOST}")
    stated = dict(bounds or {})
    for name in stated:
        if name not in names:
            raise ConfigurationError(f"bounds: {shown(name)} is not free; {suggestion(name, names)}")
    found = tuple(_free(name, configuration, stated.get(name)) for name in names)
    keys = [key for one in found for key in one.keys]
    for key in keys:
        if keys.count(key) > 1:
            raise ConfigurationError(f"free: {key} is named twice; keep one")
    return found


def _free(name: str, configuration: Configuration, bounds: tuple[object, object] | None) -> Free:
    keys = tuple(part.strip() for part in name.split("+"))
    for key in keys:
        if key not in FIELDS or FIELDS[key].kind != "number":
            fix = suggestion(key, [one for one in KEYS if one in FIELDS and FIELDS[one].kind == "number"])
            raise ConfigurationError(f"free: {shown(key)} is no number of a configuration; {fix}")
    values, specs = configuration.flat(), [FIELDS[key] for key in keys]
    if len({values[key] for key in keys}) > 1 or len({spec.unit for spec in specs}) > 1:
        raise ConfigurationError(f"free: {name}: tied parameters begin with one value; set them to the same first")
    unit, start = specs[0].unit, values[keys[0]]
    assert isinstance(start, float)
    lowest = max(spec.bounds.get("ge", spec.bounds.get("gt", -math.inf)) for spec in specs)
    highest = min(spec.bounds.get("le", spec.bounds.get("lt", math.inf)) for spec in specs)
    if bounds is not None:
        low, high = (units.parse(one, unit, f"bounds of {name}") for one in bounds)
    elif any("gt" in spec.bounds for spec in specs) or (start > 0.0 and lowest > 0.0):
        low, high = start / SPAN, start * SPAN
    elif start != 0.0:
        low, high = max(lowest, 0.0 if start > 0.0 else -SPAN * abs(start)), SPAN * abs(start)
    else:
        raise ConfigurationError(f"free: {name} begins at 0, so its size is not known; state bounds for it")
    if not low < high:
        raise ConfigurationError(
            f"bounds of {name}: {low:g} to {high:g} {unit} do not rise; give the smaller one first"
        )
    low, high = max(low, lowest), min(high, highest)
    if not low < high or not low <= start <= high:
        raise ConfigurationError(
            f"free: {name} begins at {start:g} {unit}, and its bounds are {low:g} to {high:g} {unit}; set a start "
            "within"
        )
    scale = abs(start) if start != 0.0 else 0.1 * (high - low)
    return Free(keys, unit, start, low, high, low > 0.0, scale)
