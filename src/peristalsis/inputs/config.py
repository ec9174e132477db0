"""The configuration of one run: every parameter, typed, checked, with unit, tag and source.

Each field is written once, below, with its bounds; its default, unit, description, tag and source come from
the parameter files by key.  Numbers are stored in the canonical unit of their parameter, and enter and leave
as text with a unit.  Whatever is wrong with the input becomes one ConfigurationError of one line.
"""

from __future__ import annotations

import errno
import hashlib
import json
import operator
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from numbers import Integral
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidationInfo, field_validator
from pydantic.fields import FieldInfo

from peristalsis import units
from peristalsis.errors import ConfigurationError, UnknownKeyError, shown, suggestion
from peristalsis.inputs import tables
from peristalsis.inputs.consistency import check
from peristalsis.inputs.parameters import PARAMETERS, READINGS, Parameter, Value, shipped
from peristalsis.inputs.protocols import Protocol, values_at
from peristalsis.inputs.protocols import parse as parse_protocol
from peristalsis.inputs.protocols import parse_all as parse_protocols
from peristalsis.inputs.protocols import shortened as shorten_protocols
from peristalsis.inputs.recording import CHOICES as FIELD_CHOICES
from peristalsis.inputs.recording import choices
from peristalsis.inputs.regions import Region
from peristalsis.inputs.regions import read as read_regions
from peristalsis.inputs.regions import schema as regions_schema
from peristalsis.inputs.stimuli import MOST_WRITTEN as MOST_LISTED
from peristalsis.inputs.stimuli import Stimulus
from peristalsis.inputs.stimuli import read as read_stimuli
from peristalsis.inputs.stimuli import texts as stimuli_texts
from peristalsis.paths import beside_file, located
from peristalsis.storing.disk import read_regular

LAYERS = ("longitudinal", "circular")

LARGEST_TEXT = 512 * 1024  # bytes of a configuration file, which may hold maps
LONGEST_LIST = 1000
MOST_PROTOCOLS = 50

# A key of thousands of parts takes the TOML reader minutes. Each part is matched once, so this takes no time itself.
_PART = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(rf"(?:{_PART}[ \t]*+\.[ \t]*+){{16}}")

WITHOUT_EFFECT = ("run.checkpoint",)
"""Parameters that change how a run is carried out and no number of it: they are not part of its digest."""
ENDS = ("run.duration", "run.stop_when_expelled", "run.stop_when_arrested", "run.stop_position")
"""Parameters that say when a run ends, and change nothing before."""

_MODEL = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def parameter(
    key: str,
    *,
    gt: float | None = None,
    ge: float | None = None,
    lt: float | None = None,
    le: float | None = None,
    max_length: int | None = None,
) -> Any:
    """Declare a field by the key of its parameter; "layer.*" has its value, and its default, per layer."""
    section, _, name = key.partition(".")
    about = PARAMETERS[f"{LAYERS[0]}.{name}" if section == "layer" else key]
    limits = {"gt": gt, "ge": ge, "lt": lt, "le": le, "max_length": max_length}
    given: dict[str, Any] = {bound: limit for bound, limit in limits.items() if limit is not None}
    if section != "layer":
        given["default"] = about.value
    return Field(description=about.description, json_schema_extra={"unit": about.unit}, **given)


class Section(BaseModel):
    """A table of the configuration."""

    model_config = _MODEL

    @field_validator("*", mode="before")
    @classmethod
    def _read(cls, value: object, info: ValidationInfo) -> object:
        """Quantities to floats in their canonical unit; the rest is left to the strict types."""
        field = cls.model_fields[str(info.field_name)]
        kind = _kind(field)
        if kind == "number":
            return units.read(value, _unit(field))
        if kind == "names" and isinstance(value, list | tuple):
            return tuple(value)
        if kind == "list" and isinstance(value, list | tuple):
            # One more than any list may have: a longer one is refused without being read.
            return tuple(units.read(item, _unit(field)) for item in value[: LONGEST_LIST + 1])
        if kind == "integer" and isinstance(value, Integral) and not isinstance(value, bool):
            return operator.index(value)
        return value


