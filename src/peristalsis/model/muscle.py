"""The muscle of a layer's cells: what drives it, and the states of its own that it has, Eqs. (19), (79)-(82)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..geometry.grid import SUB_CELLS, Grid
from ..numerics.transfer import average
from .model import Layer
from .state import SheetState

Floats = NDArray[np.float64]


def drive_of_cells(layer: Layer, sheet: SheetState) -> Floats:
    """Drive [mV] of the cells of a layer before any factor on its force, (n_z, n_theta)."""
    potential = sheet.potential.ravel()
    out = np.empty(potential.size)
    states = sheet.muscle.reshape(len(sheet.muscle), potential.size if len(sheet.muscle) else 0)
    layer.activation.kernels.drive_of_cells(
        potential, _calcium(layer, sheet), layer.calcium_scale, states, layer.activation_constants, out
    )
    return out.reshape(sheet.potential.shape)


def drive_of_sub_cells(layer: Layer, sheet: SheetState, grid: Grid) -> Floats:
    """Drive [mV] of the parts of the cells of a layer, (n_z * SUB_CELLS, n_theta), Eq. (86).

    Where the activation follows from the potential alone, it is that of the potential reconstructed within the cells.
    Calcium and states of muscle are known for whole cells: the parts of a cell then have the drive of the cell.
    """
    activation = layer.activation
    if activation.reads_calcium or activation.states:
        return np.repeat(drive_of_cells(layer, sheet), SUB_CELLS, axis=0)
    fine = np.empty((sheet.potential.shape[0] * SUB_CELLS, sheet.potential.shape[1]))
    average(grid.cells_to_sub_cells, sheet.potential, fine)
    potential, out = fine.ravel(), np.empty(fine.size)
    states = np.empty((0, fine.size))
    activation.kernels.drive_of_cells(
        potential, potential, layer.calcium_scale, states, layer.activation_constants, out
    )
    return out.reshape(fine.shape)


def resting_muscle(layer: Layer, sheet: SheetState) -> SheetState:
    """The sheet with the states of its muscle where they stay as long as its cells rest."""
    states = np.zeros((len(layer.activation.states), sheet.potential.size))
    if len(states):
        calcium = _calcium(layer, sheet)
        layer.activation.kernels.set_steady(calcium, layer.calcium_scale, layer.activation_constants, states)
    return replace(sheet, muscle=states.reshape(len(states), *sheet.potential.shape))


def advance_muscle(layer: Layer, before: SheetState, after: SheetState, dt: float) -> SheetState:
    """The sheet after a step of dt [s] with the states of its muscle after it too."""
    if not len(before.muscle):
        return after
    states = before.muscle.reshape(len(before.muscle), -1).copy()
    layer.activation.kernels.advance_states(
        _calcium(layer, before), _calcium(layer, after), layer.calcium_scale, dt, layer.activation_constants, states
    )
    return replace(after, muscle=states.reshape(before.muscle.shape))


def _calcium(layer: Layer, sheet: SheetState) -> Floats:
    """Calcium of the cells in the unit of their model, (n,); for an activation that reads none, anything."""
    return sheet.potential.ravel() if layer.calcium_state < 0 else sheet.gates[layer.calcium_state].ravel()
