"""The wall on the whole surface: columns of nodes around the ring."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...geometry.surface import equivalent_radius
from ...tissue.bidomain import surface_operator
from ...tissue.front_correction import raised_resistance
from ...tissue.surface import SurfaceOperator, SurfaceSizes
from ..balance import Work, momentum_from, work_on_surface
from ..bookkeeping import ContactSummary
from ..exchange import active_force_at
from ..fields import axial_tension_of_elements, end_reactions
from ..model import FrontLaw, Layer, Model
from ..muscle import drive_of_cells
from ..ranges import stretches_outside
from ..scheme import Ahead, Conduction, Solved, StepSummary
from ..state import PelletState, SheetState, State, WallState
from ..surface_fields import Stretches, surface_contact, surface_stretches
from ..surface_step import try_surface_wall

Floats = NDArray[np.float64]


def muscle_drive(model: Model, layer: Layer, sheet: SheetState) -> Floats:
    """Force factor times drive [mV] of the half elements, Eqs. (19) and (33): one for each corner."""
    return model.grid.half_elements_of_cells(layer.force_factor * drive_of_cells(layer, sheet))


def stretches_ahead(model: Model, wall: WallState) -> Ahead:
    """Stretches of the edges along z and around in the middle of the coming step."""
    share = 0.5 * model.dt_wall / wall.step_before if wall.step_before > 0.0 else 0.0
    now, before = (surface_stretches(places, model.wall) for places in (wall.position, wall.position_before))
    axial, hoop = (np.maximum(new + share * (new - old), 0.5 * new) for new, old in zip(now, before, strict=True))
    return Ahead(axial, float(axial.min()), hoop)


def conduction(model: Model, layer: Layer, ahead: Ahead) -> Conduction:
    """The operator of a layer, with what its fluxes around the ring add to the rate."""
    if not layer.conducts:
        return Conduction(None)
    assert ahead.hoop is not None
    operator = _operator(model, layer, Stretches(ahead.axial, ahead.hoop))
    return Conduction(operator, operator.ring_rate)


def _operator(model: Model, layer: Layer, stretch: Stretches) -> SurfaceOperator:
    """Conduction of a layer on the wall of the middle of the step; what varies from place to place divides stretch."""
    grid = model.grid
    with np.errstate(divide="ignore"):  # where a region blocks conduction the resistance is infinite
        along = grid.elements_at_faces(stretch.axial) / layer.conductivity
        around = grid.nodes_at_ring_faces(stretch.hoop) / layer.conductivity_around
    sizes = SurfaceSizes(grid.cell_size, grid.column_width(model.wall.radius))
    along = _corrected(along, layer.front_law(sizes.axial, model.dt_cell))
    around = _corrected(around, layer.front_law(sizes.around, model.dt_cell, around=True))
    return surface_operator(layer.diffusivity, layer.conductivities, sizes, along, around, model.elliptic)


def _corrected(resistance: Floats, law: FrontLaw | None) -> Floats:
    return resistance if law is None else raised_resistance(resistance, law.cells_per_foot, law.table)


def solve_wall(
    model: Model, wall: WallState, pellet: PelletState, pressure: float, drive: Floats, dt: float
) -> tuple[int, Solved | None]:
    """One implicit step; None with the reason's code when it does not converge."""
    return try_surface_wall(model, wall, pellet, pressure, drive, dt, model.surface, model.sideways_friction)


def receptor_stretch(model: Model, wall: WallState) -> Floats | None:
    """Girth of the rings over the pellet-free one."""
    girth = surface_stretches(wall.position, model.wall).hoop.mean(axis=1)
    return np.asarray(girth * (model.wall.radius / model.free_radius))


def trigger_force(model: Model, sheet: SheetState, wall: WallState) -> Floats:
    """Active tension of the longitudinal layer at its cells [mN/cm]."""
    cells = np.empty_like(sheet.potential)
    driven, muscle = drive_of_cells(model.longitudinal, sheet), np.array(model.wall.longitudinal)
    stretch = model.grid.elements_at_cells(surface_stretches(wall.position, model.wall).axial)
    active_force_at(stretch, driven, muscle, cells)
    return cells


def trigger_tension(model: Model, wall: WallState) -> Floats:
    """Total longitudinal tension at the cells [mN/cm]."""
    return model.grid.elements_at_cells(axial_tension_of_elements(wall, model.wall))


def stretch_fault(model: Model, wall: WallState) -> str | None:
    """What is wrong with the stretches of the edges, with its place; None if they are in range.

    Of the edges: a wall that bows is longer than rho and zeta show, and its nodes may cross the tube's axis.
    """
    try:
        stretch, hoop = surface_stretches(wall.position, model.wall)
    except ValueError as error:
        return str(error)
    return stretches_outside(stretch, hoop, model.grid.nodes)


def work(model: Model, before: State, after: State) -> Work:
    """Trapezoidal work of every term between two states a step apart, Eq. (29)."""
    return work_on_surface(model, before, after)


def contact(model: Model, state: State) -> ContactSummary:
    """Numbers about the contact; the least radius is that of the circle with a ring's area."""
    wall = state.wall
    found = surface_contact(wall, state.pellet, model.pellet, model.wall)
    return ContactSummary(
        normal_force=found.normal_force,
        largest_pressure=found.largest_pressure,
        start=found.start,
        end=found.end,
        least_radius=float(equivalent_radius(wall.position).min()),
        smallest_gap=found.smallest_gap,
    )


def summary(model: Model, before: State, after: State) -> StepSummary:
    """Work, momentum, contact and end reactions."""
    ends = end_reactions(after.wall, model.wall, after.pressure)
    momentum = momentum_from(model, before, after, ends.anal - ends.oral)
    return StepSummary(work(model, before, after), momentum, contact(model, after), ends)