class Pellet(Section):
    """The rigid sphere."""

    enabled: bool = parameter("pellet.enabled")
    radius: float = parameter("pellet.radius", gt=0, le=20)
    viscous_friction: float = parameter("pellet.viscous_friction", gt=0, le=1e7)
    dry_friction: float = parameter("pellet.dry_friction", ge=0, le=1e7)
    static_friction_factor: float = parameter("pellet.static_friction_factor", ge=1, le=100)
    friction_coefficient: float = parameter("pellet.friction_coefficient", ge=0, le=10)
    friction_frame: Literal["rest", "wall"] = parameter("pellet.friction_frame")
    start_gap: float = parameter("pellet.start_gap", ge=0, le=200)
    sideways: Literal["fixed", "free"] = parameter("pellet.sideways")
    sideways_friction: float = parameter("pellet.sideways_friction", gt=0, le=1e7)


class Lumen(Section):
    """The content of the tube around the pellet."""

    pressure: float = parameter("lumen.pressure", ge=0, le=100)
    adiabatic_exponent: float = parameter("lumen.adiabatic_exponent", ge=0, le=10)


class Wall(Section):
    """The passive tube."""

    radius: float = parameter("wall.radius", gt=0, le=20)
    length: float = parameter("wall.length", gt=0, le=200)
    surface_density: float = parameter("wall.surface_density", gt=0, le=1e6)
    oral_end: Literal["open", "closed"] = parameter("wall.oral_end")
    anal_end: Literal["open", "closed"] = parameter("wall.anal_end")
    inertia: bool = parameter("wall.inertia")
    viscosity: float = parameter("wall.viscosity", gt=0, le=1e6)
    tension: Literal["published", "consistent"] = parameter("wall.tension")
    c1: float = parameter("wall.c1", ge=0, le=1e6)
    c2: float = parameter("wall.c2", ge=0, le=1e6)
    c3: float = parameter("wall.c3", ge=0, le=1e6)
    c4: float = parameter("wall.c4", ge=0, le=100)
    c5: float = parameter("wall.c5", ge=0, le=100)
    c6: float = parameter("wall.c6", ge=-100, le=100)
    c10: float = parameter("wall.c10", ge=0, le=1e4)
    slack_blend: float = parameter("wall.slack_blend", ge=0, le=10)
    slack_slope: float = parameter("wall.slack_slope", ge=0, le=1)
    fold_stretch: float = parameter("wall.fold_stretch", ge=0, le=0.9)
    fold_tension: float = parameter("wall.fold_tension", ge=0, le=1e6)
    bending_stiffness: float = parameter("wall.bending_stiffness", ge=0, le=100)
    bending_viscosity: float = parameter("wall.bending_viscosity", ge=0, le=100)
    bending_stiffness_around: float = parameter("wall.bending_stiffness_around", ge=0, le=100)
    bending_viscosity_around: float = parameter("wall.bending_viscosity_around", ge=0, le=100)
    shear_viscosity: float = parameter("wall.shear_viscosity", ge=0, le=1e4)
    foundation: float = parameter("wall.foundation", ge=0, le=1e4)


class Layer(Section):
    """One muscle layer: its pull, its currents and its conduction."""

    active: float = parameter("layer.active", ge=0, le=100)
    threshold: float = parameter("layer.threshold", ge=-200, le=100)
    c7: float = parameter("layer.c7", ge=-1e5, le=1e5)
    c8: float = parameter("layer.c8", ge=-1e5, le=1e5)
    c9: float = parameter("layer.c9", ge=-1e5, le=1e5)
    slow_calcium: float = parameter("layer.slow_calcium", ge=0, le=100)
    fast_calcium: float = parameter("layer.fast_calcium", ge=0, le=100)
    calcium_potassium: float = parameter("layer.calcium_potassium", ge=0, le=100)
    potassium: float = parameter("layer.potassium", ge=0, le=100)
    leak: float = parameter("layer.leak", ge=0, le=100)
    intracellular_axial: float = parameter("layer.intracellular_axial", gt=0, le=1e5)
    intracellular_circumferential: float = parameter("layer.intracellular_circumferential", gt=0, le=1e5)
    extracellular_axial: float = parameter("layer.extracellular_axial", gt=0, le=1e5)
    extracellular_circumferential: float = parameter("layer.extracellular_circumferential", gt=0, le=1e5)
    conductivity_scale: float = parameter("layer.conductivity_scale", gt=0, le=1000)
    conduction: bool = parameter("layer.conduction")


class Tissue(Section):
    """What both layers share."""

    capacitance: float = parameter("tissue.capacitance", gt=0, le=1000)
    volume_to_surface: float = parameter("tissue.volume_to_surface", gt=0, le=10)
    kinetics_rate: float = parameter("tissue.kinetics_rate", gt=0, le=100)


