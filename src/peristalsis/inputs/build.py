"""From a configuration, in the units people use, to a model, in the units the kernels use."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..control.pacemaker import Outlet, Source
from ..control.pulses import Listed, Pulse, listed
from ..control.reflex import Reflex
from ..control.sequence import Gate, Trigger
from ..errors import ConfigurationError
from ..geometry.grid import Grid
from ..model.constants import LumenConstants
from ..model.model import ExplicitScheme, Layer, Model, Network, PacemakerCell, Response, StepControl
from ..numerics.binding import Binding, bind
from ..pellet.constants import Resistance
from ..pellet.friction import FrictionLaw
from ..tissue.bidomain import Elliptic
from ..tissue.cell import PLANT, SHIPPED_CELL, Cell, described
from ..tissue.cells.plant import CHANNELS, CellConstants
from ..tissue.surface import Conductivities
from ..units import to_internal
from ..wall.constants import SurfaceConstants, WallConstants
from .config import Configuration
from .config import Layer as LayerConfiguration
from .drugs import factors
from .muscle import LAW_SLOT, MUSCLE_SLOT, active_constants, muscle_of_layer, passive_constants
from .parts import find
from .regions.sampling import factor_field
from .shape import SLOT as SHAPE_SLOT
from .shape import PelletShape, shape_of

Floats = NDArray[np.float64]


def bound_to(configuration: Configuration) -> Binding:
    """The kernels of wall, pellet and step with the parts that a configuration chooses in their slots."""
    law, muscle = find("law", configuration.wall.law), find("muscle", configuration.wall.muscle)
    shape = find("shape", configuration.pellet.shape)
    return bind({LAW_SLOT: law.file, MUSCLE_SLOT: muscle.file, SHAPE_SLOT: shape.file})


def build(configuration: Configuration, like: Model | None = None, since: Configuration | None = None) -> Model:
    """The model of a configuration; V0 and the pellet-free radius are still those of the undeformed tube.

    like: the model of a run under way, whose grid, V0 and pellet-free radius are kept: only inputs change. since: the
    configuration that it was built from; parts whose section is the same object are taken over.
    """
    c = configuration
    binding = like.binding if like is not None else bound_to(c)  # parts stay as they are during a run

    def same(*sections: str) -> bool:
        shared = (*sections, "regions", "drugs", "tissue")
        return since is not None and all(getattr(c, name) is getattr(since, name) for name in shared)

    grid = like.grid if like is not None else _grid(c)
    dt_wall = to_internal(c.step.whole, "ms")
    explicit = c.solver.integrator == "explicit"
    shape = _fitting_shape(c, binding)
    friction = FrictionLaw(
        c.pellet.static_friction_factor, c.pellet.friction_coefficient, c.pellet.viscous_friction_coefficient
    )
    return Model(
        grid=grid,
        longitudinal=like.longitudinal if like and same("longitudinal", "parts") else _layer(c, "longitudinal", grid),
        circular=like.circular if like and same("circular", "parts") else _layer(c, "circular", grid),
        wall=like.wall if like and same("wall", "longitudinal", "circular", "parts") else _wall(c, grid, binding),
        pellet=shape.pellet(
            present=c.pellet.enabled,
            viscous=c.pellet.viscous_friction,
            dry=c.pellet.dry_friction,
            frame=1.0 if c.pellet.friction_frame == "wall" else 0.0,
            tangential=friction.presses,
            **_reach(c, shape)._asdict(),
            resistance=_resistance(c, shape),
        ),
        lumen=LumenConstants(
            to_internal(c.lumen.pressure, "kPa"),
            like.lumen.reference_volume if like is not None else 1.0,
            c.lumen.adiabatic_exponent,
        ),
        sources=_sources(c),
        pacemaker_cell=_pacemaker_cell(c),
        trigger=Trigger(
            c.trigger.rule,
            c.trigger.delay,
            c.trigger.level,
            c.trigger.intensity,
            c.trigger.duration,
            c.trigger.refractory,
            Gate(
                c.trigger.gate,
                c.trigger.gate_oral_length,
                c.trigger.gate_anal_length,
                c.trigger.gate_delay,
                c.trigger.gate_duration,
            ),
            c.trigger.timing,
        ),
        reflex=Reflex(
            c.reflex.enabled,
            c.reflex.threshold,
            c.reflex.oral_length,
            c.reflex.anal_length,
            c.reflex.delay,
            c.reflex.refractory,
            c.reflex.excitation_intensity,
            c.reflex.excitation_duration,
            c.reflex.inhibition_conductance,
            c.reflex.inhibition_duration,
            c.reflex.kind,
            c.reflex.gain,
            c.reflex.stretch_range,
            c.reflex.summation,
            c.reflex.longitudinal_intensity,
            c.reflex.longitudinal_delay,
        ),
        inertia=c.wall.inertia or explicit,
        second_order=c.step.scheme == "bdf2",
        dt_wall=dt_wall,
        substeps=round(c.step.whole / c.step.conduction),
        exact_kinetics=c.solver.exact_kinetics,
        tolerance=c.solver.residual_tolerance,
        gap_tolerance=c.solver.penetration_tolerance * c.pellet.radius,
        max_newton=c.solver.max_newton,
        max_halvings=c.solver.max_halvings,
        start_position=c.pellet.start_gap + shape.oral,
        free_radius=like.free_radius if like is not None else np.full(grid.n_z_wall + 1, c.wall.radius),
        surface=SurfaceConstants(
            c.wall.shear_viscosity, c.wall.bending_stiffness_around, c.wall.bending_viscosity_around, c.wall.foundation
        ),
        sideways_friction=c.pellet.sideways_friction if c.pellet.sideways == "free" else None,
        surface_tolerance=c.solver.surface_tolerance,
        mixed_newton=c.solver.surface_newton == "mixed",
        coupled_modes=c.solver.surface_modes,
        friction=friction,
        explicit=_explicit(c),
        stimuli_longitudinal=like.stimuli_longitudinal if like and same("stimuli") else _listed(c, "longitudinal"),
        stimuli_circular=like.stimuli_circular if like and same("stimuli") else _listed(c, "circular"),
        network=like.network if like and same("network", "parts") else _network(c, grid),
        binding=binding,
        control=StepControl(c.step.tolerance, c.step.halvings) if c.step.control == "error" else None,
        reconstructs=c.grid.exchange == "reconstructed" and not explicit and c.grid.n_theta == 1,
        elliptic=Elliptic(c.solver.elliptic_tolerance, c.tissue.bidomain == "pseudo"),
    )


class Reach(NamedTuple):
    """Between which the pellet's centre stays [cm], Eq. (60)."""

    lowest: float
    highest: float


