"""The edge: text with a unit in, plain floats inside, text with a unit out.

A quantity is written as a number, a space and a unit: ``"0.9 cm"``.  The configuration stores the number in
the canonical unit of its parameter.  The physics uses one system, mN, cm, s and mV, so a mass per area is in
mN s^2/cm^3 and a pressure in mN/cm^2; `to_internal` goes from the one to the other by a table of factors.

A unit that is spelled like the canonical one is read without any conversion, so that a number written by
`format_quantity` comes back bit for bit.  Only a foreign unit loads pint.
"""

from __future__ import annotations

import math
import re
from fractions import Fraction
from functools import lru_cache
from numbers import Real
from typing import Any

from peristalsis.errors import ConfigurationError, nearest, shown

DIMENSIONLESS = "1"

# Canonical unit -> factor to the system mN, cm, s, mV.  Electrical densities stay in the units of the cell
# model (uA/cm^2, mS/cm^2, uF/cm^2), which agree with one another when the time is in ms.
_INTERNAL = {
    DIMENSIONLESS: 1.0,
    "cm": 1.0,
    "cm^2/s": 1.0,
    "s/cm": 1.0,
    "cm/s": 1.0,
    "s": 1.0,
    "deg": math.pi / 180.0,
    "K": 1.0,
    "ms": 1e-3,
    "1/ms": 1e3,
    "mV": 1.0,
    "1/mV": 1.0,
    "mN": 1.0,
    "mN/cm": 1.0,
    "mN*cm": 1.0,
    "mN*s/cm": 1.0,
    "mN*s*cm": 1.0,
    "mN/cm^3": 1.0,
    "mN/(cm*mV)": 1.0,
    "kPa": 100.0,
    "mg/cm^2": 1e-5,
    "mS/cm": 1.0,
    "mS/cm^2": 1.0,
    "uA/cm^2": 1.0,
    "uF/cm^2": 1.0,
}
CANONICAL_UNITS = tuple(_INTERNAL)

# Offered when a unit is misspelled ("kpa").
_FAMILIAR = (
    *CANONICAL_UNITS[1:],
    *("mm", "m", "um", "rad", "N", "uN", "N/m", "N*s/m", "mN*s/m", "Pa", "mbar", "mmHg", "cmH2O", "g/cm^2"),
    *("kg/m^2", "V", "mS/m", "S/m", "min", "us", "1/s", "percent"),
)