class Cell(Section):
    """Constants of the cell model, on its own clock in ms."""

    calcium_reversal: float = parameter("cell.calcium_reversal", ge=-300, le=300)
    potassium_reversal: float = parameter("cell.potassium_reversal", ge=-300, le=300)
    chloride_reversal: float = parameter("cell.chloride_reversal", ge=-300, le=300)
    calcium_half_saturation: float = parameter("cell.calcium_half_saturation", gt=0, le=100)
    calcium_rate: float = parameter("cell.calcium_rate", gt=0, le=10)
    calcium_influx: float = parameter("cell.calcium_influx", gt=0, le=10)
    calcium_entry_potential: float = parameter("cell.calcium_entry_potential", ge=-300, le=1000)
    gate_time_factor: float = parameter("cell.gate_time_factor", gt=0, le=1e4)
    slow_gate_time: float = parameter("cell.slow_gate_time", gt=0, le=1e6)


class Pacemaker(Section):
    """The drive at the oral end."""

    kind: Literal["none", "pulse", "periodic", "cell"] = parameter("pacemaker.kind")
    onset: float = parameter("pacemaker.onset", ge=0, le=1e5)
    intensity: float = parameter("pacemaker.intensity", ge=0, le=1000)
    duration: float = parameter("pacemaker.duration", gt=0, le=1000)
    width: float = parameter("pacemaker.width", gt=0, le=200)
    period: float = parameter("pacemaker.period", gt=0, le=1e4)
    count: int = parameter("pacemaker.count", ge=1, le=10_000)
    cell_slow_calcium: float = parameter("pacemaker.cell_slow_calcium", ge=0, le=100)
    cell_rate: float = parameter("pacemaker.cell_rate", gt=0, le=1000)
    cell_coupling: float = parameter("pacemaker.cell_coupling", ge=0, le=1000)
    place: float = parameter("pacemaker.place", ge=0, le=200)
    angle: float = parameter("pacemaker.angle", ge=-360, le=360)
    angular_width: float = parameter("pacemaker.angular_width", gt=0, le=360)


class Trigger(Section):
    """How the circular layer follows the longitudinal one."""

    rule: Literal["active", "total", "pacemaker", "delay", "none"] = parameter("trigger.rule")
    delay: float = parameter("trigger.delay", ge=-5, le=5)
    level: float = parameter("trigger.level", ge=0, le=1e6)
    intensity: float = parameter("trigger.intensity", ge=0, le=1000)
    duration: float = parameter("trigger.duration", gt=0, le=100)
    refractory: float = parameter("trigger.refractory", ge=0, le=1000)


class Reflex(Section):
    """The stretch receptors and their motor neurons."""

    enabled: bool = parameter("reflex.enabled")
    threshold: float = parameter("reflex.threshold", ge=0, le=10)
    oral_length: float = parameter("reflex.oral_length", ge=0, le=200)
    anal_length: float = parameter("reflex.anal_length", ge=0, le=200)
    delay: float = parameter("reflex.delay", ge=0, le=100)
    refractory: float = parameter("reflex.refractory", ge=0, le=1000)
    excitation_intensity: float = parameter("reflex.excitation_intensity", ge=0, le=1000)
    excitation_duration: float = parameter("reflex.excitation_duration", gt=0, le=100)
    inhibition_conductance: float = parameter("reflex.inhibition_conductance", ge=0, le=1000)
    inhibition_duration: float = parameter("reflex.inhibition_duration", gt=0, le=100)


class Rings(Section):
    """Standing rings of the circular layer, excited together."""

    enabled: bool = parameter("rings.enabled")
    positions: tuple[Annotated[float, Field(ge=0, le=200)], ...] = parameter("rings.positions", max_length=100)
    width: float = parameter("rings.width", gt=0, le=200)
    intensity: float = parameter("rings.intensity", ge=0, le=1000)
    duration: float = parameter("rings.duration", gt=0, le=1000)
    period: float = parameter("rings.period", gt=0, le=1e4)
    count: int = parameter("rings.count", ge=1, le=10_000)


