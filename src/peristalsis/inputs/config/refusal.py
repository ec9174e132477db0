"""What is wrong with the input, as one sentence with its key, its value and what to give instead."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError

from peristalsis import units
from peristalsis.errors import ConfigurationError, shown, suggestion

from .specification import FIELDS, FieldSpec


def explain(error: ValidationError) -> ConfigurationError:
    """The first complaint of pydantic in our words."""
    complaints = error.errors(include_url=False)
    first = complaints[0]
    key = ".".join(part for part in first["loc"] if isinstance(part, str))
    spec = FIELDS.get(key)
    if key == "protocols":
        raise ConfigurationError(f"protocols: {_protocol_cause(first)}")
    given = first["input"]
    # A number that was read but lies out of range arrives here without its unit.
    read = isinstance(given, float) and spec is not None and first["type"] != "value_error"
    value = shown(units.written(given, spec.unit) if spec is not None and read else given)
    more = f" (and {len(complaints) - 1} more)" if len(complaints) > 1 else ""
    return ConfigurationError(f"{key} = {value}: {_cause(first, spec)}{more}")


def _protocol_cause(complaint: Any) -> str:
    if complaint["type"] == "too_long":
        return f"too many; give at most {complaint['ctx']['max_length']}"
    return f"{complaint['msg'].removeprefix('Value error, ').lower()}; give a list of lines of text"


def _cause(complaint: Any, spec: FieldSpec | None) -> str:
    kind = complaint["type"]
    if kind == "value_error":
        return str(complaint["ctx"]["error"])
    if spec is None:
        return "a name has lower-case letters, digits, - and _, at most 64; choose such a name"
    if kind in ("greater_than", "greater_than_equal", "less_than", "less_than_equal"):
        return f"out of range; give a value of {spec.allowed()}"
    match spec.kind:
        case "choice" if isinstance(complaint["input"], str):
            return f"not one of {', '.join(spec.choices)}; {suggestion(complaint['input'], spec.choices)}"
        case "choice":
            return f"not one of {', '.join(spec.choices)}; give one of these as text"
        case "switch":
            return "not a switch; write true or false, without quotes in a file"
        case "integer":
            return f"not a whole number; give one of {spec.allowed()}"
        case "list" | "names" if kind == "too_long":
            return f"the list is too long; give at most {complaint['ctx']['max_length']} items"
        case "names":
            return f"not a list of names; write for example ['{spec.choices[0]}'] or ['{spec.choices[1]}']"
        case _:  # a list: a number that was read at all fails at its bounds only
            return f"not a list; write for example ['2 {spec.unit}', '5 {spec.unit}']"