def _reach(c: Configuration, shape: PelletShape) -> Reach:
    """Between closed ends, or at its start alone for a pellet that is held."""
    if c.pellet.held:
        start = c.pellet.start_gap + shape.oral
        return Reach(start, start)
    return Reach(
        shape.oral if c.wall.oral_end == "closed" else -math.inf,
        c.wall.span - shape.anal if c.wall.anal_end == "closed" else math.inf,
    )


def _resistance(c: Configuration, shape: PelletShape) -> Resistance:
    """What a string pulls the pellet back with, and how dry friction falls with speed."""
    most = {"none": 0.0, "weight": c.pellet.load_weight, "spring": math.inf}[c.pellet.load]
    stiffness = c.pellet.load_stiffness if c.pellet.load != "none" else 0.0
    start = c.pellet.start_gap + shape.oral
    return Resistance(most, stiffness, start, c.pellet.fast_friction_share, c.pellet.friction_fall_speed)


def _fitting_shape(c: Configuration, binding: Binding) -> PelletShape:
    """The pellet's shape. Raises ConfigurationError where it is longer than the tube; a sphere is refused before."""
    shape = shape_of(c, binding)
    needed = shape.oral + shape.anal + c.pellet.start_gap
    if c.pellet.enabled and needed >= c.wall.span:
        raise ConfigurationError(
            f"wall.length = {c.wall.length} cm: the {shape.name} and its gap take {needed:.6g} cm (its length and "
            f"pellet.start_gap); use a tube longer than {needed:.6g} cm or a smaller pellet"
        )
    return shape


def _listed(c: Configuration, layer: str) -> Listed:
    """Pulses of the stimuli of a layer at listed times."""
    own = [one for one in c.stimuli if one.layer == layer]
    return listed(
        Pulse(
            one.onset,
            one.onset + one.duration,
            one.low,
            one.high,
            one.strength,
            to_internal(one.angle, "deg"),
            to_internal(one.sector, "deg"),
        )
        for one in own
    )


def _explicit(c: Configuration) -> ExplicitScheme | None:
    if c.solver.integrator != "explicit":
        return None
    micro = math.ceil(c.step.conduction / c.step.explicit * (1.0 - 1e-9)) if c.step.explicit > 0.0 else 0
    predicted = c.solver.explicit_damping == "predicted"
    return ExplicitScheme(micro, c.solver.explicit_safety, predicted, c.solver.contact_stiffness)


