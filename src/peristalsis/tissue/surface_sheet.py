"""One muscle sheet on the whole surface, advanced in time: Eq. (31) with conduction in both directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .cells import plant as cell
from .cells.plant import CellConstants
from .records import Brought, Rates, SheetArrays, Stages, Steps, Tables
from .sheet import REVIEW, first_stage, next_stage, note_activations, restless
from .surface import SurfaceOperator

Floats = NDArray[np.float64]


def advance_surface_sheet(
    sheet: SheetArrays,
    conductances: Floats,
    operator: SurfaceOperator | None,
    brought: Brought,
    steps: Steps,
    stages: Floats,
    tables: Tables,
    constants: CellConstants,
) -> int:
    """Advance one sheet in place; -1, or the first cell out of range.

    Arguments as for `sheet.advance_sheet`, with an operator in place of the coefficients (None where cells do not
    conduct), which knows its rings.
    On fields without variation around the ring each column does what `advance_sheet` does, bit for bit.
    Raises `bidomain.EllipticError` where the extracellular potential is not found.
    """
    potential, gates, first_activation, last_activation = sheet
    drive, shunt = brought
    table, half_table = tables
    time, dt, n_steps, exact = steps.time, steps.dt, steps.n_steps, steps.exact
    size = potential.size
    ring = 0 if operator is None else 2 * operator.shape[1]
    if operator is not None and operator.shape[0] * operator.shape[1] != size:
        raise ValueError(
            f"a sheet of {size} cells and an operator of shape {operator.shape}: they must be the same grid"
        )
    padded = np.zeros((3, size + 2 * ring))
    inside = padded[:, ring : ring + size]
    v = potential.copy()
    spread, rate_0 = np.zeros(size), np.empty(size)
    instant, held = np.empty((cell.INSTANT, size)), np.empty((cell.HELD, size))
    rates = Rates(spread, instant, held)
    low, high = 0, size
    bad = cell.out_of_range(v)
    if bad >= 0:
        return int(bad)
    gates_before = gates.copy()
    cell.relax_gates(v, gates, half_table, exact, 0.5 * dt, constants, instant, conductances)
    for step in range(n_steps):
        review = step % REVIEW == 0 and operator is not None and not exact
        if review:
            low, high = 0, size
        cell.hold(gates, conductances, drive, shunt, dt, constants, low, high, held)
        inside[0] = v
        for j in range(len(stages)):
            last, new = inside[j % 3], inside[(j + 1) % 3]
            if j > 0:
                bad = cell.first_outside(last, low, high)
                if bad >= 0:
                    return int(bad)
                cell.respond(last, table, exact, constants, instant, low, high)
            if operator is not None:
                operator.apply(padded[j % 3], spread, low, high)
            if j == 0:
                first_stage(v, rates, dt, constants, stages[0, 2], low, high, rate_0, new)
            else:
                older = inside[(j + 2) % 3]
                past = Stages(v, last, older)
                next_stage(past, rates, dt, constants, stages[j], low, high, rate_0, new)
            if j == 0 and review and operator is not None:
                low, high = restless(rate_0, gates, gates_before, step == 0, operator.shape[1])
                # What waits keeps its potential in every stage.
                inside[1:, :low], inside[1:, high:] = v[:low], v[high:]
        new = inside[len(stages) % 3]
        bad = cell.first_outside(new, low, high)
        if bad >= 0:
            return int(bad)
        note_activations(v, new, steps.level, time, step, dt, low, high, first_activation, last_activation)
        whole = step < n_steps - 1
        relaxing, span = (table, dt) if whole else (half_table, 0.5 * dt)
        cell.relax_cells(v, gates, relaxing, exact, span, constants, instant, conductances, low, high)
    potential[:] = v
    return -1
