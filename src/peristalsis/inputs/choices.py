"""Parts chosen in a configuration, and their numbers: `wall.law = "neo_hookean"`, `wall.neo_hookean.stiffness = ...`.

A cell or an activation may be chosen for both layers (`tissue.cell`) or for one (`longitudinal.cell`, `circular.cell`);
so may its numbers: `tissue.morris_lecar.calcium` is that of both layers, `circular.morris_lecar.calcium` that of one.
Both layers have one kind of muscle, with numbers of both (`wall.bell.peak`) or of one (`circular.bell.peak`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from typing import Any

from .. import units
from ..declared import Declared
from ..errors import ConfigurationError, UnknownKeyError, shown, suggestion
from .parts import KINDS, SHIPPED, Part, find, parts

LAYERS = ("longitudinal", "circular")
SLOTS: Mapping[str, str] = {
    "tissue.cell": "cell",
    "longitudinal.cell": "cell",
    "circular.cell": "cell",
    "network.cell": "cell",
    "tissue.activation": "activation",
    "longitudinal.activation": "activation",
    "circular.activation": "activation",
    "wall.law": "law",
    "wall.muscle": "muscle",
    "pellet.shape": "shape",
}
"""Parameter that chooses a part to the kind of it."""
SECTIONS: Mapping[str, tuple[str, ...]] = {
    "tissue": ("cell", "activation"),
    "longitudinal": ("cell", "activation", "muscle"),
    "circular": ("cell", "activation", "muscle"),
    "network": ("cell",),
    "wall": ("law", "muscle"),
    "pellet": ("shape",),
}
"""Section to the kinds of parts whose numbers stand below it."""
HOMES: Mapping[str, str] = {kind: next(key for key in SLOTS if SLOTS[key] == kind).partition(".")[0] for kind in KINDS}
"""Kind of a part to the section of those of its numbers that no layer has for itself."""
COMMON = "tissue"
"""What `longitudinal.cell` and `circular.cell` say to have the cell of the tissue; so do those of activations."""


def declared(key: object) -> Declared | None:
    """The number of a known part that a key such as "wall.neo_hookean.stiffness" stands for, or None."""
    words = key.split(".") if isinstance(key, str) else []
    if len(words) != 3 or words[0] not in SECTIONS:
        return None
    part = _part_of(words[0], words[1])
    return next((one for one in part.numbers if one.name == words[2]), None) if part else None


def _part_of(section: str, name: str) -> Part | None:
    """The known part of a name whose numbers stand below a section."""
    return next((part for kind in SECTIONS[section] if (part := parts(kind).get(name))), None)


def is_of_part(key: str) -> bool:
    """Whether a known key is that of a number of a part."""
    return key.count(".") == 2


def has_effect(key: str, slots: Mapping[str, Part]) -> bool:
    """Whether a known key is one of a chosen part, or of no part."""
    return not is_of_part(key) or key in dict(_used(slots))


def is_channel(key: str) -> bool:
    """Whether a key stands for the conductance of a channel of a known cell."""
    words = key.split(".")
    part = parts("cell").get(words[1]) if len(words) == 3 and "cell" in SECTIONS.get(words[0], ()) else None
    return part is not None and words[2] in [one.name for one in part.channels]


def refuse_unknown(key: str) -> None:
    """Say what is wrong with a key of three names that `declared` does not know."""
    section, name, number = key.split(".")
    part = _part_of(section, name)
    if part is None:
        kinds = SECTIONS[section]
        known = [one for kind in kinds for one in parts(kind)]
        raise UnknownKeyError(f"{shown(key)}: {shown(name)} is no {' and no '.join(kinds)}; {suggestion(name, known)}")
    names = [one.name for one in part.numbers]
    fix = suggestion(number, names) if names else f"those of {name} stand in its sections (peristalsis list)"
    raise UnknownKeyError(f"{shown(key)} is not a parameter of the {part.kind} {name}; {fix}")


def chosen(values: Mapping[str, Any]) -> dict[str, Part]:
    """The part in every slot. values: dotted keys of a configuration, at least those of SLOTS."""
    found = {}
    for key, kind in SLOTS.items():
        name = values[key]
        if not isinstance(name, str):
            raise ConfigurationError(f"{key} = {shown(name)}: not the name of a {kind}; {suggestion('', parts(kind))}")
        if key.partition(".")[0] in LAYERS and name == COMMON:
            name = values[f"{COMMON}.{kind}"]
        try:
            found[key] = find(kind, name)
        except ConfigurationError as error:
            raise ConfigurationError(f"{key} = {error}") from None
    return found


def in_use(values: Mapping[str, Any]) -> dict[str, Part]:
    """As `chosen`, without the cell of a network that is not there."""
    found = chosen(values)
    if values["network.enabled"] not in (True, "true", "on"):
        del found["network.cell"]
    return found


def foreign(slots: Mapping[str, Part]) -> dict[str, str]:
    """Hash of the file of every chosen part that the package does not ship, by its name."""
    return {
        f"{part.kind}.{part.name}": hashlib.sha256(part.file.read_bytes()).hexdigest()
        for part in slots.values()
        if part.origin != "peristalsis"
    }


def complete(given: Mapping[str, Any], slots: Mapping[str, Part]) -> tuple[tuple[str, float], ...]:
    """Numbers of the chosen parts by key, as given or as declared; of one layer alone only where they are given.

    given: dotted keys of three names to what stands in a file. Raises ConfigurationError for one that is not used or is
    out of its bounds.
    """
    used = dict(_used(slots))
    for key in given:
        if key not in used:
            section, name, _ = key.split(".")
            part = _part_of(section, name)
            assert part is not None
            slot = f"{section}.{part.kind}"
            slot = slot if slot in SLOTS else f"{HOMES[part.kind]}.{part.kind}"
            if slot not in slots:
                raise ConfigurationError(
                    f"{key} is set, and network.enabled = false: it would have no effect; set network.enabled = true, "
                    f"or leave {key} out"
                )
            raise ConfigurationError(
                f"{key} is set, and {slot} = {slots[slot].name}: it would have no effect; set {slot} = {name}, or "
                f"leave {key} out"
            )
    found = []
    for key, one in used.items():
        if key in given:
            found.append((key, _number(key, given[key], one)))
        elif key.partition(".")[0] not in LAYERS:
            found.append((key, float(one.value)))
    return tuple(found)


def _used(slots: Mapping[str, Part]) -> Iterator[tuple[str, Declared]]:
    """Every key that has a meaning with these parts."""
    for kind in ("cell", "activation"):
        for part in {slots[f"{layer}.{kind}"].name: slots[f"{layer}.{kind}"] for layer in LAYERS}.values():
            for one in part.numbers:
                yield f"{COMMON}.{part.name}.{one.name}", one
    for key, part in slots.items():
        section = key.partition(".")[0]
        if section != COMMON and (part.name != SHIPPED[part.kind] or key == "network.cell"):
            for own in (section, *LAYERS) if part.kind == "muscle" else (section,):
                for one in part.numbers:
                    yield f"{own}.{part.name}.{one.name}", one


def _number(key: str, value: object, one: Declared) -> float:
    try:
        number = units.read(value, one.unit)
    except ValueError as error:
        raise ConfigurationError(f"{key} = {shown(value)}: {error}") from None
    if not isinstance(number, float):
        raise ConfigurationError(f"{key} = {shown(value)}: not a number; write it as {_written(one.value, one)}")
    if not one.lowest <= number <= one.highest:
        words = {"ge": "at least", "le": "at most"}
        allowed = " and ".join(f"{words[bound]} {_written(limit, one)}" for bound, limit in one.bounds().items())
        raise ConfigurationError(f"{key} = {shown(_written(number, one))}: out of range; give a value of {allowed}")
    return number


def _written(value: float, one: Declared) -> str:
    return f"{value:.12g}" + ("" if one.unit == units.DIMENSIONLESS else f" {one.unit}")
