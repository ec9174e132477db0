"""The wave of a layer on a cable that is uniformly stretched and does not deform further."""

from __future__ import annotations

import numpy as np

from peristalsis.inputs.build import build
from peristalsis.model.initial import initial_state
from peristalsis.model.model import ACTIVATION_LEVEL
from peristalsis.numerics.stabilised import coefficients, stages_for
from peristalsis.results.measures import wave_speed
from peristalsis.tissue.conduction import largest_eigenvalue
from peristalsis.tissue.records import Brought, SheetArrays, Steps, Tables
from peristalsis.tissue.sheet import advance_sheet

from .runs import configured


def speed(layer: str, cells: int, stretch: float = 1.0, length: float = 10.0) -> float | None:
    """Lagrangian speed [cm/s] of the first wave started from rest, None if none arrives.

    length: of the cable [cm], 8 at least, where the middle half of 10 cm is looked at in proportion.
    """
    small = {"grid.n_z": cells, "grid.n_z_wall": 8, "pellet.enabled": False, "lumen.pressure": "0 kPa"}
    model, state, _ = initial_state(build(configured(small)))
    part, sheet = getattr(model, layer), getattr(state, layer)
    h, dt = length / cells, model.dt_cell
    rate = largest_eigenvalue(part.diffusivity * 1e-3, h) / stretch
    rate += model.cell.kinetics_rate * float(part.conductances[:, 0].sum())
    stages = coefficients(stages_for(rate * dt))
    table, half = model.tables
    z = (np.arange(cells) + 0.5) * h
    potential, gates = sheet.potential.ravel().copy(), sheet.gates.reshape(4, -1).copy()
    first, last = np.full(cells, np.nan), np.full(cells, np.nan)
    time = 0.0
    for duration, current in ((50.0, 2.0), (1e3 * length / 2.5, 0.0)):
        advance_sheet(
            SheetArrays(potential, gates, first, last),
            part.conductances,
            np.full(cells - 1, part.diffusivity * 1e-3 / (24.0 * h) ** 2 / stretch),
            Brought(np.where(z < 0.3, current, 0.0), np.zeros(cells)),
            Steps(time, dt, round(duration / dt), 1, False, ACTIVATION_LEVEL),
            stages,
            Tables(table, half),
            model.cell,
        )
        time += duration
    found = wave_speed(np.asarray(z * 10.0 / length, dtype=np.float64), first * 1e-3)
    return None if found is None else found * length / 10.0
