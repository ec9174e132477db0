"""The wave of one layer on the undeformed cable: what the conductivity scales are calibrated on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..inputs.build import build
from ..inputs.config import Configuration
from ..model.model import ACTIVATION_LEVEL
from ..results.measures import wave_speed
from ..tissue.front_correction import SPACING, correct_front
from ..tissue.records import Brought, SheetArrays, Steps

Floats = NDArray[np.float64]

CALIBRATED_SPEED = 4.2
"""Speed on the undeformed cable to which both conductivity scales are set [cm/s]."""


def cable_wave_speed(configuration: Configuration, layer: str = "longitudinal", duration: float = 2.8) -> float | None:
    """Speed of a wave along the undeformed cable [cm/s], between 3 and 8 cm; None if it does not pass.

    layer: longitudinal or circular, of a tube of at least 8 cm. The cable starts from true rest and is excited at
    the oral end by the pacemaker's pulse; cells and steps are those of the configuration.
    """
    model = build(configuration)
    part = model.longitudinal if layer == "longitudinal" else model.circular
    n = model.grid.n_z
    tables = part.tables(model.dt_cell)
    rest = part.cell.rest.rest_state(part.conductances[:, 0], part.constants, tables.whole, model.exact_kinetics)
    potential, gates = np.full(n, rest.potential), np.repeat(np.array(rest.gates)[:, None], n, axis=1)
    first, last = np.full(n, np.nan), np.full(n, np.nan)
    coefficient = np.full(n - 1, part.diffusivity * 1e-3 / (24.0 * model.grid.cell_size) ** 2)
    law = part.front_law(model.grid.cell_size, model.dt_cell)
    if law is not None:
        correct_front(law.cells_per_foot, SPACING, law.table, float(coefficient[0]), coefficient.reshape(-1, 1))
    stages = model.stages(part, np.ones(1))
    pulse = configuration.pacemaker
    driven = np.where(model.grid.cells < pulse.width, pulse.intensity, 0.0)
    for step in range(round(duration / model.dt_wall)):
        time = step * model.dt_wall
        part.cell.advance_sheet(
            SheetArrays(potential, gates, first, last),
            np.ascontiguousarray(part.conductances[:, :n]),
            coefficient,
            Brought(driven if time < pulse.duration - 1e-12 else np.zeros(n), np.zeros(n)),
            Steps(time * 1e3, model.dt_cell, model.substeps, 1, model.exact_kinetics, ACTIVATION_LEVEL),
            stages,
            tables,
            part.constants,
        )
    return wave_speed(model.grid.cells, first * 1e-3)