_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
# One small exponent per name: a tower of powers would keep the conversion busy for ever.
_UNIT = re.compile(r"(?:1(?![0-9])|[A-Za-z%_]+(?:2O)?(?:\^-?[1-4](?![0-9]))?|[*/()])+")
_SPELLING = str.maketrans(
    {"µ": "u", "μ": "u", "·": "*", "⋅": "*", "×": "*", "∕": "/", "°": "deg", "−": "-"}
    | {chr(0x2080 + digit): str(digit) for digit in range(10)}
)
_RAISED = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")
_RAISED_TEXT = re.compile("[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_POWER_OF_TEN = re.compile(r"\s*\*\s*10\^?([+-]?[0-9]{1,3})(?![0-9.])")
_LONGEST_TEXT = 80
_LONGEST_PLAIN = 30


class QuantityError(ValueError):
    """Why a value is not a quantity in the wanted unit; `parse` puts the key and the value in front of it."""


def parse(value: object, unit: str, key: str) -> float:
    """The number of `value` in `unit`; a ConfigurationError that names `key` when it has none.

    Text must carry a unit unless the parameter is dimensionless (unit "1"); a bare number is accepted for
    dimensionless parameters only.
    """
    try:
        return read(value, unit)
    except QuantityError as error:
        raise ConfigurationError(f"{key} = {shown(value)}: {error}") from None


def read(value: object, unit: str) -> float:
    """As `parse`, with a QuantityError that holds cause and fix only."""
    value = plain(value)
    if isinstance(value, str):
        return _read_text(value, unit)
    if isinstance(value, bool) or not isinstance(value, Real):
        raise QuantityError(f"a {type(value).__name__} is not a quantity; {_write(unit)}")
    if unit != DIMENSIONLESS:
        raise QuantityError(f"the unit is missing; {_write(unit)}")
    try:
        number = float(value)
    except (OverflowError, ValueError):
        raise QuantityError(f"the number is too large; {_write(unit)}") from None
    return _finite(number, unit)


def plain(value: Any) -> Any:
    """The same as text, number, switch or list, where it is a scalar or array of numpy or a quantity of pint.

    Such values are known by what they can do: neither library is loaded for it.
    """
    if hasattr(value, "magnitude") and hasattr(value, "units"):
        number, unit = plain(value.magnitude), str(value.units)
        unit = "" if unit == "dimensionless" else unit
        return [_joined(item, unit) for item in number] if isinstance(number, list) else _joined(number, unit)
    to_list = getattr(value, "tolist", None)
    if callable(to_list) and hasattr(value, "dtype"):
        return plain(to_list())
    if isinstance(value, list | tuple):
        return type(value)(map(plain, value)) if type(value) in (list, tuple) else value
    return value


def _joined(number: Any, unit: str) -> Any:
    return f"{float(number)!r} {unit}" if unit and isinstance(number, Real) else number


def factor(given: str, unit: str) -> Fraction:
    """The exact factor from one unit to a canonical one. Raises QuantityError if there is none."""
    spelt = _spelling(given)
    return Fraction(1) if spelt == _spelling(unit) else _factor(spelt, unit)


def is_known(unit: str) -> bool:
    """Whether a text is a unit that anything can be converted to."""
    if not _UNIT.fullmatch(_spelling(unit)):
        return False
    try:
        _registry().parse_units(_spelling(unit))
    except Exception:  # pint raises its own errors and, for odd text, those of its tokenizer and of arithmetic
        return False
    return True


def format_quantity(value: float, unit: str) -> str:
    """The shortest text that `read` turns back into exactly this number."""
    number = repr(float(value))
    return number if unit == DIMENSIONLESS else f"{number} {unit}"


def is_plain(text: str) -> bool:
    """Whether a text is a decimal number of moderate size and nothing else."""
    return len(text) <= _LONGEST_PLAIN and _NUMBER.fullmatch(text) is not None


def to_internal(value: float, unit: str) -> float:
    """`value`, given in a canonical unit, in the system mN, cm, s, mV (1 kPa = 100 mN/cm^2, 1 ms = 1e-3 s).

    The cell model runs on its own clock in ms and takes its rates and times as they are stored.
    """
    try:
        return value * _INTERNAL[unit]
    except KeyError:
        raise ConfigurationError(
            f"unit {shown(unit)} has no internal factor; {_suggest_unit(unit, CANONICAL_UNITS)}"
        ) from None


def written(value: Any, unit: str) -> Any:
    """A value as it stands in a configuration file: numbers with their unit, tuples as lists, the rest as it is."""
    if isinstance(value, tuple):
        return [written(item, unit) for item in value]
    if isinstance(value, float):
        return value if unit == DIMENSIONLESS else format_quantity(value, unit)
    return value


def _read_text(text: str, unit: str) -> float:
    if len(text) > _LONGEST_TEXT:
        raise QuantityError(f"{len(text)} characters are too many for a quantity; {_write(unit)}")
    stripped = _typed(text.strip())
    found = _NUMBER.match(stripped)
    if found is None:
        raise QuantityError(f"it does not begin with a finite number; {_write(unit)}")
    digits, end = found.group(), found.end()
    power = _POWER_OF_TEN.match(stripped, end)
    if power is not None and "e" not in digits.lower():  # "1.5 x 10^-3 mV" with a sign of multiplication
        digits, end = f"{digits}e{power.group(1)}", power.end()
    number = _finite(float(digits), unit)
    given = _spelling(stripped[end:])
    if not given and unit != DIMENSIONLESS:
        raise QuantityError(f"the unit is missing; {_write(unit)}")
    if not given or given == _spelling(unit):
        return number
    if number == 0.0:
        _factor(given, unit)
        return 0.0
    # Exact until the last step: "7 mm" is the float 0.7 cm, not 0.7000000000000001.
    try:
        converted = float(Fraction(digits) * _factor(given, unit))
    except OverflowError:
        raise QuantityError(f"the number is too large in {unit}; {_write(unit)}") from None
    return _finite(converted, unit)


def _finite(number: float, unit: str) -> float:
    if not math.isfinite(number):
        raise QuantityError(f"it is not a finite number; {_write(unit)}")
    return number + 0.0  # no negative zero


def _typed(text: str) -> str:
    """Text in plain letters: signs of multiplication, raised and lowered digits, degrees, a true minus."""
    raised = _RAISED_TEXT.sub(lambda found: "^" + found.group().translate(_RAISED).removeprefix("+"), text)
    return raised.translate(_SPELLING)


def _spelling(unit: str) -> str:
    short = _typed(unit.strip()).replace("**", "^")
    short = re.sub(r"\b(mm\s+Hg|cm\s+H2O)\b", lambda found: re.sub(r"\s+", "", found.group()), short)
    short = re.sub(r"\s*([*/()^])\s*", r"\1", short)
    short = re.sub(r"(?<=[A-Za-z0-9)])\s*\.\s*(?=[A-Za-z(])", "*", short)  # "mN.s/cm"
    short = re.sub(r"([A-Za-z])(-?[1-4])(?![0-9A-Za-z])", r"\1^\2", short)  # "cm2", "s-1", but not "cmH2O"
    return re.sub(r"\s+", "*", short)


@lru_cache(maxsize=512)
def _factor(given: str, unit: str) -> Fraction:
    """Exact factor from a foreign unit to a canonical one."""
    if not _UNIT.fullmatch(given):
        raise QuantityError(f"{shown(given)} is not a unit; {_write(unit)}")
    registry = _registry()
    wanted = registry.dimensionless if unit == DIMENSIONLESS else registry.parse_units(unit)
    try:
        parsed = registry.parse_units(given)
    # pint raises its own errors and, for odd text, those of its tokenizer and of arithmetic.
    except Exception:
        raise QuantityError(f"unit {shown(given)} is unknown; {_suggest_unit(given, _FAMILIAR)}") from None
    try:
        return Fraction(registry.Quantity(Fraction(1), parsed).to(wanted).magnitude)
    except Exception:
        raise QuantityError(f"unit {given} cannot be converted to {unit}; {_write(unit)}") from None


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint  # 0.5 s, and most configurations never need it

    return pint.UnitRegistry(non_int_type=Fraction)


def _suggest_unit(unit: str, known: tuple[str, ...]) -> str:
    near = nearest(unit, known)
    return f"did you mean {near}?" if near else f"known are, for example, {', '.join(known[1:6])}"


def _write(unit: str) -> str:
    if unit == DIMENSIONLESS:
        return "give a bare number, for example 0.5"
    return f"give a number with a unit that converts to {unit}, for example '0.9 {unit}'"


_ATOMS = {
    "length": "[nuµμmcdk]?m|inch|in",
    "time": "[nuµμm]?s|min|h",
    "force": "[nuµμmk]?N|dyn",
    "mass": "[nuµμmk]?g",
    "pressure": "[mhkM]?Pa|m?bar|mm\\s*Hg|cm\\s*H[2₂]O|atm",
    "energy": "[nuµμmk]?J|erg",
    "potential": "[nuµμmk]?V",
    "current": "[npuµμm]?A",
    "conductance": "[npuµμm]?S",
    "capacitance": "[npuµμm]?F",
    "angle": "deg(?:ree)?s?|°|m?rad",
    "temperature": "m?K",
}
_MADE_OF = {
    "cm": ("length",),
    "s": ("time",),
    "ms": ("time",),
    "1/ms": ("time",),
    "deg": ("angle",),
    "K": ("temperature",),
    "mV": ("potential",),
    "1/mV": ("potential",),
    "mS/cm": ("conductance", "length"),
    "mS/cm^2": ("conductance", "length"),
    "uA/cm^2": ("current", "length"),
    "uF/cm^2": ("capacitance", "length"),
    "mN/(cm*mV)": ("force", "pressure", "energy", "length", "time", "mass", "potential"),
    "mg/cm^2": ("mass", "length"),
}
_MECHANICAL = ("force", "pressure", "energy", "length", "time", "mass")


def pattern(unit: str) -> str:
    """A regular expression of JSON Schema for texts of quantities in a canonical unit.

    It takes a number and the common units that a quantity of this kind is made of: an editor sees "9 kg" for a length.
    Powers are not weighed, and rare units (feet) are left to `read`.
    """
    atoms = "|".join(_ATOMS[kind] for kind in _MADE_OF.get(unit, _MECHANICAL))
    number = r"[+−-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
    power = r"(?:(?:\^|\*\*)?-?[1-4]|[⁺⁻]?[¹²³⁴])?"
    return rf"^\s*{number}\s*(?:(?:{atoms}){power}|[*·⋅×/().\s]|1(?![0-9]))+$"
