"""One muscle sheet by explicit differences of second order in space and time, Eq. (53).

Gates relax as in `sheet`, exactly at a held potential (Strang). The potential takes Heun's step on the three-point
operator, in as many equal parts as its stability limit asks for.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..numerics.compiled import compiled
from .cells import plant
from .cells.plant import CellConstants
from .sheet import first_stage, hold_gates, note_activations

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
    cubed: np.ndarray,
    work: np.ndarray,
) -> int:
    """One conduction step of dt [ms] of the potential at held gates; -1, or the first cell out of range.

    stretch: longitudinal, at the inner faces, (n - 1,). cubed: m^3 at the potential. work: (6, n).
    """
    v = sheet.potential
    n = v.size
    rate_0 = work[0]
    new = work[1]
    spread = work[2]
    held = work[3:6]
    part = dt / sheet.parts
    conducts = sheet.spread.size > 0
    calcium = constants.calcium_reversal
    spread[:] = 0.0
    hold_gates(sheet.gates, sheet.conductances, sheet.current, sheet.conductance, part, constants, 0, n, held)
    for p in range(sheet.parts):
        if p > 0:
            plant.activation_cubed(v, table, exact, cubed, 0, n)
        if conducts:
            three_point(v, sheet.spread, stretch, spread)
        first_stage(v, spread, cubed, held, part, calcium, 1.0, 0, n, rate_0, new)
        bad = plant.out_of_range(new)
        if bad >= 0:
            return bad
        plant.activation_cubed(new, table, exact, cubed, 0, n)
        if conducts:
            three_point(new, sheet.spread, stretch, spread)
        for k in range(n):
            x = new[k]
            rate = part * spread[k] - held[0, k] * cubed[k] * (x - calcium) - held[1, k] * x + held[2, k]
            new[k] = v[k] + 0.5 * (rate_0[k] + rate)
        bad = plant.out_of_range(new)
        if bad >= 0:
            return bad
        note_activations(v, new, level, time, p, part, 0, n, sheet.first_activation, sheet.last_activation)
    return -1
