"""The speed of a front of the resting tissue on a uniform cable, by cell size over the length of its foot."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from peristalsis.model.model import ACTIVATION_LEVEL, Layer
from peristalsis.model.state import SheetState
from peristalsis.numerics.stabilised import coefficients, stages_for
from peristalsis.tissue.conduction import largest_eigenvalue
from peristalsis.tissue.records import Brought, SheetArrays, Steps
from peristalsis.tissue.resolution import front_foot

from .runs import IDLE, started

Floats = NDArray[np.float64]

FEET = 240.0
"""Length of the cable, in feet of the front."""
CALL = 8.0
"""Time that the sheet is advanced by in one call [ms], as a step of the wall does."""
PULSE, LONGEST = 50.0, 20_000.0
"""Length of the stimulus, and when a front that is still under way counts as blocked [ms]."""


@cache
def resting() -> tuple[Layer, SheetState]:
    """The longitudinal layer and its resting sheet."""
    model, state = started(IDLE, {"pellet.enabled": False, "grid.n_z": 8, "grid.n_z_wall": 8})
    return model.longitudinal, state.longitudinal


def front_speed(
    ratio: float, dt: float, factor: float = 1.0, scales: dict[str, float] | None = None, feet: float = FEET
) -> float | None:
    """Speed [cm/s] on cells of `ratio` feet with steps dt [ms]; None if the front does not arrive.

    factor: on conduction, as the correction makes it. scales: on conductances by name of their channel; the foot is
    that of the unchanged tissue all the same.
    """
    layer, sheet = resting()
    h = ratio * front_foot(layer.diffusivity)
    n = max(40, round(feet / ratio))
    tables = layer.tables(dt)
    conductances = np.repeat(layer.conductances[:, :1], n, axis=1)
    v, gates = float(sheet.potential[0, 0]), np.array(sheet.gates[:, 0, 0])
    if scales:
        for name, scale in scales.items():
            conductances[layer.cell.channels.index(name)] *= scale
        rest = layer.cell.rest.rest_state(conductances[:, 0], layer.constants, tables.whole, False)
        v, gates = rest.potential, np.array(rest.gates)
    rate = layer.constants.kinetics_rate * float(conductances[:, 0].sum()) / layer.constants.capacitance
    rate += largest_eigenvalue(layer.diffusivity * 1e-3, h) * factor
    stages = coefficients(max(stages_for(rate * dt), 2))
    potential, states = np.full(n, v), np.repeat(gates[:, None], n, axis=1)
    first, last = np.full((2, n), np.nan)
    driven = np.where(np.arange(n) * h < max(0.1, 2.5 * h), 2.0, 0.0)
    coefficient = np.full(n - 1, factor * layer.diffusivity * 1e-3 / (24.0 * h) ** 2)
    watched = slice(round(0.4 * n), round(0.9 * n))
    steps = max(round(CALL / dt), 1)
    for call in range(math.ceil(LONGEST / (steps * dt))):
        time = call * steps * dt
        bad = layer.cell.advance_sheet(
            SheetArrays(potential, states, first, last),
            conductances,
            coefficient,
            Brought(driven if time < PULSE else np.zeros(n), np.zeros(n)),
            Steps(time, dt, steps, 1, False, ACTIVATION_LEVEL),
            stages,
            tables,
            layer.constants,
        )
        if bad >= 0:
            return None
        if np.isfinite(first[watched]).all():
            return float(np.polyfit(1e-3 * first[watched], np.arange(n)[watched] * h, 1)[0])
    return None
