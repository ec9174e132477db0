"""The words of headers and options: "time [s]", "P3 @ 30 mm", "0.1 mm", "0 = 5 mm, 255 = 20 mm"."""

from __future__ import annotations

import re

from .. import units
from ..errors import ConfigurationError, shown
from .recording import QUANTITIES

_LENGTH = re.compile(r"([+-]?\d+(?:\.\d*)?|[+-]?\.\d+)\s*(mm|cm|m)\b")
_BRACKETS = re.compile(r"\[([^\]]*)\]")

PRESSURES = ("mmHg", "kPa", "Pa", "cmH2O", "hPa", "mbar")
LENGTHS = ("mm", "cm", "m", "um")


def titled(cell: str) -> tuple[str, str | None]:
    """What a column is called, and its unit in brackets."""
    found = _BRACKETS.search(cell)
    unit = found.group(1).strip() if found else ""
    return _BRACKETS.sub("", cell).strip(), unit or None


def place_in(cell: str) -> float | None:
    """The place that a name of a channel states [mm], such as "P3 @ 3 cm"; None if it states none."""
    found = _LENGTH.search(_BRACKETS.sub("", cell))
    return None if found is None else float(found.group(1)) * {"mm": 1.0, "cm": 10.0, "m": 1000.0}[found.group(2)]


def quantity_of(title: str, unit: str | None) -> str | None:
    """The quantity that a title or a unit tells of; None if neither does."""
    lower = title.lower()
    named = next((name for name in QUANTITIES if name in lower), None)
    if named is None and unit in PRESSURES:
        return "pressure"
    return named


def length(text: object, key: str) -> float:
    """A length with its unit [mm]; numbers are mm. Raises ConfigurationError."""
    return _read(text, "mm", key)


def seconds(text: object, key: str) -> float:
    """A time with its unit [s]; numbers are s. Raises ConfigurationError."""
    return _read(text, "s", key)


def _read(text: object, unit: str, key: str) -> float:
    if isinstance(text, int | float) and not isinstance(text, bool):
        return float(text)
    return units.parse(text, unit, key)


def greys(text: str, unit: str) -> tuple[tuple[float, float], tuple[float, float]]:
    """Two grey values and what they mean, in `unit`, from a text such as "0 = 5 mm, 255 = 20 mm"."""
    parts = [part.partition("=") for part in text.split(",")]
    if len(parts) != 2 or not all(sign for _, sign, _ in parts):
        raise ConfigurationError(
            f"grey = {shown(text)}: not two grey values; write for example '0 = 5 mm, 255 = 20 mm'"
        )
    try:
        found = [(float(grey), units.parse(value.strip(), unit, "grey")) for grey, _, value in parts]
    except ValueError:
        raise ConfigurationError(f"grey = {shown(text)}: a grey value is a plain number, such as 0 or 255") from None
    if found[0][0] == found[1][0]:
        raise ConfigurationError(f"grey = {shown(text)}: both have the grey value {found[0][0]:g}; give two")
    return found[0], found[1]