class Grid(Section):
    """Cells along and around the tube."""

    n_z: int = parameter("grid.n_z", ge=8, le=20_000)
    n_z_wall: int = parameter("grid.n_z_wall", ge=8, le=20_000)
    n_theta: int = parameter("grid.n_theta", ge=1, le=4096)
    n_theta_conduction: int = parameter("grid.n_theta_conduction", ge=0, le=4096)

    @property
    def conduction_columns(self) -> int:
        """Columns of conduction cells: as many as those of the wall unless stated."""
        return self.n_theta_conduction or self.n_theta


class Step(Section):
    """Time steps and the time scheme of the wall."""

    conduction: float = parameter("step.conduction", ge=1e-4, le=100)
    wall: float = parameter("step.wall", ge=1e-4, le=1000)
    scheme: Literal["bdf2", "euler"] = parameter("step.scheme")
    explicit: float = parameter("step.explicit", ge=0, le=100)


class Solver(Section):
    """Tolerances and limits of the solvers."""

    residual_tolerance: float = parameter("solver.residual_tolerance", ge=1e-14, le=1e-2)
    penetration_tolerance: float = parameter("solver.penetration_tolerance", ge=1e-12, le=0.1)
    max_newton: int = parameter("solver.max_newton", ge=1, le=1000)
    max_halvings: int = parameter("solver.max_halvings", ge=0, le=40)
    exact_kinetics: bool = parameter("solver.exact_kinetics")
    integrator: Literal["implicit", "explicit"] = parameter("solver.integrator")
    explicit_damping: Literal["lagged", "predicted"] = parameter("solver.explicit_damping")
    explicit_safety: float = parameter("solver.explicit_safety", gt=0, le=1)
    contact_stiffness: float = parameter("solver.contact_stiffness", gt=0, le=1e12)


class Run(Section):
    """How long to simulate."""

    duration: float = parameter("run.duration", gt=0, le=1e5)
    stop_when_expelled: bool = parameter("run.stop_when_expelled")
    stop_when_arrested: bool = parameter("run.stop_when_arrested")
    stop_position: float = parameter("run.stop_position", gt=0, le=1000)
    checkpoint: float = parameter("run.checkpoint", ge=0, le=1e5)


