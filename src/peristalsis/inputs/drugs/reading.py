"""Doses from lines such as "nifedipine 30 nM in rabbit aorta", from tables of a file, or from Python."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from ...errors import ConfigurationError, UnknownKeyError, shown, suggestion
from ...units import QuantityError, format_quantity
from ...units import read as read_quantity
from .library import (
    Library,
    channels_of,
    library,
    number_of,
    range_of,
    tag_of,
    text_of,
)
from .specification import BOUNDS, CONCENTRATION, MOST_DOSES, Dose


class Drugged(Protocol):
    """What is needed of a configuration: which this room may not import, as it is part of one."""

    @property
    def drugs(self) -> tuple[Dose, ...]: ...

    def texts(self) -> dict[str, Any]: ...


EXAMPLE = "write for example 'nifedipine 30 nM', or 'nifedipine 30 nM in cardiac cells'"
_LINE = re.compile(
    r"(?P<agent>\S.*?)\s+(?P<amount>[0-9.]+(?:[eE][+-]?[0-9]+)?\s*[A-Za-zµμ/]+)(?:\s+in\s+(?P<tissue>\S.*))?"
)
_NAMED = re.compile(r"(?P<name>.*?\S)(?:\s+(?P<factor>[0-9.]+(?:[eE][+-]?[0-9]+)?))?")
OF_DOSE = (
    *("agent", "concentration", "target", "channels", "ic50", "range", "slope", "maximum", "tissue", "source", "tag"),
)


def read(given: object) -> tuple[Dose, ...]:
    """The doses of a list of lines and tables; an agent with several targets is several. Raises ConfigurationError."""
    listed = [given] if isinstance(given, str | Mapping | Dose) else given
    if not isinstance(listed, list | tuple):
        raise ConfigurationError(f"drugs = {shown(given)}: not a list; {EXAMPLE}")
    doses = [dose for item in listed[: MOST_DOSES + 1] for dose in _doses(item)]
    if len(doses) > MOST_DOSES:
        raise ConfigurationError(f"drugs: more than {MOST_DOSES} are too many; leave some out")
    seen: set[tuple[str, str]] = set()
    for dose in doses:
        if (dose.agent, dose.target) in seen:
            raise ConfigurationError(
                f"drugs: {dose.agent} is given twice on {dose.target}; give its whole concentration"
            )
        seen.add((dose.agent, dose.target))
    return tuple(doses)


def from_line(line: str, known: Library | None = None) -> tuple[Dose, ...]:
    """The doses of a line of text, one a target. Raises ConfigurationError."""
    known = library() if known is None else known
    found = _LINE.fullmatch(line.strip())
    if found is None:
        name = line.strip()
        if named(name, known):
            raise ConfigurationError(
                f"drugs: {shown(name)} changes parameters and no channel: set these instead, or give it by --drug"
            )
        raise ConfigurationError(f"drugs: {shown(name)} is no agent with a concentration; {EXAMPLE}")
    try:
        concentration = read_quantity(found["amount"], CONCENTRATION)
    except QuantityError as error:
        raise ConfigurationError(f"drugs: {shown(line)}: {error}") from None
    if concentration > BOUNDS["concentration"][1]:
        raise ConfigurationError(f"drugs: {shown(line)}: more than 1 M is no concentration of an agent; correct it")
    entries = known.of(found["agent"], found["tissue"])
    usable = [one for one in entries if known.targets[one.target].channels]
    if not usable:
        target = known.targets[entries[0].target]
        raise ConfigurationError(
            f"drugs: {entries[0].name} acts on {target.name}, which the model does not have ({target.note}); leave it "
            "out, or state in a file of your own on which channel it is to act ([targets], --drugs FILE)"
        )
    return tuple(
        Dose(
            one.name,
            concentration,
            one.target,
            known.targets[one.target].channels,
            one.ic50,
            one.slope,
            one.maximum,
            one.tissue,
            one.source,
            one.tag,
            one.range,
        )
        for one in usable
    )


def _doses(item: object) -> tuple[Dose, ...]:
    if isinstance(item, Dose):
        return (item,)
    if isinstance(item, str):
        return from_line(item)
    if not isinstance(item, Mapping):
        raise ConfigurationError(f"drugs: {shown(item)} is neither a line nor a table; {EXAMPLE}")
    if "dose" in item:
        for key in item:
            if key not in ("dose", "file"):
                raise UnknownKeyError(f"drugs: {shown(key)} does not go with dose; give dose and file, or all keys")
        return from_line(text_of(item, "dose", "drugs"), library(item.get("file")))
    for key in item:
        if key not in OF_DOSE:
            raise UnknownKeyError(f"drugs: {shown(key)} is no key of a dose; {suggestion(str(key), OF_DOSE)}")
    where = f"drugs: {shown(item.get('agent'))}"
    return (
        Dose(
            text_of(item, "agent", "drugs"),
            number_of(item, "concentration", where),
            text_of(item, "target", where),
            channels_of(item.get("channels"), where),
            number_of(item, "ic50", where),
            number_of(item, "slope", where, 1.0),
            number_of(item, "maximum", where, 0.0),
            text_of(item, "tissue", where, "not stated"),
            text_of(item, "source", where, "not stated"),
            tag_of({"tag": "chosen", **item}, where),
            range_of(item, where),
        ),
    )


def named(line: str, known: Library) -> tuple[str, float | None] | None:
    """Name and factor of an intervention in a line such as "lubricant 0.3", or None if it names none."""
    found = _NAMED.fullmatch(line.strip())
    names = {one.casefold(): one for one in known.interventions}
    if found is None or found["name"].casefold() not in names:
        return None
    return names[found["name"].casefold()], None if found["factor"] is None else float(found["factor"])


def changes_by(lines: Sequence[str], configuration: Drugged, source: str | None = None) -> dict[str, object]:
    """What lines of agents and interventions, as for `--drug`, change in a configuration.

    Agents come beside those that it has; interventions multiply its numbers. source: a library file, or one of
    `variants`. Raises ConfigurationError.
    """
    known, texts = library(source), configuration.texts()
    changes: dict[str, object] = {}
    doses: list[Dose] = []
    for line in lines:
        intervention = named(line, known)
        if intervention is None:
            doses += from_line(line, known)
            continue
        name, given = intervention
        one = known.interventions[name]
        factor = one.factor if given is None else given
        if not one.range[0] <= factor <= one.range[1]:
            raise ConfigurationError(
                f"{name} {factor:g}: out of its range of {one.range[0]:g} to {one.range[1]:g}; stay within, or set "
                f"{' and '.join(one.parameters)}"
            )
        for key in one.parameters:
            value = str(changes.get(key, texts.get(key, "")))
            digits, _, unit = value.partition(" ")
            try:
                changes[key] = format_quantity(factor * float(digits), unit or "1")
            except ValueError:
                raise ConfigurationError(
                    f"{name}: {key} is no number of this configuration; correct the library"
                ) from None
    return changes | ({"drugs": [*configuration.drugs, *doses]} if doses else {})
