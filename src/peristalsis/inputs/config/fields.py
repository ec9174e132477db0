"""Every parameter with its bounds, written once; default, unit, description, tag and source come from its key."""

from __future__ import annotations

import math
import operator
from numbers import Integral
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator
from pydantic.fields import FieldInfo

from peristalsis import units
from peristalsis.errors import shown, suggestion
from peristalsis.inputs.parameters import PARAMETERS
from peristalsis.inputs.recording import choices

LAYERS = ("longitudinal", "circular")


LONGEST_LIST = 1000


MODEL = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


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

    model_config = MODEL

    @field_validator("*", mode="before")
    @classmethod
    def _read(cls, value: object, info: ValidationInfo) -> object:
        """Quantities to floats in their canonical unit; the rest is left to the strict types."""
        field = cls.model_fields[str(info.field_name)]
        kind = kind_of(field)
        if kind == "number":
            return units.read(value, unit_of(field))
        if kind == "names" and isinstance(value, list | tuple):
            return tuple(value)
        if kind == "list" and isinstance(value, list | tuple):
            # One more than any list may have: a longer one is refused without being read.
            return tuple(units.read(item, unit_of(field)) for item in value[: LONGEST_LIST + 1])
        if kind == "integer" and isinstance(value, Integral) and not isinstance(value, bool):
            return operator.index(value)
        return value


class Pellet(Section):
    """The rigid pellet; radius is that of its girth, whatever its shape."""

    enabled: bool = parameter("pellet.enabled")
    shape: str = parameter("pellet.shape")
    radius: float = parameter("pellet.radius", gt=0, le=20)
    viscous_friction: float = parameter("pellet.viscous_friction", gt=0, le=1e7)
    dry_friction: float = parameter("pellet.dry_friction", ge=0, le=1e7)
    static_friction_factor: float = parameter("pellet.static_friction_factor", ge=1, le=100)
    friction_coefficient: float = parameter("pellet.friction_coefficient", ge=0, le=10)
    friction_frame: Literal["rest", "wall"] = parameter("pellet.friction_frame")
    viscous_friction_coefficient: float = parameter("pellet.viscous_friction_coefficient", ge=0, le=1e4)
    fast_friction_share: float = parameter("pellet.fast_friction_share", ge=0, le=1)
    friction_fall_speed: float = parameter("pellet.friction_fall_speed", gt=0, le=1e4)
    held: bool = parameter("pellet.held")
    load: Literal["none", "weight", "spring"] = parameter("pellet.load")
    load_weight: float = parameter("pellet.load_weight", ge=0, le=1e7)
    load_stiffness: float = parameter("pellet.load_stiffness", gt=0, le=1e7)
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
    slack_length: float = parameter("wall.slack_length", ge=0, le=200)
    surface_density: float = parameter("wall.surface_density", gt=0, le=1e6)
    oral_end: Literal["open", "closed"] = parameter("wall.oral_end")
    anal_end: Literal["open", "closed"] = parameter("wall.anal_end")
    inertia: bool = parameter("wall.inertia")
    viscosity: float = parameter("wall.viscosity", gt=0, le=1e6)
    law: str = parameter("wall.law")
    muscle: str = parameter("wall.muscle")
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

    @property
    def span(self) -> float:
        """Distance between the held ends [cm]."""
        return self.length - self.slack_length


class Layer(Section):
    """One muscle layer: its pull, its currents and its conduction."""

    cell: str = parameter("layer.cell")
    activation: str = parameter("layer.activation")
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

    cell: str = parameter("tissue.cell")
    activation: str = parameter("tissue.activation")
    capacitance: float = parameter("tissue.capacitance", gt=0, le=1000)
    volume_to_surface: float = parameter("tissue.volume_to_surface", gt=0, le=10)
    kinetics_rate: float = parameter("tissue.kinetics_rate", gt=0, le=100)
    warming: float = parameter("tissue.warming", ge=-40, le=20)
    q10_kinetics: float = parameter("tissue.q10_kinetics", gt=0, le=10)
    q10_force: float = parameter("tissue.q10_force", gt=0, le=10)
    front_correction: Literal["none", "measured"] = parameter("tissue.front_correction")
    bidomain: Literal["full", "pseudo"] = parameter("tissue.bidomain")


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


class Network(Section):
    """A network of interstitial cells that drives both layers."""

    enabled: bool = parameter("network.enabled")
    cell: str = parameter("network.cell")
    diffusivity: float = parameter("network.diffusivity", ge=0, le=100)
    coupling_longitudinal: float = parameter("network.coupling_longitudinal", ge=0, le=1000)
    coupling_circular: float = parameter("network.coupling_circular", ge=0, le=1000)
    load: float = parameter("network.load", ge=0, le=1000)
    head_start: float = parameter("network.head_start", ge=0, le=1000)
    lag: float = parameter("network.lag", ge=0, le=1000)


