"""The wall on the columns on which it is shown, where it is solved on fewer (`grid.n_theta_wall`), Eq. (98)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry.grid import Grid
from ..geometry.surface import from_frames, rates_from_frames, rates_to_frames, to_frames
from ..model.state import WallState
from ..numerics.transfer import Overlap, average_around, trigonometric

Floats = NDArray[np.float64]


def shown_wall(grid: Grid, wall: WallState) -> WallState:
    """A wall on `grid.n_theta_shown` columns: places and velocities by their Fourier series, all else linearly.

    Linear between columns contact and drive stay positive. The integral around each ring is kept by both, so the
    contact forces add up to those on the pellet.
    """
    columns = grid.n_theta_shown
    if columns == grid.n_theta:
        return wall

    def moving(position: Floats, velocity: Floats) -> tuple[Floats, Floats]:
        places = trigonometric(to_frames(position), columns)
        rates = trigonometric(rates_to_frames(position, velocity), columns)
        return from_frames(places), rates_from_frames(places, rates)

    def linear(weights: Overlap, field: Floats) -> Floats:
        rows = np.ascontiguousarray(field).reshape(-1, grid.n_theta)
        fine = np.empty((len(rows), columns))
        average_around(weights, rows, fine)
        return fine.reshape(*field.shape[:-1], columns)

    position, velocity = moving(wall.position, wall.velocity)
    position_before, velocity_before = moving(wall.position_before, wall.velocity_before)
    return WallState(
        position=position,
        position_before=position_before,
        velocity=velocity,
        velocity_before=velocity_before,
        contact=linear(grid.columns_to_shown, wall.contact),
        stretch_rate=linear(grid.columns_to_shown, wall.stretch_rate),
        hoop_rate=linear(grid.faces_to_shown, wall.hoop_rate),
        drive=linear(grid.columns_to_shown, wall.drive),
        step_before=wall.step_before,
    )
