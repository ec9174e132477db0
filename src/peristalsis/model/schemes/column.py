"""The axisymmetric wall: one column of nodes stands for the ring."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...numerics.compiled import compiled
from ...numerics.rates import rate_formula
from ...numerics.transfer import average, average_within
from ...tissue.front_correction import SPACING, correct_front
from ...wall.membrane import LARGEST_STRETCH, SMALLEST_STRETCH
from ..arrays import NewWall
from ..balance import Work, momentum_from, work_from
from ..bookkeeping import ContactSummary, StepNumbers, numbers_of_step, touch, wall_work
from ..constants import packed
from ..exchange import (
    active_force,
    active_force_at,
    drive_of_layer,
    level_elements,
    stretch_ahead,
    stretches_receptors,
)
from ..fields import axial_tension_of_elements, stretch_of_elements
from ..friction import dry_friction_now, viscous_friction_now
from ..model import Layer, Model
from ..muscle import drive_of_cells, drive_of_sub_cells
from ..problem import workspace
from ..ranges import stretches_outside
from ..scheme import Ahead, Conduction, Solved, StepSummary
from ..state import PelletState, SheetState, State, WallState
from ..verdicts import CONVERGED
from ..wall_step import Request, step_wall

Floats = NDArray[np.float64]


def muscle_drive(model: Model, layer: Layer, sheet: SheetState) -> Floats:
    """Force factor times drive [mV] of the half elements, Eqs. (19) and (33): one for each corner."""
    grid, out = model.grid, np.empty((2 * model.grid.n_z_wall, 1))
    if not model.reconstructs:
        drive_of_layer(*grid.cells_to_half_elements, drive_of_cells(layer, sheet), layer.force_of_cells, out)
        return out
    driven = drive_of_sub_cells(layer, sheet, grid)
    drive_of_layer(*grid.sub_cells_to_half_elements, driven, layer.force_of_sub_cells, out)
    if layer is model.longitudinal:
        # The stretch and its rate along the muscle belong to a whole element, and so does what pulls there.
        level_elements(out)
    return out


def stretches_ahead(model: Model, wall: WallState) -> Ahead:
    """Longitudinal stretch of the elements in the middle of the coming step."""
    share = 0.5 * model.dt_wall / wall.step_before if wall.step_before > 0.0 else 0.0
    stretch = np.empty_like(wall.stretch_rate)
    least = stretch_ahead(wall.position, wall.position_before, model.wall.element_size, share, stretch)
    return Ahead(stretch, least)


def conduction(model: Model, layer: Layer, ahead: Ahead) -> Conduction:
    """Coefficients along z at the inner faces, (n_z - 1, 1), or none of them where the layer does not conduct."""
    grid = model.grid
    found = np.empty((grid.n_z - 1 if layer.conducts else 0, 1))
    if layer.conducts:
        scale = layer.diffusivity * 1e-3 / (24.0 * grid.cell_size) ** 2
        if model.reconstructs:
            average_within(grid.element_averages_to_faces, ahead.axial, found)
        else:
            average(grid.elements_to_faces, ahead.axial, found)
        np.divide(scale, found, out=found)
        if not isinstance(layer.conductivity, float):
            found *= layer.conductivity
        law = layer.front_law(grid.cell_size, model.dt_cell)
        if law is not None:
            correct_front(law.cells_per_foot, SPACING, law.table, scale, found)
    return Conduction(found)


def solve_wall(
    model: Model, wall: WallState, pellet: PelletState, pressure: float, drive: Floats, dt: float
) -> tuple[int, Solved | None]:
    """One implicit step in one compiled call."""
    formula = rate_formula(dt, wall.step_before, model.second_order)
    request = Request(
        dt,
        wall.step_before,
        formula.older,
        formula.inverse,
        model.second_order,
        model.inertia,
        model.tolerance,
        model.gap_tolerance,
        model.max_newton,
        model.friction,
    )
    numbers = np.array(
        [
            pressure,
            pellet.position,
            pellet.velocity,
            pellet.axial_force,
            dry_friction_now(model, pellet),
            viscous_friction_now(model, pellet),
            pellet.slid,
        ],
        dtype=np.float64,
    )
    constants = packed(model.wall), packed(model.pellet), packed(model.lumen)
    like = (wall.position, wall.velocity, wall.contact, wall.stretch_rate, wall.hoop_rate)
    new = NewWall(*(np.empty_like(array) for array in like))
    tables = workspace(wall.position.shape[0])
    code, iterations, assemblies = step_wall(wall.arrays, drive, numbers, request, *constants, *tables, new)
    if code != CONVERGED:
        return code, None
    after = WallState(
        position=new.position,
        position_before=wall.position,
        velocity=new.velocity,
        velocity_before=wall.velocity,
        contact=new.contact,
        stretch_rate=new.stretch_rate,
        hoop_rate=new.hoop_rate,
        drive=drive,
        step_before=dt,
    )
    lumen_pressure, centre, speed, force, dry, viscous, slid = numbers.tolist()
    moved = PelletState(centre, 0.0, 0.0)
    if model.pellet.present:
        moved = PelletState(centre, speed, force, dry, viscous=viscous, slid=slid != 0.0)
    return code, Solved(after, moved, lumen_pressure, iterations, assemblies, 1)


def receptor_stretch(model: Model, wall: WallState) -> Floats | None:
    """Radius over the pellet-free one; None unless a node that touches the pellet is wider than the threshold."""
    if not stretches_receptors(wall.position, wall.contact, model.free_radius, model.reflex.threshold):
        return None
    return wall.position[:, 0, 0] / model.free_radius


def trigger_force(model: Model, sheet: SheetState, wall: WallState) -> Floats:
    """Active tension of the longitudinal layer at its cells [mN/cm]."""
    cells = np.empty_like(sheet.potential)
    driven, muscle = drive_of_cells(model.longitudinal, sheet), np.array(model.wall.longitudinal)
    size = model.wall.element_size
    if model.reconstructs:
        average_within(model.grid.element_averages_to_cells, stretch_of_elements(wall.position, size), cells)
        active_force_at(cells, driven, muscle, cells)
        return cells
    active_force(*model.grid.elements_to_cells, wall.position, size, driven, muscle, cells)
    return cells


def trigger_tension(model: Model, wall: WallState) -> Floats:
    """Total longitudinal tension at the cells [mN/cm]."""
    cells = np.empty((model.grid.n_z, 1))
    average(model.grid.elements_to_cells, axial_tension_of_elements(wall, model.wall), cells)
    return cells


def stretch_fault(model: Model, wall: WallState) -> str | None:
    """What is wrong with the stretches of a wall, with its place; None if they are in range."""
    if _within(wall.position, model.wall.element_size, model.wall.radius):
        return None
    stretch = stretch_of_elements(wall.position, model.wall.element_size)
    hoop = wall.position[:, :, 0] / model.wall.radius
    return stretches_outside(stretch, hoop, model.grid.nodes)


@compiled
def _within(position: np.ndarray, element_size: float, radius: float) -> bool:
    """Whether all stretches of a wall of one column, (n, 1, 3), are in range."""
    n = position.shape[0]
    good = 0
    for i in range(n):
        hoop = position[i, 0, 0] / radius
        good += 1 if (hoop > SMALLEST_STRETCH) & (hoop < LARGEST_STRETCH) else 0
    for e in range(n - 1):
        dr, dz = position[e + 1, 0, 0] - position[e, 0, 0], position[e + 1, 0, 2] - position[e, 0, 2]
        stretch = math.sqrt(dr * dr + dz * dz) / element_size
        good += 1 if (stretch > SMALLEST_STRETCH) & (stretch < LARGEST_STRETCH) else 0
    return good == 2 * n - 1


def work(model: Model, before: State, after: State) -> Work:
    """Trapezoidal work of every term between two states a step apart, Eq. (29)."""
    return work_from(model, before, after, wall_work(before.wall.arrays, after.wall.arrays, packed(model.wall)))


def contact(model: Model, state: State) -> ContactSummary:
    """Numbers about the contact, in one compiled pass."""
    found: ContactSummary = touch(state.wall.arrays, state.pellet.position, packed(model.pellet), packed(model.wall))
    return found


def summary(model: Model, before: State, after: State) -> StepSummary:
    """Work, momentum, contact and end reactions, in one compiled call."""
    numbers: StepNumbers = numbers_of_step(
        before.wall.arrays,
        after.wall.arrays,
        after.pressure,
        after.pellet.position,
        packed(model.pellet),
        packed(model.wall),
    )
    momentum = momentum_from(model, before, after, numbers.ends.anal - numbers.ends.oral)
    return StepSummary(work_from(model, before, after, numbers.work), momentum, numbers.contact, numbers.ends)
