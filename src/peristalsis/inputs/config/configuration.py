"""The configuration of one run: every parameter, typed, checked, with unit, tag and source."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from os import PathLike
from types import MappingProxyType
from typing import Any, Self

from pydantic import Field, ValidationError, field_validator

from peristalsis import units
from peristalsis.inputs import choices, tables
from peristalsis.inputs.consistency import check
from peristalsis.inputs.drugs import Dose
from peristalsis.inputs.drugs import read as read_drugs
from peristalsis.inputs.parameters import PARAMETERS, Parameter, Value
from peristalsis.inputs.parts import Part, find
from peristalsis.inputs.protocols import Protocol, values_at
from peristalsis.inputs.protocols import parse as parse_protocol
from peristalsis.inputs.protocols import parse_all as parse_protocols
from peristalsis.inputs.protocols import shortened as shorten_protocols
from peristalsis.inputs.regions import Region
from peristalsis.inputs.regions import read as read_regions
from peristalsis.inputs.stimuli import MOST_WRITTEN as MOST_LISTED
from peristalsis.inputs.stimuli import Stimulus
from peristalsis.inputs.stimuli import read as read_stimuli
from peristalsis.inputs.stimuli import texts as stimuli_texts

from .fields import LAYERS, Sections
from .output import as_toml
from .reading import flatten, from_text, nest, read_toml, reading_numbers, reading_of, written_defaults
from .refusal import explain
from .specification import FIELDS, parameters_of, units_of_numbers

MOST_PROTOCOLS = 50


WITHOUT_EFFECT = ("run.checkpoint",)
"""Parameters that change how a run is carried out and no number of it: they are not part of its digest."""


SLOTS = tuple(choices.SLOTS)
"""Parameters that choose a part; where they choose the shipped one the digest is as without them."""
LATER: Mapping[str, object] = {
    "trigger.timing": "step",
    "tissue.front_correction": "none",
    "grid.exchange": "averages",
    "tissue.bidomain": "full",
    "solver.elliptic_tolerance": 1e-8,
    "solver.surface_tolerance": 1e-8,
    "solver.surface_newton": "plain",
    "solver.surface_modes": 0,
    "grid.n_theta_wall": 0,
    "wall.slack_length": 0.0,
    "reflex.kind": "all_or_none",
    "reflex.gain": 1.0,
    "pellet.viscous_friction_coefficient": 0.0,
    "pellet.fast_friction_share": 1.0,
    "pellet.held": False,
    "pellet.load": "none",
    "tissue.warming": 0.0,
}
"""Choices that earlier versions did not have, and what they did: there the digest is as without them."""
IDLE: Mapping[str, tuple[str, ...]] = {
    "reflex.kind": (
        "reflex.stretch_range",
        "reflex.summation",
        "reflex.longitudinal_intensity",
        "reflex.longitudinal_delay",
    ),
    "pellet.load": ("pellet.load_weight", "pellet.load_stiffness"),
    "pellet.fast_friction_share": ("pellet.friction_fall_speed",),
    "tissue.warming": ("tissue.q10_kinetics", "tissue.q10_force"),
}
"""One of the `LATER` choices to what has no effect, and no part in the digest, while it is as it was."""
ENDS = ("run.duration", "run.stop_when_expelled", "run.stop_when_arrested", "run.stop_position")
"""Parameters that say when a run ends, and change nothing before."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One parameter of a configuration beside what the package ships.

    `tag` is that of the shipped value, or "set by user", or "set by scenario"; `source`, `printed` and
    `shipped` always belong to the shipped value.
    """

    key: str
    value: Value
    unit: str
    tag: str
    source: str
    printed: str
    description: str
    shipped: Value


class Configuration(Sections):
    """All parameters of one run; without arguments, the baseline under the reading `tight`.

    The arguments are sections (tables or dotted keys) of values as they would stand in a file.  `scenario` is
    the name under which results are stored; `peristalsis.scenarios` turns a name into its changes.
    """

    reading: str = Field(default="tight", description="which reading of the paper supplies its doubtful numbers")
    scenario: str = Field(default="baseline", pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$", description="name of the run")
    protocols: tuple[str, ...] = Field(
        default=(), max_length=MOST_PROTOCOLS, description="inputs that change in time, one line of text each"
    )
    stimuli: tuple[Stimulus, ...] = Field(default=(), description="currents at listed times, one line of text each")
    regions: tuple[Region, ...] = Field(default=(), description="parts of the wall whose tissue differs")
    drugs: tuple[Dose, ...] = Field(default=(), description="agents and their concentrations")
    parts: tuple[tuple[str, float], ...] = Field(default=(), description="numbers of the chosen parts, by key")

    def __init__(self, **data: Any) -> None:
        given = flatten(data)
        complete = {**written_defaults(reading_of(given)), **given}
        of_parts = {key: complete.pop(key) for key in given if choices.is_of_part(key)}
        numbers = choices.complete(of_parts, choices.in_use(complete))
        try:
            super().__init__(**nest(complete), parts=numbers)
        except ValidationError as error:
            raise explain(error) from None
        check(self)

    @classmethod
    def from_mapping(cls, mapping: Mapping[Any, Any]) -> Self:
        """From nested tables, dotted keys, or both; what is not given is shipped."""
        return cls(**flatten(mapping))

    @classmethod
    def from_toml(cls, source: str | PathLike[str]) -> Self:
        """From TOML text (a str) or from a file (a Path): which of the two is never guessed."""
        return cls(**flatten(read_toml(source)))

    @classmethod
    def from_record(cls, source: str | PathLike[str]) -> Self:
        """As `from_toml`, of a run that is stored: choices that its version did not have are what it did."""
        later = {key: units.written(value, PARAMETERS[key].unit) for key, value in LATER.items()}
        return cls(**{**later, **flatten(read_toml(source))})

    def with_changes(self, changes: Mapping[Any, Any]) -> Self:
        """A new configuration.  Texts are read by the type of their field ("true", "12", "[2 cm, 5 cm]").

        A changed `reading` brings its own numbers with it, before the other changes apply.
        """
        return self.overlaid({key: from_text(key, value) for key, value in flatten(changes).items()})

    def overlaid(self, tree: Mapping[Any, Any]) -> Self:
        """As `with_changes`, with the values as they stand in a file: a quoted "true" is not a switch."""
        given = flatten(tree)
        kept = self.texts()
        if any(
            key in given for key in (*SLOTS, "network.enabled")
        ):  # numbers of a part that is chosen no more go with it
            slots = choices.in_use({**self.flat(), **given})
            kept = {key: text for key, text in kept.items() if choices.has_effect(key, slots)}
        if "reading" in given:
            kept |= reading_numbers(reading_of(given), self.reading)
        return type(self)(**{**kept, **given})

    def cell_of(self, layer: str) -> str:
        """Name of the cell model of the longitudinal or the circular layer."""
        own: str = getattr(self, layer).cell  # network.cell too
        return self.tissue.cell if own == choices.COMMON else own

    def activation_of(self, layer: str) -> Part:
        """What makes the drive of the longitudinal or the circular layer's muscle."""
        own: str = getattr(self, layer).activation
        return find("activation", self.tissue.activation if own == choices.COMMON else own)

    def parts_chosen(self) -> dict[str, Any]:
        """What is chosen in the slots by key, without the shipped parts: which kernels a run needs."""
        found = {key: value for key, value in self.flat().items() if key in SLOTS and key != "network.cell"}
        found = {key: value for key, value in found.items() if value != PARAMETERS[key].value}
        return found | ({"network.enabled": True, "network.cell": self.network.cell} if self.network.enabled else {})

    def cells(self) -> dict[str, Part]:
        """Cell model of each layer, and of the network where there is one."""
        found = {layer: find("cell", self.cell_of(layer)) for layer in LAYERS}
        return found | {"network": find("cell", self.network.cell)} if self.network.enabled else found

    def capacitance_of(self, layer: str) -> float:
        """Capacitance of the cells of a layer [uF/cm^2]."""
        part = find("cell", self.cell_of(layer))
        return self.part_numbers(layer, part)["capacitance"] if part.parameters else self.tissue.capacitance

    def part_numbers(self, section: str, part: Part) -> dict[str, float]:
        """Numbers of a chosen part by name; section: that of its slot, a layer's own numbers before those of both."""
        numbers = dict(self.parts)
        found = {}
        for one in part.numbers:
            own = f"{section}.{part.name}.{one.name}"
            common = f"{choices.HOMES[part.kind]}.{part.name}.{one.name}"
            found[one.name] = numbers[own] if own in numbers else numbers[common]
        return found

    def with_reading(self, reading: str) -> Self:
        """The same under another reading: its numbers replace what stood at their keys."""
        return self.with_changes({"reading": reading})

    def flat(self) -> dict[str, Value]:
        """Dotted key to value, in the canonical unit, in the order of the file."""
        values: dict[str, Any] = {"reading": self.reading, "scenario": self.scenario, "protocols": self.protocols}
        values["regions"] = self.regions
        values["stimuli"] = self.stimuli
        values["drugs"] = self.drugs
        for spec in FIELDS.values():
            values[spec.key] = getattr(getattr(self, spec.section), spec.name)
        return values | dict(self.parts)

    def texts(self) -> dict[str, Any]:
        """Dotted key to value as it is written in a file: numbers with their units."""
        texts: dict[str, Any] = {
            key: units.written(value, FIELDS[key].unit if key in FIELDS else "") for key, value in self.flat().items()
        }
        del texts["stimuli"], texts["drugs"]
        if self.stimuli:
            texts["stimuli"] = stimuli_texts(self.stimuli)
        if self.drugs:
            texts["drugs"] = [dose.table() for dose in self.drugs]
        return texts | {"regions": [region.table() for region in self.regions]}

    def items(
        self, scenario: Configuration | None = None, preparation: Mapping[str, Parameter] = MappingProxyType({})
    ) -> Iterator[Entry]:
        """Every parameter with its unit, tag and source; changed values are tagged as such.

        Given the unchanged configuration of a scenario, values that agree with it are "set by scenario", and those of
        its preparation have the tag and the source that they have there.
        """
        ours = self.flat()
        scenario_values = {} if scenario is None else scenario.flat()
        for key, about in parameters_of(self.reading):
            tag: str = about.tag
            if ours[key] != about.value:
                tag = "set by scenario" if scenario_values.get(key) == ours[key] else "set by user"
            own = preparation.get(key)
            measured = own is not None and scenario_values.get(key) == ours[key]
            yield Entry(
                key=key,
                value=ours[key],
                unit=about.unit,
                tag=own.tag if own is not None and measured else tag,
                source=own.source if own is not None and measured else about.source,
                printed=about.printed,
                description=about.description,
                shipped=about.value,
            )
        for key, value in self.parts:
            one = choices.declared(key)
            assert one is not None
            tag = one.tag
            if value != one.value:
                tag = "set by scenario" if scenario_values.get(key) == value else "set by user"
            yield Entry(key, value, one.unit, tag, one.source, "", one.description, float(one.value))

    @field_validator("protocols", mode="before")
    @classmethod
    def _read_protocols(cls, value: object) -> object:
        """Protocols in their canonical text; tables are read in."""
        lines = [value] if isinstance(value, str) else value
        if not isinstance(lines, list | tuple):
            raise ValueError("not a list of protocols, each one line of text")
        numbers = units_of_numbers()
        read = [one for line in lines[: MOST_PROTOCOLS + 1] for one in parse_protocols(line, numbers)]  # others unread
        return tuple(protocol.text(numbers[protocol.parameter]) for protocol in shorten_protocols(read))

    @field_validator("stimuli", mode="before")
    @classmethod
    def _read_stimuli(cls, value: object) -> object:
        """Stimuli as data; files are read in."""
        if isinstance(value, tuple) and all(isinstance(item, Stimulus) for item in value):
            return value
        return read_stimuli(value, float(PARAMETERS["pacemaker.width"].value))  # type: ignore[arg-type]

    @field_validator("regions", mode="before")
    @classmethod
    def _read_regions(cls, value: object) -> object:
        """Regions as data; files of maps are read in."""
        return read_regions(value)

    @field_validator("drugs", mode="before")
    @classmethod
    def _read_drugs(cls, value: object) -> object:
        """Doses as data; what a library says of an agent is read in."""
        return read_drugs(value)

    def time_courses(self) -> tuple[Protocol, ...]:
        """The protocols as functions of time."""
        return tuple(parse_protocol(line, units_of_numbers()) for line in self.protocols)

    def at_start(self) -> Self:
        """A copy with the values that the protocols have at t = 0, which the run starts from; itself without any."""
        courses = self.time_courses()
        return self.at_time(values_at(courses, 0.0)) if courses else self

    def at_time(self, values: Mapping[str, float]) -> Self:
        """A copy with checked numbers put in place by key, without checking them again: for use inside a run."""
        sections: dict[str, dict[str, float]] = {}
        of_parts = {key: value for key, value in values.items() if choices.is_of_part(key)}
        for key, value in values.items():
            section, _, name = key.partition(".")
            if key not in of_parts:
                sections.setdefault(section, {})[name] = value
        update: dict[str, Any] = {
            name: getattr(self, name).model_copy(update=fields) for name, fields in sections.items()
        }
        if of_parts:
            update["parts"] = tuple((dict(self.parts) | of_parts).items())
        return self.model_copy(update=update)

    def naming_tables(self) -> tuple[str, ...]:
        """The lines of text that may name a table kept by its content."""
        return (*self.protocols, *(stimuli_texts(self.stimuli) if len(self.stimuli) > MOST_LISTED else ()))

    def __getstate__(self) -> dict[Any, Any]:
        """For other processes: with the tables of many rows that protocols name."""
        return super().__getstate__() | {"tables": tables.held(self.naming_tables())}

    def __setstate__(self, state: dict[Any, Any]) -> None:
        tables.hold_all(state.pop("tables"))
        super().__setstate__(state)

    def to_toml(self) -> str:
        """The complete configuration; `from_toml` reads it back identically."""
        lines = ["# Complete configuration; every number that has a unit carries it."]
        section = ""
        texts = self.texts()
        listed = texts.pop("stimuli", [])
        for key, value in texts.items():
            if key in ("regions", "drugs"):
                continue
            if key == "protocols" and listed:
                lines.append(f"stimuli = {as_toml(listed)}")
            table, _, name = key.rpartition(".")
            if table != section:
                lines += ["", f"[{table}]"]
                section = table
            lines.append(f"{name} = {as_toml(value)}")
        for name, listed in (("regions", self.regions), ("drugs", self.drugs)):
            for one in listed:
                lines += ["", f"[[{name}]]", *(f"{key} = {as_toml(value)}" for key, value in one.table().items())]
        return "\n".join(lines) + "\n"

    def digest(self, ends: bool = True) -> str:
        """SHA-256 of the canonical JSON of `texts`, without what leaves the results as they are.

        ends: False leaves out when the run ends: equal then are runs of which one is the beginning of the other.
        """
        without = WITHOUT_EFFECT if ends else (*WITHOUT_EFFECT, *ENDS)
        ours = self.flat()
        without = (*without, *(key for key in SLOTS if ours[key] == PARAMETERS[key].value))
        if not self.network.enabled:
            without = (*without, *(key for key in ours if key.startswith("network.")))
        as_before = [key for key, first in LATER.items() if ours[key] == first]
        without = (*without, *as_before, *(idle for key in as_before for idle in IDLE.get(key, ())))
        if self.trigger.gate == "none":
            without = (*without, *(key for key in ours if key.startswith("trigger.gate")))
        if self.step.control == "fixed":
            without = (*without, "step.control", "step.longest", "step.shortest", "step.tolerance")
        else:
            without = (*without, "step.wall")
        texts = {key: text for key, text in self.texts().items() if key not in without}
        foreign = choices.foreign(choices.in_use(self.flat()))
        if foreign:  # the same name may stand for another file tomorrow
            texts["parts"] = foreign
        canonical = json.dumps(texts, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
        return hashlib.sha256(canonical.encode("ascii")).hexdigest()
