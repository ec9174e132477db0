"""The sheets over a step: both layers, the network of interstitial cells, the pacemaker cell, Eqs. (30), (31)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import DivergenceError
from ..tissue.bidomain import EllipticError
from ..tissue.cell import SHIPPED_CELL
from ..tissue.records import Brought, SheetArrays, Steps
from .model import ACTIVATION_LEVEL, Layer, Model, explicit_stages
from .muscle import advance_muscle
from .out_of_range import Tissue, why_out_of_range
from .scheme import Ahead, Conduction
from .schemes.choice import scheme_of
from .state import SheetState, State
from .stimulation import Stimuli, Stimulus

Floats = NDArray[np.float64]

APART = Conduction(np.empty((0, 1)))
"""Cells that do not conduct."""


def advance_tissue(
    model: Model, state: State, stimuli: Stimuli, start: float
) -> tuple[SheetState, SheetState, SheetState | None, Floats]:
    """Both layers and the network after a step, and the drive of the wall."""
    scheme = scheme_of(model)
    ahead = scheme.stretches_ahead(model, state.wall)
    longitudinal, circular = (
        advance_muscle(layer, sheet, advance_layer(model, name, layer, sheet, ahead, stimulus, start), model.dt_wall)
        for name, layer, sheet, stimulus in (
            ("longitudinal", model.longitudinal, state.longitudinal, stimuli.longitudinal),
            ("circular", model.circular, state.circular, stimuli.circular),
        )
    )
    network = None
    if model.network is not None and state.network is not None:
        network = advance_layer(model, "network", model.network.sheet, state.network, ahead, stimuli.network, start)
    drive = np.empty_like(state.wall.drive)
    drive[0] = scheme.muscle_drive(model, model.longitudinal, longitudinal)
    drive[1] = scheme.muscle_drive(model, model.circular, circular)
    return longitudinal, circular, network, drive


def advance_layer(
    model: Model, name: str, layer: Layer, sheet: SheetState, ahead: Ahead, stimulus: Stimulus, start: float
) -> SheetState:
    """One sheet after a step from `start` [s]. Raises DivergenceError naming it, the place and the cause."""
    conduction = scheme_of(model).conduction(model, layer, ahead)
    stages = model.stages(layer, ahead.least, stimulus.opened, conduction.ring_rate)
    tissue = Tissue(layer.cell, layer.conductances, conduction, stages, layer.tables(model.dt_cell), layer.constants)
    return _advance_sheet(model, sheet, tissue, stimulus, start, f"{name} potential")


def advance_pacemaker(model: Model, sheet: SheetState, stimulus: Stimulus, start: float) -> SheetState:
    """The pacemaker cell after a step; without one, what stands in its place."""
    cell = model.pacemaker_cell
    if cell is None:
        return sheet
    rate = cell.constants.kinetics_rate * float(cell.conductances.sum()) + cell.coupling
    stages = explicit_stages(rate / cell.constants.capacitance, model.dt_cell)
    tables = SHIPPED_CELL.tables(model.dt_cell, cell.constants)
    tissue = Tissue(SHIPPED_CELL, cell.conductances, APART, stages, tables, cell.constants)
    return _advance_sheet(model, sheet, tissue, stimulus, start, "pacemaker potential")


def _advance_sheet(
    model: Model, sheet: SheetState, tissue: Tissue, stimulus: Stimulus, start: float, field: str
) -> SheetState:
    shape = sheet.potential.shape
    arrays = SheetArrays(
        sheet.potential.ravel().copy(),
        sheet.gates.reshape(len(sheet.gates), -1).copy(),
        sheet.first_activation.ravel().copy(),
        sheet.last_activation.ravel().copy(),
    )
    brought = Brought(stimulus.current.ravel(), stimulus.conductance.ravel())
    steps = Steps(start * 1e3, model.dt_cell, model.substeps, shape[1], model.exact_kinetics, ACTIVATION_LEVEL)
    operator = tissue.conduction.operator
    rest = brought, steps, tissue.stages, tissue.tables, tissue.constants
    if isinstance(operator, np.ndarray):
        bad = tissue.cell.advance_sheet(arrays, tissue.conductances, operator.ravel(), *rest)
    else:
        try:
            bad = tissue.cell.advance_surface_sheet(arrays, tissue.conductances, operator, *rest)
        except EllipticError as error:
            raise DivergenceError(f"{field} at t = {start:.6g} s: {error}") from None
    if bad >= 0:
        place = f"z = {model.grid.cells[bad // shape[1]]:.3g} cm" if shape[0] > 1 else "the oral end"
        cause = why_out_of_range(model, tissue, stimulus, field, arrays.gates, bad)
        low, high = tissue.cell.lowest, tissue.cell.highest
        raise DivergenceError(f"{field} left {low:g}...{high:g} mV at {place}, t = {start:.6g} s: {cause}")
    return SheetState(
        arrays.potential.reshape(shape),
        arrays.gates.reshape(-1, *shape),
        arrays.first_activation.reshape(shape),
        arrays.last_activation.reshape(shape),
        sheet.muscle,
    )
