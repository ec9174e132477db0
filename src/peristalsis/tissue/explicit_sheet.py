"""One muscle sheet by explicit differences of second order in space and time, Eq. (53).

Gates relax as in `sheet`, exactly at a held potential (Strang). The potential takes Heun's step on the three-point
operator, in as many equal parts as its stability limit asks for.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numerics.compiled import compiled
from .cells import plant as cell
from .cells.plant import CellConstants
from .records import Rates
from .sheet import first_stage, note_activations

HEUN_LIMIT = 2.0
"""Largest step times decay rate of Heun's method on the real axis."""


class Excitable(NamedTuple):
    """A sheet of one column with what drives it over a wall step; the first four are advanced in place.

    potential [mV] (n,), gates (4, n), activation times [ms] (n,); conductances [mS/cm^2] (5, n); spread: conduction
    at the inner faces at stretch 1, D/h^2 in 1/ms, (n - 1,), empty without conduction; current [uA/cm^2] and
    conductance [mS/cm^2] of the stimuli (n,); force_factor (n,) and threshold [mV] of Eq. (19); parts: steps of the
    potential in a conduction step.
    """

    potential: np.ndarray
    gates: np.ndarray
    first_activation: np.ndarray
    last_activation: np.ndarray
    conductances: np.ndarray
    spread: np.ndarray
    current: np.ndarray
    conductance: np.ndarray
    force_factor: np.ndarray
    threshold: float
    parts: int


@compiled
def three_point(v: np.ndarray, spread: np.ndarray, stretch: np.ndarray, rate: np.ndarray) -> None:
    """d/dz (D/lambda dV/dz) by central differences with sealed ends [mV/ms], into `rate`; its sum vanishes.

    stretch: of the faces, (n - 1,).
    """
    n = v.size
    before = 0.0
    for k in range(n - 1):
        flux = spread[k] / stretch[k] * (v[k + 1] - v[k])
        rate[k] = flux - before
        before = flux
    rate[n - 1] = -before


@compiled
def excite(
    sheet: Excitable,
    stretch: np.ndarray,
    time: float,
    dt: float,
    constants: CellConstants,
    table: np.ndarray,
    exact: bool,
    level: float,
    instant: np.ndarray,
    work: np.ndarray,
) -> int:
    """One conduction step of dt [ms] of the potential at held gates; -1, or the first cell out of range.

    stretch: longitudinal, at the inner faces, (n - 1,). instant: of the cell at the potential. work: (3 + HELD, n).
    """
    v = sheet.potential
    n = v.size
    rate_0 = work[0]
    new = work[1]
    spread = work[2]
    held = work[3 : 3 + cell.HELD]
    part = dt / sheet.parts
    conducts = sheet.spread.size > 0
    spread[:] = 0.0
    cell.hold(sheet.gates, sheet.conductances, sheet.current, sheet.conductance, part, constants, 0, n, held)
    for p in range(sheet.parts):
        if p > 0:
            cell.respond(v, table, exact, constants, instant, 0, n)
        if conducts:
            three_point(v, sheet.spread, stretch, spread)
        first_stage(v, Rates(spread, instant, held), part, constants, 1.0, 0, n, rate_0, new)
        bad = cell.out_of_range(new)
        if bad >= 0:
            return bad
        cell.respond(new, table, exact, constants, instant, 0, n)
        if conducts:
            three_point(new, sheet.spread, stretch, spread)
        for k in range(n):
            x = new[k]
            rate = cell.with_current(part * spread[k], x, held, instant, k, constants)
            new[k] = v[k] + 0.5 * (rate_0[k] + rate)
        bad = cell.out_of_range(new)
        if bad >= 0:
            return bad
        note_activations(v, new, level, time, p, part, 0, n, sheet.first_activation, sheet.last_activation)
    return -1