def _grid(c: Configuration) -> Grid:
    g = c.grid
    columns = g.wall_columns, g.conduction_columns, g.n_theta
    return Grid(c.wall.length, g.n_z, g.n_z_wall, *columns, slack=c.wall.slack_length)


def cell_constants(c: Configuration, rate: float) -> CellConstants:
    """Constants of the cell model running at `rate` times its own clock."""
    return CellConstants(
        calcium_reversal=c.cell.calcium_reversal,
        potassium_reversal=c.cell.potassium_reversal,
        chloride_reversal=c.cell.chloride_reversal,
        calcium_half_saturation=c.cell.calcium_half_saturation,
        calcium_rate=c.cell.calcium_rate,
        calcium_influx=c.cell.calcium_influx,
        calcium_entry_potential=c.cell.calcium_entry_potential,
        gate_time_factor=c.cell.gate_time_factor,
        slow_gate_time=c.cell.slow_gate_time,
        capacitance=c.tissue.capacitance,
        kinetics_rate=rate,
    )


def warmed(c: Configuration, per_ten: float) -> float:
    """Factor of the tissue's temperature on what changes by `per_ten` for every 10 K, Eq. (126); 1 without warming."""
    return float(per_ten ** (c.tissue.warming / 10.0))


def diffusivity(c: Configuration, layer: LayerConfiguration, capacitance: float) -> float:
    """Diffusivity of a layer along z at stretch 1 [cm^2/s]: M_vs g_i g_o / ((g_i + g_o) C_m), Eqs. (6), (11)."""
    inner, outer = layer.intracellular_axial, layer.extracellular_axial
    series = layer.conductivity_scale * inner * outer / (inner + outer)
    return 1e3 * c.tissue.volume_to_surface * series / capacitance


def _conductances(layer: LayerConfiguration, cells: int) -> np.ndarray:
    """Conductances of Plant's cells [mS/cm^2], (5, cells)."""
    return np.repeat(np.array([[getattr(layer, name)] for name in CHANNELS], dtype=float), cells, axis=1)


def _network(c: Configuration, grid: Grid) -> Network | None:
    if not c.network.enabled:
        return None
    n = c.network
    cell, constants, channels = cell_of_layer(c, "network")
    sheet = Layer(
        conductances=_by_cells(c, "network", cell, channels, grid),
        diffusivity=n.diffusivity,
        conductivities=Conductivities(1.0, 1.0, 1.0, 1.0),
        conducts=n.diffusivity > 0.0,
        force_factor=0.0,
        threshold=math.inf,
        conductivity=_factors(c, "network", "conductivity", grid, at=0.5 * (grid.cells[1:] + grid.cells[:-1])),
        conductivity_around=_factors(c, "network", "conductivity", grid, turned=0.5),
        constants=constants,
        cell=cell,
    )
    return Network(sheet, n.coupling_longitudinal, n.coupling_circular, n.load, n.head_start, n.lag)


def _by_cells(c: Configuration, name: str, cell: Cell, channels: np.ndarray, grid: Grid) -> np.ndarray:
    """Conductances of all cells of a layer with the factors of its regions, (channels, n_cells)."""
    conductances = np.repeat(channels[:, None], grid.n_z * grid.n_theta_conduction, axis=1)
    for channel, row in zip(cell.channels, conductances, strict=True):
        row *= np.ravel(_factors(c, name, channel, grid))
    return conductances


def cell_of_layer(c: Configuration, name: str) -> tuple[Cell, Any, np.ndarray]:
    """Cell model of a layer, its constants, and its conductances under drugs [mS/cm^2], (channels,), before regions."""
    chosen = c.cell_of(name)
    if chosen == PLANT:
        layer = c.longitudinal if name == "network" else getattr(c, name)
        rate = c.tissue.kinetics_rate * warmed(c, c.tissue.q10_kinetics)
        return SHIPPED_CELL, cell_constants(c, rate), _drugged(c, PLANT, _conductances(layer, 1)[:, 0])
    part = find("cell", chosen)
    cell = described(part.name, part.file)
    numbers = c.part_numbers(name, part)
    numbers = numbers | {"kinetics_rate": numbers["kinetics_rate"] * warmed(c, c.tissue.q10_kinetics)}
    constants = cell.constants(**{one.name: numbers[one.name] for one in part.parameters})
    return cell, constants, _drugged(c, chosen, np.array([numbers[one.name] for one in part.channels], dtype=float))


def _drugged(c: Configuration, cell: str, conductances: np.ndarray) -> np.ndarray:
    """Conductances of a cell model [mS/cm^2], (channels,), with what the drugs make of them."""
    if not c.drugs:
        return conductances
    names = CHANNELS if cell == PLANT else [one.name for one in find("cell", cell).channels]
    return conductances * factors(c.drugs, cell, names)