class Output(Section):
    """What is stored."""

    interval: float = parameter("output.interval", gt=0, le=1e4)
    probes: tuple[Annotated[float, Field(ge=0, le=200)], ...] = parameter("output.probes", max_length=LONGEST_LIST)
    fields: tuple[str, ...] = parameter("output.fields", max_length=100)

    @field_validator("fields")
    @classmethod
    def _known(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            if name not in choices():
                raise ValueError(f"{shown(name)} is not a field; {suggestion(name, choices())}")
        return names


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


class Configuration(BaseModel):
    """All parameters of one run; without arguments, the baseline under the reading `tight`.

    The arguments are sections (tables or dotted keys) of values as they would stand in a file.  `scenario` is
    the name under which results are stored; `peristalsis.scenarios` turns a name into its changes.
    """

    model_config = _MODEL

    reading: str = Field(default="tight", description="which reading of the paper supplies its doubtful numbers")
    scenario: str = Field(default="baseline", pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$", description="name of the run")
    protocols: tuple[str, ...] = Field(
        default=(), max_length=MOST_PROTOCOLS, description="inputs that change in time, one line of text each"
    )
    stimuli: tuple[Stimulus, ...] = Field(default=(), description="currents at listed times, one line of text each")
    regions: tuple[Region, ...] = Field(default=(), description="parts of the wall whose tissue differs")
    pellet: Pellet = Field(default_factory=Pellet)
    lumen: Lumen = Field(default_factory=Lumen)
    wall: Wall = Field(default_factory=Wall)
    longitudinal: Layer
    circular: Layer
    tissue: Tissue = Field(default_factory=Tissue)
    cell: Cell = Field(default_factory=Cell)
    pacemaker: Pacemaker = Field(default_factory=Pacemaker)
    trigger: Trigger = Field(default_factory=Trigger)
    reflex: Reflex = Field(default_factory=Reflex)
    rings: Rings = Field(default_factory=Rings)
    grid: Grid = Field(default_factory=Grid)
    step: Step = Field(default_factory=Step)
    solver: Solver = Field(default_factory=Solver)
    run: Run = Field(default_factory=Run)
    output: Output = Field(default_factory=Output)

    def __init__(self, **data: Any) -> None:
        given = _flatten(data)
        complete = _nest({**_written_defaults(_reading_of(given)), **given})
        try:
            super().__init__(**complete)
        except ValidationError as error:
            raise _explain(error) from None
        check(self)

    @classmethod
    def from_mapping(cls, mapping: Mapping[Any, Any]) -> Self:
        """From nested tables, dotted keys, or both; what is not given is shipped."""
        return cls(**_flatten(mapping))

    @classmethod
    def from_toml(cls, source: str | PathLike[str]) -> Self:
        """From TOML text (a str) or from a file (a Path): which of the two is never guessed."""
        return cls(**_flatten(read_toml(source)))

    def with_changes(self, changes: Mapping[Any, Any]) -> Self:
        """A new configuration.  Texts are read by the type of their field ("true", "12", "[2 cm, 5 cm]").

        A changed `reading` brings its own numbers with it, before the other changes apply.
        """
        return self.overlaid({key: _from_text(key, value) for key, value in _flatten(changes).items()})

    def overlaid(self, tree: Mapping[Any, Any]) -> Self:
        """As `with_changes`, with the values as they stand in a file: a quoted "true" is not a switch."""
        given = _flatten(tree)
        kept = self.texts()
        if "reading" in given:
            kept |= _reading_numbers(_reading_of(given))
        return type(self)(**{**kept, **given})

    def with_reading(self, reading: str) -> Self:
        """The same under another reading: its numbers replace what stood at their keys."""
        return self.with_changes({"reading": reading})

    def flat(self) -> dict[str, Value]:
        """Dotted key to value, in the canonical unit, in the order of the file."""
        values: dict[str, Any] = {"reading": self.reading, "scenario": self.scenario, "protocols": self.protocols}
        values["regions"] = self.regions
        values["stimuli"] = self.stimuli
        for spec in FIELDS.values():
            values[spec.key] = getattr(getattr(self, spec.section), spec.name)
        return values

    def texts(self) -> dict[str, Any]:
        """Dotted key to value as it is written in a file: numbers with their units."""
        texts: dict[str, Any] = {
            key: units.written(value, FIELDS[key].unit if key in FIELDS else "") for key, value in self.flat().items()
        }
        del texts["stimuli"]
        if self.stimuli:
            texts["stimuli"] = stimuli_texts(self.stimuli)
        return texts | {"regions": [region.table() for region in self.regions]}

    def items(self, scenario: Configuration | None = None) -> Iterator[Entry]:
        """Every parameter with its unit, tag and source; changed values are tagged as such.

        Given the unchanged configuration of a scenario, values that agree with it are "set by scenario".
        """
        ours = self.flat()
        scenario_values = {} if scenario is None else scenario.flat()
        for key, about in _parameters(self.reading):
            tag: str = about.tag
            if ours[key] != about.value:
                tag = "set by scenario" if scenario_values.get(key) == ours[key] else "set by user"
            yield Entry(
                key=key,
                value=ours[key],
                unit=about.unit,
                tag=tag,
                source=about.source,
                printed=about.printed,
                description=about.description,
                shipped=about.value,
            )

    @field_validator("protocols", mode="before")
    @classmethod
    def _read_protocols(cls, value: object) -> object:
        """Protocols in their canonical text; tables are read in."""
        lines = [value] if isinstance(value, str) else value
        if not isinstance(lines, list | tuple):
            raise ValueError("not a list of protocols, each one line of text")
        numbers = _numbers()
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

    def time_courses(self) -> tuple[Protocol, ...]:
        """The protocols as functions of time."""
        return tuple(parse_protocol(line, _numbers()) for line in self.protocols)

    def at_start(self) -> Self:
        """A copy with the values that the protocols have at t = 0, which the run starts from; itself without any."""
        courses = self.time_courses()
        return self.at_time(values_at(courses, 0.0)) if courses else self

    def at_time(self, values: Mapping[str, float]) -> Self:
        """A copy with checked numbers put in place by key, without checking them again: for use inside a run."""
        sections: dict[str, dict[str, float]] = {}
        for key, value in values.items():
            section, _, name = key.partition(".")
            sections.setdefault(section, {})[name] = value
        update = {name: getattr(self, name).model_copy(update=fields) for name, fields in sections.items()}
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
            if key == "regions":
                continue
            if key == "protocols" and listed:
                lines.append(f"stimuli = {_toml(listed)}")
            table, _, name = key.rpartition(".")
            if table != section:
                lines += ["", f"[{table}]"]
                section = table
            lines.append(f"{name} = {_toml(value)}")
        for region in self.regions:
            lines += ["", "[[regions]]", *(f"{name} = {_toml(value)}" for name, value in region.table().items())]
        return "\n".join(lines) + "\n"

    def digest(self, ends: bool = True) -> str:
        """SHA-256 of the canonical JSON of `texts`, without what leaves the results as they are.

        ends: False leaves out when the run ends: equal then are runs of which one is the beginning of the other.
        """
        without = WITHOUT_EFFECT if ends else (*WITHOUT_EFFECT, *ENDS)
        texts = {key: text for key, text in self.texts().items() if key not in without}
        canonical = json.dumps(texts, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
        return hashlib.sha256(canonical.encode("ascii")).hexdigest()


@dataclass(frozen=True, slots=True)
class FieldSpec:
    """What is known of a field: where it is, what it takes, and how to say so."""

    key: str
    section: str
    name: str
    kind: str
    unit: str
    choices: tuple[str, ...]
    bounds: Mapping[str, float]

    def allowed(self) -> str:
        """The allowed range in words."""
        words = {"gt": "more than", "ge": "at least", "lt": "less than", "le": "at most"}
        return " and ".join(f"{words[bound]} {self._written(limit)}" for bound, limit in self.bounds.items())

    def _written(self, limit: float) -> str:
        unit = "" if self.unit == units.DIMENSIONLESS else f" {self.unit}"
        return f"{limit:.12g}{unit}"


def json_schema() -> dict[str, Any]:
    """JSON Schema of the file format: quantities are strings with a unit, their bounds stand beside it."""
    sections: dict[str, Any] = {}
    for key, about in _parameters("tight"):
        spec = FIELDS[key]
        table = sections.setdefault(spec.section, {"type": "object", "additionalProperties": False, "properties": {}})
        table["properties"][spec.name] = _schema_of(spec, about)
    names: dict[str, Any] = {
        name: {"type": "string", "default": field.default, "description": field.description}
        for name, field in Configuration.model_fields.items()
        if name not in (*_SECTIONS, "protocols", "stimuli", "regions")
    }
    lines = Configuration.model_fields["protocols"].description
    names["protocols"] = {"type": "array", "items": {"type": "string"}, "default": [], "description": lines}
    file = {"type": "object", "properties": {"file": {"type": "string"}}, "additionalProperties": False}
    lines = Configuration.model_fields["stimuli"].description
    listed = {"anyOf": [{"type": "string"}, file | {"required": ["file"]}]}
    names["stimuli"] = {"type": "array", "items": listed, "default": [], "description": lines}
    names["regions"] = regions_schema()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "peristalsis configuration",
        "type": "object",
        "additionalProperties": False,
        "properties": names | sections,
    }


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


# --- fields ---------------------------------------------------------------------------------------


def _unit(field: FieldInfo) -> str:
    extra = field.json_schema_extra
    return str(extra["unit"]) if isinstance(extra, dict) else ""


def _kind(field: FieldInfo) -> str:
    annotation = field.annotation
    if get_origin(annotation) is Literal:
        return "choice"
    if get_origin(annotation) is tuple:
        return "names" if get_args(annotation)[0] is str else "list"
    return {bool: "switch", int: "integer", float: "number"}[annotation]  # type: ignore[index]


def _bounds(field: FieldInfo) -> dict[str, float]:
    """Bounds of a number, or of the items of a list."""
    constraints: list[Any] = list(field.metadata)
    if _kind(field) == "list":
        item = get_args(field.annotation)[0]
        constraints = [inner for outer in item.__metadata__ for inner in outer.metadata]
    return {
        bound: getattr(constraint, bound)
        for bound in ("gt", "ge", "lt", "le")
        for constraint in constraints
        if hasattr(constraint, bound)
    }


def _specs() -> Iterator[FieldSpec]:
    for section, table in _SECTIONS.items():
        for name, field in table.model_fields.items():
            kind = _kind(field)
            yield FieldSpec(
                key=f"{section}.{name}",
                section=section,
                name=name,
                kind=kind,
                unit=_unit(field),
                choices=get_args(field.annotation) if kind == "choice" else FIELD_CHOICES if kind == "names" else (),
                bounds=_bounds(field),
            )


_SECTIONS: dict[str, type[Section]] = {
    name: field.annotation
    for name, field in Configuration.model_fields.items()
    if isinstance(field.annotation, type) and issubclass(field.annotation, Section)
}
FIELDS: Mapping[str, FieldSpec] = {spec.key: spec for spec in _specs()}


def _numbers() -> dict[str, str]:
    """Every numeric parameter with its canonical unit."""
    return {key: spec.unit for key, spec in FIELDS.items() if spec.kind == "number"}


KEYS = ("reading", "scenario", "protocols", "stimuli", "regions", *FIELDS)


def _parameters(reading: str) -> Iterator[tuple[str, Parameter]]:
    values = shipped(reading)
    return ((key, values[key]) for key in FIELDS)


# --- from input to a complete tree ----------------------------------------------------------------


def _flatten(tree: Mapping[Any, Any]) -> dict[str, Any]:
    """Dotted keys, each known and given once."""
    if not isinstance(tree, Mapping):
        raise ConfigurationError(f"{shown(tree)} is not a table of parameters; give keys with values")
    flat: dict[str, Any] = {}
    for name, value in tree.items():
        if name not in _SECTIONS:
            _put(flat, name, value)
            continue
        if isinstance(value, Section):
            value = {field: units.written(inner, FIELDS[f"{name}.{field}"].unit) for field, inner in value}
        if not isinstance(value, Mapping):
            raise ConfigurationError(
                f"{name} = {shown(value)}: {name} is a section; set one of its parameters, "
                f"for example {name}.{next(iter(_SECTIONS[name].model_fields))}"
            )
        for inner_name, inner in value.items():
            _put(flat, f"{name}.{inner_name}" if isinstance(inner_name, str) else inner_name, inner)
    return flat


def _put(flat: dict[str, Any], key: object, value: object) -> None:
    if not isinstance(key, str) or key not in KEYS:
        known = (*KEYS, *_SECTIONS)
        fix = suggestion(key, known) if isinstance(key, str) else "keys are text such as pellet.radius"
        raise UnknownKeyError(f"{shown(key)} is not a parameter; {fix}")
    if key in flat:
        raise ConfigurationError(f"{key} is given twice; keep one")
    flat[key] = units.plain(value) if key in FIELDS else value


def _nest(flat: Mapping[str, Any]) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for key, value in flat.items():
        section, _, name = key.rpartition(".")
        if section:
            tree.setdefault(section, {})[name] = value
        else:
            tree[name] = value
    return tree


def _reading_of(given: Mapping[str, Any]) -> str:
    reading = given.get("reading", "tight")
    if not isinstance(reading, str):
        raise ConfigurationError(f"reading = {shown(reading)}: give the name of a reading as text")
    shipped(reading)
    return reading


@lru_cache(maxsize=8)
def _written_defaults(reading: str) -> Mapping[str, Any]:
    return {key: units.written(about.value, about.unit) for key, about in _parameters(reading)}


def _reading_numbers(reading: str) -> dict[str, Any]:
    """What a reading supplies: the keys on which readings may differ."""
    return {key: units.written(about.value, about.unit) for key, about in READINGS[reading].parameters.items()}


def _from_text(key: str, value: object) -> object:
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


# --- output ---------------------------------------------------------------------------------------


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{value}"'  # names and quantities only: nothing to escape
    if isinstance(value, list):
        return f"[{', '.join(_toml(item) for item in value)}]"
    return repr(value)


def _schema_of(spec: FieldSpec, about: Parameter) -> dict[str, Any]:
    names = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
    limits = {names[bound]: limit for bound, limit in spec.bounds.items()}
    schema: dict[str, Any]
    if spec.kind in ("choice", "names"):
        schema = {"type": "string", "enum": list(spec.choices)}
    elif spec.kind == "switch":
        schema = {"type": "boolean"}
    elif spec.kind == "integer":
        schema = {"type": "integer"} | limits
    elif spec.unit == units.DIMENSIONLESS:
        schema = {"type": "number"} | limits
    else:
        schema = {"type": "string", "pattern": units.pattern(spec.unit), "x-unit": spec.unit}
        schema |= {f"x-{name}": limit for name, limit in limits.items()}
    if spec.kind in ("list", "names"):
        schema = {"type": "array", "items": schema}
    origin = {"description": about.description, "x-tag": about.tag, "x-source": about.source}
    return schema | {"default": units.written(about.value, about.unit)} | origin


# --- refusal --------------------------------------------------------------------------------------


def _explain(error: ValidationError) -> ConfigurationError:
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
