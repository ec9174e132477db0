"""One muscle sheet advanced in time: gates, currents and conduction in one compiled loop, Eq. (31).

A step of length dt is G(dt/2) V(dt) G(dt/2): gates relax exactly at a held potential (Strang), the potential takes
one stabilised explicit step of second order with held gates. Neighbouring half steps of the gates are one full step.
What the gates, or other states, and the currents are is known to the cell alone (`cells`).

Tissue that the wave has not reached is at rest. One step in REVIEW, the first of a call among them, looks at the rate
of every cell; rings outside the stretch in which anything changes, with a margin, wait until the next such step.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import INDEX, compiled
from .cells import plant as cell
from .cells.plant import CellConstants
from .conduction import diffuse_rings, fill_ghosts
from .records import Brought, Rates, SheetArrays, Stages, Steps, Tables

QUIET_POTENTIAL, QUIET_GATE = 1e-9, 1e-11
"""Changes in a step [mV], and of a gate in half of one, below which a cell counts as resting."""
REVIEW = 8
"""Steps from one that looks at every cell to the next."""
MARGIN = 8
"""Rings beyond the outermost that change that are advanced with them."""


@compiled
def first_stage(
    v: np.ndarray,
    rates: Rates,
    dt: float,
    constants: CellConstants,
    weight: float,
    low: int,
    high: int,
    rate_0: np.ndarray,
    new: np.ndarray,
) -> None:
    """Stage 1 of the step: its change dt*F(V) [mV] into `rate_0`, its potential into `new`, cells low...high - 1.

    rates: at v; held: by `cell.hold`; weight: mu~ of `numerics.stabilised`.
    """
    low, high = low & INDEX, high & INDEX
    spread, instant, held = rates.spread, rates.instant, rates.held
    for k in range(low, high):
        x = v[k]
        rate = cell.with_current(dt * spread[k], x, held, instant, k, constants)
        rate_0[k] = rate
        new[k] = x + weight * rate


@compiled
def next_stage(
    stages: Stages,
    rates: Rates,
    dt: float,
    constants: CellConstants,
    weights: np.ndarray,
    low: int,
    high: int,
    rate_0: np.ndarray,
    new: np.ndarray,
) -> None:
    """A later stage; rates belong to the stage before, weights are a row of `numerics.stabilised`."""
    low, high = low & INDEX, high & INDEX
    v, last, older = stages.start, stages.last, stages.older
    spread, instant, held = rates.spread, rates.instant, rates.held
    mu, nu, mu_rate, gamma_rate = weights[0], weights[1], weights[2], weights[3]
    start = 1.0 - mu - nu
    for k in range(low, high):
        x = last[k]
        rate = cell.with_current(dt * spread[k], x, held, instant, k, constants)
        new[k] = start * v[k] + mu * x + nu * older[k] + mu_rate * rate + gamma_rate * rate_0[k]


@compiled
def note_activations(
    v: np.ndarray,
    new: np.ndarray,
    level: float,
    time: float,
    step: int,
    dt: float,
    low: int,
    high: int,
    first_activation: np.ndarray,
    last_activation: np.ndarray,
) -> None:
    """Times [ms] of rises through `level` in a step from v to new, `step` steps of dt after `time`; `v` becomes new."""
    for k in range(low, high):
        if v[k] < level and new[k] >= level:
            last_activation[k] = time + dt * (step + (level - v[k]) / (new[k] - v[k]))
            if math.isnan(first_activation[k]):
                first_activation[k] = last_activation[k]
        v[k] = new[k]


@compiled
def restless(
    change: np.ndarray, gates: np.ndarray, gates_before: np.ndarray, with_gates: bool, n_theta: int
) -> tuple[int, int]:
    """First cell, and cell after the last, of the rings between the outermost that change, with a margin.

    change: of the potential by the rate at the start of a step [mV]. gates_before: half a step ago.
    """
    size = change.size
    low, high = size, 0
    for k in range(size):
        if not abs(change[k]) <= QUIET_POTENTIAL:
            low = min(low, k)
            high = k + 1
    if with_gates:
        for g in range(gates.shape[0]):
            for k in range(size):
                if not abs(gates[g, k] - gates_before[g, k]) <= QUIET_GATE:
                    low = min(low, k)
                    high = max(high, k + 1)
    if high == 0:
        return 0, 0
    return max(low // n_theta - MARGIN, 0) * n_theta, min((high - 1) // n_theta + 1 + MARGIN, size // n_theta) * n_theta


@compiled
def advance_sheet(
    sheet: SheetArrays,
    conductances: np.ndarray,
    coefficient: np.ndarray,
    brought: Brought,
    steps: Steps,
    stages: np.ndarray,
    tables: Tables,
    constants: CellConstants,
) -> int:
    """Advance one sheet in place; -1, or the first cell out of range.

    conductances [mS/cm^2]: (channels, n). coefficient: see `conduction.diffuse`, in 1/ms; where cells do not conduct
    it is empty, and none waits. stages: coefficients of `numerics.stabilised`, (s, 4), enough of them for dt.
    """
    potential, gates = sheet.potential, sheet.gates
    first_activation, last_activation = sheet.first_activation, sheet.last_activation
    drive, shunt = brought.drive, brought.shunt
    time, dt, n_steps, n_theta, exact = steps.time, steps.dt, steps.n_steps, steps.n_theta, steps.exact
    table, half_table = tables.whole, tables.half
    size = potential.size
    ghosts = 2 * n_theta
    padded = np.empty((3, size + 2 * ghosts))
    inside = padded[:, ghosts : ghosts + size]
    v = potential.copy()
    flux, spread = np.zeros(size + 3 * n_theta), np.zeros(size)
    rate_0, instant, held = np.empty(size), np.empty((cell.INSTANT, size)), np.empty((cell.HELD, size))
    rates = Rates(spread, instant, held)
    conducts = coefficient.size == size - n_theta and size > n_theta
    low, high = 0, size
    bad = cell.first_outside(v, low, high)
    if bad >= 0:
        return bad
    gates_before = gates.copy()
    cell.relax_cells(v, gates, half_table, exact, 0.5 * dt, constants, instant, conductances, low, high)
    for step in range(n_steps):
        review = step % REVIEW == 0 and conducts and not exact
        if review:
            low, high = 0, size
        cell.hold(gates, conductances, drive, shunt, dt, constants, low, high, held)
        inside[0] = v
        for j in range(stages.shape[0]):
            last, new = inside[j % 3], inside[(j + 1) % 3]
            if j > 0:
                bad = cell.first_outside(last, low, high)
                if bad >= 0:
                    return bad
                cell.respond(last, table, exact, constants, instant, low, high)
            if conducts:
                fill_ghosts(padded[j % 3], n_theta)
                diffuse_rings(padded[j % 3], coefficient, flux, spread, n_theta, low, high)
            if j == 0:
                first_stage(v, rates, dt, constants, stages[0, 2], low, high, rate_0, new)
            else:
                older = inside[(j + 2) % 3]
                past = Stages(v, last, older)
                next_stage(past, rates, dt, constants, stages[j], low, high, rate_0, new)
            if j == 0 and review:
                low, high = restless(rate_0, gates, gates_before, step == 0, n_theta)
                # What waits keeps its potential in every stage.
                for row in range(1, 3):
                    inside[row, :low] = v[:low]
                    inside[row, high:] = v[high:]
        new = inside[stages.shape[0] % 3]
        bad = cell.first_outside(new, low, high)
        if bad >= 0:
            return bad
        note_activations(v, new, steps.level, time, step, dt, low, high, first_activation, last_activation)
        whole = step < n_steps - 1
        relaxing, span = (table, dt) if whole else (half_table, 0.5 * dt)
        cell.relax_cells(v, gates, relaxing, exact, span, constants, instant, conductances, low, high)
    potential[:] = v
    return -1