class Trigger(Section):
    """How the circular layer follows the longitudinal one."""

    rule: Literal["active", "total", "pacemaker", "delay", "none"] = parameter("trigger.rule")
    delay: float = parameter("trigger.delay", ge=-5, le=5)
    level: float = parameter("trigger.level", ge=0, le=1e6)
    intensity: float = parameter("trigger.intensity", ge=0, le=1000)
    duration: float = parameter("trigger.duration", gt=0, le=100)
    refractory: float = parameter("trigger.refractory", ge=0, le=1000)
    timing: Literal["step", "within"] = parameter("trigger.timing")
    gate: Literal["none", "stretch"] = parameter("trigger.gate")
    gate_oral_length: float = parameter("trigger.gate_oral_length", ge=0, le=200)
    gate_anal_length: float = parameter("trigger.gate_anal_length", ge=0, le=200)
    gate_delay: float = parameter("trigger.gate_delay", ge=0, le=100)
    gate_duration: float = parameter("trigger.gate_duration", gt=0, le=1000)


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
    kind: Literal["all_or_none", "graded"] = parameter("reflex.kind")
    gain: float = parameter("reflex.gain", ge=0, le=100)
    stretch_range: float = parameter("reflex.stretch_range", gt=0, le=10)
    summation: float = parameter("reflex.summation", gt=0, le=200)
    longitudinal_intensity: float = parameter("reflex.longitudinal_intensity", ge=0, le=1000)
    longitudinal_delay: float = parameter("reflex.longitudinal_delay", ge=0, le=100)


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
    exchange: Literal["averages", "reconstructed"] = parameter("grid.exchange")
    n_theta_wall: int = parameter("grid.n_theta_wall", ge=0, le=4096)

    @property
    def wall_columns(self) -> int:
        """Columns on which the wall is solved: as many as it is shown on unless stated."""
        return self.n_theta_wall or self.n_theta

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
    control: Literal["fixed", "error"] = parameter("step.control")
    longest: float = parameter("step.longest", ge=1e-4, le=1000)
    shortest: float = parameter("step.shortest", ge=1e-4, le=1000)
    tolerance: float = parameter("step.tolerance", gt=0, le=10)

    @property
    def whole(self) -> float:
        """Length of a step of the run [ms]: what is recorded, and what a step in parts is made of, is whole ones."""
        return self.wall if self.control == "fixed" else self.longest

    @property
    def whole_key(self) -> str:
        """The parameter that says how long a step of the run is."""
        return "step.wall" if self.control == "fixed" else "step.longest"

    @property
    def halvings(self) -> int:
        """How often a step whose length follows its error can be halved."""
        return max(0, round(math.log2(self.longest / self.shortest)))


class Solver(Section):
    """Tolerances and limits of the solvers."""

    residual_tolerance: float = parameter("solver.residual_tolerance", ge=1e-14, le=1e-2)
    surface_tolerance: float = parameter("solver.surface_tolerance", ge=1e-14, le=1e-1)
    surface_newton: Literal["plain", "mixed"] = parameter("solver.surface_newton")
    surface_modes: int = parameter("solver.surface_modes", ge=0, le=100)
    penetration_tolerance: float = parameter("solver.penetration_tolerance", ge=1e-12, le=0.1)
    max_newton: int = parameter("solver.max_newton", ge=1, le=1000)
    max_halvings: int = parameter("solver.max_halvings", ge=0, le=40)
    exact_kinetics: bool = parameter("solver.exact_kinetics")
    elliptic_tolerance: float = parameter("solver.elliptic_tolerance", ge=1e-13, le=1e-2)
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


def unit_of(field: FieldInfo) -> str:
    extra = field.json_schema_extra
    return str(extra["unit"]) if isinstance(extra, dict) else ""


def kind_of(field: FieldInfo) -> str:
    annotation = field.annotation
    if get_origin(annotation) is Literal:
        return "choice"
    if get_origin(annotation) is tuple:
        return "names" if get_args(annotation)[0] is str else "list"
    return {bool: "switch", int: "integer", float: "number", str: "part"}[annotation]  # type: ignore[index]


class Sections(BaseModel):
    """The tables of a configuration, in the order of its file."""

    model_config = MODEL

    pellet: Pellet = Field(default_factory=Pellet)
    lumen: Lumen = Field(default_factory=Lumen)
    wall: Wall = Field(default_factory=Wall)
    longitudinal: Layer
    circular: Layer
    tissue: Tissue = Field(default_factory=Tissue)
    cell: Cell = Field(default_factory=Cell)
    pacemaker: Pacemaker = Field(default_factory=Pacemaker)
    network: Network = Field(default_factory=Network)
    trigger: Trigger = Field(default_factory=Trigger)
    reflex: Reflex = Field(default_factory=Reflex)
    rings: Rings = Field(default_factory=Rings)
    grid: Grid = Field(default_factory=Grid)
    step: Step = Field(default_factory=Step)
    solver: Solver = Field(default_factory=Solver)
    run: Run = Field(default_factory=Run)
    output: Output = Field(default_factory=Output)
