"""From TOML, tables, dotted keys and words of a command line to a complete tree of values."""

from __future__ import annotations

import errno
import re
import tomllib
from collections.abc import Mapping
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Any

from peristalsis import units
from peristalsis.errors import ConfigurationError, UnknownKeyError, shown, suggestion
from peristalsis.inputs import choices
from peristalsis.inputs.parameters import READINGS, shipped
from peristalsis.paths import beside_file, located
from peristalsis.storing.disk import read_regular

from .fields import Section
from .specification import FIELDS, KEYS, SECTIONS, parameters_of

LARGEST_TEXT = 512 * 1024  # bytes of a configuration file, which may hold maps


# A key of thousands of parts takes the TOML reader minutes. Each part is matched once, so this takes no time itself.
_PART = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""


_LONG_KEY = re.compile(rf"(?:{_PART}[ \t]*+\.[ \t]*+){{16}}")


def read_toml(source: str | PathLike[str], most: int = LARGEST_TEXT) -> dict[str, Any]:
    """The tables of TOML text or of a file of at most `most` bytes, before any check of keys and values.

    Files that a file names lie beside it: their paths come back with its folder in front.
    """
    if isinstance(source, str):
        text, where, folder = source.removeprefix("\ufeff"), "the configuration text", None
    else:
        file = located(source)
        text, where, folder = _read_file(file, most), shown(str(source)), file.parent
    if len(text) > most:
        raise ConfigurationError(f"{where} has {len(text)} characters, more than {most}; shorten it")
    if _LONG_KEY.search(text):
        raise ConfigurationError(f"{where} has a key of many parts, and none has more than three; correct it")
    try:
        tables = tomllib.loads(text)
        return tables if folder is None else beside_file(tables, folder)
    except (ValueError, RecursionError) as error:
        cause = "it is nested too deeply" if isinstance(error, RecursionError) else shown(str(error), 120)
        fix = "give a Path to read a file" if source == text and text.endswith(".toml") else "correct it"
        raise ConfigurationError(f"{where} is not valid TOML: {cause}; {fix}") from None


def _read_file(path: Path, most: int) -> str:
    try:
        content = read_regular(path, most, follow=True)
    except (OSError, ValueError) as error:
        if isinstance(error, OSError) and error.errno == errno.EFBIG:
            raise ConfigurationError(f"{shown(str(path))} is larger than {most} bytes; shorten it") from None
        cause = error.strerror if isinstance(error, OSError) else "it is not a path"
        raise ConfigurationError(
            f"{shown(str(path))} cannot be read: {cause}; check the name and the permissions"
        ) from None
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ConfigurationError(f"{shown(str(path))} is not UTF-8 text; save it as UTF-8") from None


def flatten(tree: Mapping[Any, Any]) -> dict[str, Any]:
    """Dotted keys, each known and given once."""
    if not isinstance(tree, Mapping):
        raise ConfigurationError(f"{shown(tree)} is not a table of parameters; give keys with values")
    flat: dict[str, Any] = {}
    for name, value in tree.items():
        if name not in SECTIONS:
            _put(flat, name, value)
            continue
        if isinstance(value, Section):
            value = {field: units.written(inner, FIELDS[f"{name}.{field}"].unit) for field, inner in value}
        if not isinstance(value, Mapping):
            raise ConfigurationError(
                f"{name} = {shown(value)}: {name} is a section; set one of its parameters, "
                f"for example {name}.{next(iter(SECTIONS[name].model_fields))}"
            )
        for inner_name, inner in value.items():
            key = f"{name}.{inner_name}" if isinstance(inner_name, str) else inner_name
            if isinstance(inner, Mapping) and name in choices.SECTIONS and key not in FIELDS:
                for last, number in inner.items():
                    _put(flat, f"{key}.{last}", number)
            else:
                _put(flat, key, inner)
    return flat


def _put(flat: dict[str, Any], key: object, value: object) -> None:
    if isinstance(key, str) and key.count(".") == 2 and key.partition(".")[0] in choices.SECTIONS:
        if key not in FIELDS:
            choices.refuse_unknown(key)
    elif not isinstance(key, str) or key not in KEYS:
        known = (*KEYS, *SECTIONS)
        fix = suggestion(key, known) if isinstance(key, str) else "keys are text such as pellet.radius"
        raise UnknownKeyError(f"{shown(key)} is not a parameter; {fix}")
    if key in flat:
        raise ConfigurationError(f"{key} is given twice; keep one")
    flat[key] = units.plain(value) if key in FIELDS else value


def nest(flat: Mapping[str, Any]) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for key, value in flat.items():
        section, _, name = key.rpartition(".")
        if section:
            tree.setdefault(section, {})[name] = value
        else:
            tree[name] = value
    return tree


def reading_of(given: Mapping[str, Any]) -> str:
    reading = given.get("reading", "tight")
    if not isinstance(reading, str):
        raise ConfigurationError(f"reading = {shown(reading)}: give the name of a reading as text")
    shipped(reading)
    return reading


@lru_cache(maxsize=8)
def written_defaults(reading: str) -> Mapping[str, Any]:
    return {key: units.written(about.value, about.unit) for key, about in parameters_of(reading)}


def reading_numbers(reading: str, before: str) -> dict[str, Any]:
    """What a change from one reading to another changes: the numbers that either of them brings."""
    numbers = shipped(reading)
    return {key: units.written(numbers[key].value, numbers[key].unit) for key in keys_of_readings(reading, before)}


def keys_of_readings(*readings: str) -> tuple[str, ...]:
    """The keys at which any of these readings brings a number of its own."""
    return tuple(dict.fromkeys(key for reading in readings for key in READINGS[reading].parameters))


def from_text(key: str, value: object) -> object:
    """The text of a command line, by the type of its field."""
    if not isinstance(value, str) or key not in FIELDS:
        if isinstance(value, str) and key in ("protocols", "stimuli", "regions"):
            return _tables_of(value) if key == "regions" else [value]
        return value
    text = value.strip()
    match FIELDS[key].kind:
        case "switch":
            return {"true": True, "on": True, "false": False, "off": False}.get(text.lower(), value)
        case "integer":
            digits = text.removeprefix("-").removeprefix("+")
            return int(text) if digits.isascii() and digits.isdigit() and len(digits) <= 18 else value
        case "list" | "names":
            inner = text.removeprefix("[").removesuffix("]").strip()
            return [item.strip().strip("'\"") for item in inner.split(",")] if inner else []
        case _:
            return text


def _tables_of(text: str) -> object:
    """Regions on a command line: the list as it would stand in a file, such as [{name = "a", ...}]."""
    try:
        return tomllib.loads(f"regions = {text}")["regions"]
    except (ValueError, RecursionError):
        return text