def _layer(c: Configuration, name: str, grid: Grid) -> Layer:
    layer: LayerConfiguration = getattr(c, name)
    cell, constants, channels = cell_of_layer(c, name)
    return Layer(
        conductances=_by_cells(c, name, cell, channels, grid),
        diffusivity=diffusivity(c, layer, constants.capacitance),
        conductivities=Conductivities(
            layer.intracellular_axial,
            layer.extracellular_axial,
            layer.intracellular_circumferential,
            layer.extracellular_circumferential,
        ),
        conducts=layer.conduction,
        force_factor=layer.active * warmed(c, c.tissue.q10_force) * _factors(c, name, "active", grid),
        threshold=layer.threshold,
        conductivity=_factors(c, name, "conductivity", grid, at=0.5 * (grid.cells[1:] + grid.cells[:-1])),
        conductivity_around=_factors(c, name, "conductivity", grid, turned=0.5),
        response=Response(
            *(_factors(c, name, key, grid) for key in ("pacemaker", "trigger", "excitation", "inhibition"))
        ),
        constants=constants,
        cell=cell,
        front_corrected=(
            c.tissue.front_correction == "measured" and cell is SHIPPED_CELL and c.solver.integrator == "implicit"
        ),
        **muscle_of_layer(c, name)._asdict(),
    )


def _factors(
    c: Configuration, layer: str, quantity: str, grid: Grid, at: Floats | None = None, turned: float = 0.0
) -> Floats | float:
    """What the regions make of a quantity at the cells, or at other places: (n_z, n_theta), or 1 without any.

    at: places along z [cm]; turned: how many columns further around.
    """
    if not c.regions:
        return 1.0
    places = grid.cells if at is None else at
    angles = grid.cell_columns + turned * 2.0 * np.pi / grid.n_theta_conduction
    field = factor_field(c.regions, layer, quantity, places, angles, c.wall.radius)
    return 1.0 if field is None else field


def _wall(c: Configuration, grid: Grid, binding: Binding) -> WallConstants:
    w = c.wall
    return WallConstants(
        radius=w.radius,
        element_size=grid.element_size,
        viscosity=w.viscosity,
        surface_density=to_internal(w.surface_density, "mg/cm^2"),
        bending_stiffness=w.bending_stiffness,
        bending_viscosity=w.bending_viscosity,
        slack_blend=w.slack_blend,
        slack_slope=w.slack_slope,
        fold_stretch=w.fold_stretch,
        fold_tension=w.fold_tension,
        published=w.tension == "published",
        passive=passive_constants(c, binding),
        longitudinal=active_constants(c, "longitudinal", binding),
        circular=active_constants(c, "circular", binding),
    )


def _pacemaker_cell(c: Configuration) -> PacemakerCell | None:
    if c.pacemaker.kind != "cell":
        return None
    conductances = _conductances(c.longitudinal, 1)
    conductances[CHANNELS.index("slow_calcium"), 0] = c.pacemaker.cell_slow_calcium
    conductances[:, 0] = _drugged(c, PLANT, conductances[:, 0])
    constants = cell_constants(c, c.pacemaker.cell_rate)
    angle, sector = to_internal(c.pacemaker.angle, "deg"), to_internal(c.pacemaker.angular_width, "deg")
    p = c.pacemaker
    return PacemakerCell(constants, conductances, p.cell_coupling, p.width, p.place, angle, sector)


def _sources(c: Configuration) -> tuple[Source, ...]:
    """The pacemaker, with the circular layer where that follows its pulses, and the rings."""
    p, r = c.pacemaker, c.rings
    sources: list[Source] = []
    if p.kind in ("pulse", "periodic"):
        late = c.trigger.delay if c.trigger.rule == "pacemaker" else 0.0
        where = (p.place, p.place + p.width, to_internal(p.angle, "deg"), to_internal(p.angular_width, "deg"))
        outlets = [Outlet("longitudinal", max(0.0, -late), p.duration, p.intensity, *where)]
        if c.trigger.rule == "pacemaker":
            outlets.append(Outlet("circular", max(0.0, late), c.trigger.duration, c.trigger.intensity, *where))
        sources.append(Source(p.onset, p.period, 1 if p.kind == "pulse" else p.count, tuple(outlets)))
    if r.enabled:
        rings = [
            Outlet("circular", 0.0, r.duration, r.intensity, z - 0.5 * r.width, z + 0.5 * r.width) for z in r.positions
        ]
        sources.append(Source(0.0, r.period, r.count, tuple(rings)))
    return tuple(sources)
