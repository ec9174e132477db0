"""The state before t = 0: cells at rest, tube inflated, pellet inserted by continuation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..control.pacemaker import waiting
from ..control.reflex import SILENT
from ..control.sequence import quiet
from ..errors import DivergenceError
from ..geometry.tube import lumen_volume
from ..numerics.roots import find_root
from ..pellet.friction import dry_friction
from ..tissue.cells import plant
from ..tissue.rest import RestState, rest_state, rest_states
from ..wall.passive import passive_tension
from .constants import LumenConstants, Step
from .equilibrium import CONVERGED, REASONS, solve_equilibrium
from .model import Layer, Model
from .state import PelletState, SheetState, State, WallState

Floats = NDArray[np.float64]

END_LAYER = 0.3
"""Length over which the first guess of the inflated tube leaves its clamped ends [cm]."""
GENTLE_PRESSURE = 20.0
"""Pressure at which inflation begins [mN/cm^2], unless p0 is lower."""


def initial_state(model: Model) -> tuple[Model, State, list[str]]:
    """The model completed with V0 and the pellet-free radius, its state before t = 0, and remarks for the user.

    Raises DivergenceError if the tube cannot be inflated or the pellet not be inserted.
    """
    sheets, remarks = _resting_sheets(model)
    free, position, contact, force = _inflate_and_insert(model)
    rho, zeta = np.ascontiguousarray(position[:, 0]), np.ascontiguousarray(position[:, 1])
    volume = lumen_volume(rho, zeta) - (model.pellet.volume if model.pellet.present else 0.0)
    complete = replace(model, free_radius=free, lumen=model.lumen._replace(reference_volume=volume))
    pellet = PelletState(model.start_position, 0.0, force, _holding(complete, contact, position))
    return complete, _at_rest(model, sheets, rho, zeta, contact, pellet), remarks


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
    )


def _holding(model: Model, contact: Floats, position: Floats) -> float:
    """Dry friction [mN] that holds the resting pellet, Eqs. (50) and (51)."""
    rho, axial = position[:, 0], position[:, 1] - model.start_position
    area = 2.0 * np.pi * model.wall.radius * model.wall.element_size
    pressing = area * float((contact * rho / np.hypot(rho, axial)).sum())
    return dry_friction(model.pellet.dry, model.friction, pressing, True)


def _resting_sheets(model: Model) -> tuple[tuple[SheetState, SheetState], list[str]]:
    longitudinal, remarks = _resting_sheet(model, model.longitudinal, "longitudinal")
    circular, more = _resting_sheet(model, model.circular, "circular")
    return (longitudinal, circular), [*remarks, *more]


def _resting_sheet(model: Model, layer: Layer, name: str) -> tuple[SheetState, list[str]]:
    shape = (model.grid.n_z, model.grid.n_theta_conduction)
    potential, gates = np.empty(shape).ravel(), np.empty((4, shape[0] * shape[1]))
    remarks = []
    patterns, which = np.unique(layer.conductances, axis=1, return_inverse=True)
    states = rest_states(patterns, model.cell, model.tables[0], model.exact_kinetics)
    kinds = np.ravel(which)
    potential[:] = np.array([rest.potential for rest in states])[kinds]
    gates[:] = np.array([rest.gates for rest in states]).T[:, kinds]
    restless = [k for k, rest in enumerate(states) if not rest.stable]
    if restless:
        k = restless[0]
        some = f" in {np.isin(kinds, restless).mean():.0%} of its cells, first" if len(states) > 1 else ""
        remarks.append(
            f"{name} layer: no stable rest{some} with slow_calcium = {patterns[plant.SLOW, k]:g} mS/cm^2 (steady state "
            f"at {states[k].potential:.2f} mV is unstable); the tissue starts there and will oscillate by itself"
        )
    unset = np.full(shape, np.nan)
    return SheetState(potential.reshape(shape), gates.reshape(4, *shape), unset, unset.copy()), remarks


def _pacemaker_sheet(model: Model) -> SheetState:
    unset = np.full((1, 1), np.nan)
    if model.pacemaker_cell is None:
        return SheetState(np.zeros((1, 1)), np.zeros((4, 1, 1)), unset, unset.copy())
    cell = model.pacemaker_cell
    rest: RestState = rest_state(cell.conductances[:, 0], cell.constants, model.pacemaker_tables[0])
    # A bursting cell stays on its unstable steady state for ever if put exactly on it.
    gates = np.array(rest.gates).reshape(4, 1, 1)
    return SheetState(np.full((1, 1), rest.potential + 1.0), gates, unset, unset.copy())


def _inflate_and_insert(model: Model) -> tuple[Floats, Floats, Floats, float]:
    """(pellet-free radius, positions (n, 2), contact densities, axial force) of the passive tube at p0."""
    wall, nodes = model.wall, model.grid.nodes
    n = nodes.size
    pressure = model.lumen.pressure
    rho, zeta, contact = np.full(n, wall.radius), nodes.copy(), np.zeros(n)
    scalars = np.array([pressure, model.start_position, 0.0])
    fixed, none, still = np.zeros((2, n)), np.zeros(n), np.zeros((2, n))
    passive = np.zeros(2 * n - 2)

    def settle(radius: float, constant: float = pressure) -> int:
        """Equilibrium with a pellet of this radius held in place (none if 0) at constant pressure."""
        scalars[0] = constant
        pellet = model.pellet._replace(present=radius > 0.0, radius=max(radius, 1e-3), frame=0.0, volume=0.0)
        step = Step(0.0, False, model.start_position, 0.0)
        lumen = LumenConstants(constant, 1.0, 0.0)
        code = solve_equilibrium(
            rho,
            zeta,
            contact,
            scalars,
            fixed,
            still,
            np.ones(n - 1),
            np.ones(n),
            passive,
            passive,
            none,
            step,
            wall,
            pellet,
            lumen,
            model.tolerance,
            model.gap_tolerance,
            100,
        )[0]
        return code

    arrays = (rho, zeta, contact, scalars)
    if pressure > 0.0:
        gentle = min(pressure, GENTLE_PRESSURE)
        rho += (_inflated_radius(model, gentle) - wall.radius) * (
            1.0 - np.exp(-nodes / END_LAYER) - np.exp(-(nodes[-1] - nodes) / END_LAYER)
        )
        rho[0] = rho[-1] = wall.radius
        reached, code = _continue(lambda value: settle(0.0, value), arrays, gentle, pressure, gentle)
        if reached < pressure:
            raise DivergenceError(
                f"the tube finds no equilibrium beyond {reached / 100.0:.4g} kPa on the way to lumen.pressure = "
                f"{pressure / 100.0:g} kPa ({REASONS[code]}); lower the pressure or refine grid.n_z_wall"
            )
    free = rho.copy()
    if model.pellet.present:
        target = model.pellet.radius
        start = min(target, float(free.max()) - 1e-3)
        reached, code = _continue(settle, arrays, start, target, 0.02)
        if reached < target:
            raise DivergenceError(
                f"the tube cannot hold this pellet: no equilibrium beyond a radius of {max(reached, 0.0):.4g} cm on "
                f"the way to pellet.radius = {target:g} cm ({REASONS[code]}); use a smaller pellet or a wider tube"
            )
    return free, np.stack([rho, zeta], axis=1), contact, float(scalars[2])


def _inflated_radius(model: Model, pressure: float) -> float:
    """Radius of the long passive tube at a pressure and longitudinal stretch 1: T_c = p rho (Laplace), Eq. (1)."""
    wall = model.wall

    def excess(stretch: float) -> float:
        return float(passive_tension(1.0, stretch, wall.passive)[1] - pressure * wall.radius * stretch)

    high = 1.0
    while excess(high) <= 0.0:
        high += 0.05
        if high > 4.0:
            raise DivergenceError(
                f"no inflated tube at lumen.pressure = {model.lumen.pressure / 100.0:g} kPa: the passive wall cannot "
                "hold it; lower the pressure"
            )
    return wall.radius * find_root(excess, 1.0, high)


def _continue(
    settle: Callable[[float], int], arrays: tuple[Floats, ...], start: float, target: float, step: float
) -> tuple[float, int]:
    """Settle at `start`, then at growing values up to `target`, in steps that shrink where they fail.

    arrays: what `settle` works on, put back after a failure. Returns the value reached, minus infinity if not even
    the start was, and the last code of the solver.
    """
    least = 1e-4 * step
    kept = [array.copy() for array in arrays]
    reached, value = -np.inf, start
    while True:
        code = settle(value)
        if code == CONVERGED:
            kept = [array.copy() for array in arrays]
            reached = value
            if reached >= target:
                return target, code
            value = min(target, reached + step)
            step *= 1.2
            continue
        for array, good in zip(arrays, kept, strict=True):
            array[:] = good
        step *= 0.4
        if not np.isfinite(reached) or step < least:
            return reached, code
        value = min(target, reached + step)
