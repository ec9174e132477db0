"""The state before t = 0: cells at rest, tube inflated, pellet inserted by continuation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..control.pacemaker import waiting
from ..control.reflex import SILENT
from ..control.sequence import quiet
from ..errors import ConfigurationError
from ..geometry.tube import lumen_volume
from ..pellet.body import require_shape
from ..pellet.friction import Nodes, dry_friction, share_out
from ..tissue.activation import SHIPPED_ACTIVATION
from ..tissue.cell import SHIPPED_CELL
from ..tissue.records import Brought, SheetArrays, Steps
from ..tissue.steady import NoRestError, RestState
from .inflation import inflate_and_insert
from .model import ACTIVATION_LEVEL, Layer, Model, Network, explicit_stages
from .muscle import drive_of_cells, resting_muscle
from .state import PelletState, SheetState, State, WallState

Floats = NDArray[np.float64]

RESTING_TONE = 0.5
"""Drive at rest of which a run says something [mV]: about a hundredth of what a spike gives."""


def initial_state(model: Model) -> tuple[Model, State, list[str]]:
    """The model completed with V0 and the pellet-free radius, its state before t = 0, and remarks for the user.

    Raises DivergenceError if the tube cannot be inflated or the pellet not be inserted, with the cause.
    """
    require_shape(model.pellet)
    sheets, remarks = _resting_sheets(model)
    tube, free, more = inflate_and_insert(model)
    rho, zeta, contact, force = tube.rho, tube.zeta, tube.contact, float(tube.scalars[2])
    volume = lumen_volume(rho, zeta) - (model.pellet.volume if model.pellet.present else 0.0)
    complete = replace(model, free_radius=free, lumen=model.lumen._replace(reference_volume=volume))
    pellet = PelletState(model.start_position, 0.0, force, holding(complete, contact, rho, zeta))
    return complete, _at_rest(model, sheets, rho, zeta, contact, pellet), [*remarks, *more]


def straight_state(model: Model) -> State:
    """The undeformed tube around a pellet that it does not touch, cells at rest: no equilibrium, at no cost."""
    nodes = model.grid.nodes
    pellet = PelletState(model.start_position, 0.0, 0.0, 0.0)
    radius = np.full(nodes.size, model.wall.radius)
    return _at_rest(model, _resting_sheets(model)[0], radius, nodes, np.zeros(nodes.size), pellet)


def _at_rest(
    model: Model, sheets: tuple[SheetState, SheetState], rho: Floats, zeta: Floats, contact: Floats, pellet: PelletState
) -> State:
    shape = (model.grid.n_z_wall + 1, model.grid.n_theta)
    nodes = np.zeros((*shape, 3))
    nodes[:, :, 0], nodes[:, :, 2] = rho[:, None], zeta[:, None]
    nodes[:, :, 1] = 2.0 * np.pi * np.arange(shape[1]) / shape[1]
    still = np.zeros_like(nodes)
    wall = WallState(
        position=nodes,
        position_before=nodes,
        velocity=still,
        velocity_before=still,
        contact=np.repeat(contact[:, None], shape[1], axis=1),
        stretch_rate=np.zeros((shape[0] - 1, shape[1])),
        hoop_rate=np.zeros(shape),
        drive=np.zeros((2, 2 * model.grid.n_z_wall, shape[1])),
        step_before=0.0,
    )
    return State(
        step=0,
        longitudinal=sheets[0],
        circular=sheets[1],
        pacemaker=_pacemaker_sheet(model),
        wall=wall,
        pellet=pellet,
        pressure=model.lumen.pressure,
        trigger=quiet((model.grid.n_z, model.grid.n_theta_conduction)),
        reflex=SILENT,
        sources=tuple(waiting(source) for source in model.sources),
        network=None if model.network is None else _network_sheet(model, model.network),
    )


def holding(model: Model, contact: Floats, rho: Floats, zeta: Floats) -> float:
    """Dry friction [mN] that holds the resting pellet, Eqs. (50) and (51)."""
    area = 2.0 * np.pi * model.wall.radius * model.wall.element_size
    places = np.zeros((rho.size, 1, 3))
    places[:, 0, 0], places[:, 0, 2] = rho, zeta
    shares = np.empty((rho.size, 1))
    pressing = area * share_out(
        Nodes(contact[:, None], places, area), model.start_position, model.pellet.shape, True, shares
    )
    return dry_friction(model.pellet.dry, model.friction, pressing, True)


def _resting_sheets(model: Model) -> tuple[tuple[SheetState, SheetState], list[str]]:
    longitudinal, remarks = _resting_sheet(model, model.longitudinal, "longitudinal")
    circular, more = _resting_sheet(model, model.circular, "circular")
    return (longitudinal, circular), [*remarks, *more]


def _resting_sheet(model: Model, layer: Layer, name: str) -> tuple[SheetState, list[str]]:
    shape = (model.grid.n_z, model.grid.n_theta_conduction)
    potential, gates = np.empty(shape).ravel(), np.empty((len(layer.cell.states), shape[0] * shape[1]))
    remarks = []
    patterns, which = np.unique(layer.conductances, axis=1, return_inverse=True)
    try:
        table = layer.tables(model.dt_cell)[0]
        states = layer.cell.rest.rest_states(patterns, layer.constants, table, model.exact_kinetics)
    except NoRestError as error:
        raise ConfigurationError(f"{name} layer: the cell has no resting potential: {error}") from None
    kinds = np.ravel(which)
    potential[:] = np.array([rest.potential for rest in states])[kinds]
    gates[:] = np.array([rest.gates for rest in states]).T[:, kinds]
    restless = [k for k, rest in enumerate(states) if not rest.stable]
    if restless:
        k = restless[0]
        some = f" in {np.isin(kinds, restless).mean():.0%} of its cells, first" if len(states) > 1 else ""
        channels = ", ".join(
            f"{name} = {value:g}" for name, value in zip(layer.cell.channels, patterns[:, k], strict=True)
        )
        remarks.append(
            f"{name} layer: no stable rest{some} with {channels} mS/cm^2 (steady state at {states[k].potential:.2f} mV "
            "is unstable); the tissue starts there and will oscillate by itself"
        )
    highest = max((rest.potential for rest in states if rest.stable), default=-np.inf)  # the others do not rest there
    paper = layer.activation is SHIPPED_ACTIVATION
    if paper and highest > layer.threshold:
        remarks.append(
            f"{name} layer: its cells rest at up to {highest:.1f} mV, above {name}.threshold = {layer.threshold:g} mV; "
            "the muscle pulls from the start"
        )
    unset = np.full(shape, np.nan)
    resting = SheetState(potential.reshape(shape), gates.reshape(-1, *shape), unset, unset.copy())
    sheet = resting_muscle(layer, resting)
    tone = 0.0 if paper else float(drive_of_cells(layer, sheet).max())
    if tone > RESTING_TONE:
        remarks.append(
            f"{name} layer: by {name}.activation = {layer.activation.name} its muscle has a drive of up to {tone:.2g} "
            "mV while its cells rest; it pulls from the first step on"
        )
    return sheet, remarks


RUNNING = 0.05
"""Length of a stretch of time for which the network runs before the run [s]."""


def _network_sheet(model: Model, network: Network) -> SheetState:
    """The network's cells, each for itself, after its head start; without one as their source begins, or at rest."""
    sheet = _resting_sheet(model, network.sheet, "network")[0]
    layer, shape = network.sheet, sheet.potential.shape
    potential, gates = sheet.potential.ravel().copy(), sheet.gates.reshape(len(sheet.gates), -1).copy()
    stages = explicit_stages(
        layer.leakiness * layer.constants.kinetics_rate / layer.constants.capacitance, model.dt_cell
    )
    steps = max(1, round(1e3 * RUNNING / model.dt_cell))
    length = 1e-3 * steps * model.dt_cell
    for k in range(round(network.head_start / length)):
        # Those further on begin later.
        count = shape[1] * int(np.count_nonzero(network.lag * model.grid.cells <= k * length + 1e-9))
        v, states, none = potential[:count].copy(), gates[:, :count].copy(), np.zeros(count)
        layer.cell.advance_sheet(
            SheetArrays(v, states, np.full(count, np.nan), np.full(count, np.nan)),
            layer.conductances[:, :count].copy(),
            np.zeros(0),
            Brought(none, none),
            Steps(0.0, model.dt_cell, steps, shape[1], model.exact_kinetics, ACTIVATION_LEVEL),
            stages,
            layer.tables(model.dt_cell),
            layer.constants,
        )
        potential[:count], gates[:, :count] = v, states
    return replace(sheet, potential=potential.reshape(shape), gates=gates.reshape(-1, *shape))


def _pacemaker_sheet(model: Model) -> SheetState:
    unset = np.full((1, 1), np.nan)
    if model.pacemaker_cell is None:
        return SheetState(np.zeros((1, 1)), np.zeros((4, 1, 1)), unset, unset.copy())
    cell = model.pacemaker_cell
    try:
        table = SHIPPED_CELL.tables(model.dt_cell, cell.constants)[0]
        rest: RestState = SHIPPED_CELL.rest.rest_state(cell.conductances[:, 0], cell.constants, table)
    except NoRestError as error:
        raise ConfigurationError(f"pacemaker: the cell has no resting potential: {error}") from None
    # A bursting cell stays on its unstable steady state for ever if put exactly on it.
    gates = np.array(rest.gates).reshape(4, 1, 1)
    return SheetState(np.full((1, 1), rest.potential + 1.0), gates, unset, unset.copy())
