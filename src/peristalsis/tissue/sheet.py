"""One muscle sheet advanced in time: gates, currents and conduction in one compiled loop, Eq. (31).

A step of length dt is G(dt/2) V(dt) G(dt/2): gates relax exactly at a held potential (Strang), the potential takes
one stabilised explicit step of second order with held gates. Neighbouring half steps of the gates are one full step.

Tissue that the wave has not reached is at rest. One step in REVIEW, the first of a call among them, looks at the rate
of every cell; rings outside the stretch in which anything changes, with a margin, wait until the next such step.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import INDEX, compiled
from .cells import plant
from .cells.plant import CellConstants
from .conduction import diffuse_rings, fill_ghosts

QUIET_POTENTIAL, QUIET_GATE = 1e-9, 1e-11
"""Changes in a step [mV], and of a gate in half of one, below which a cell counts as resting."""
REVIEW = 8
"""Steps from one that looks at every cell to the next."""
MARGIN = 8
"""Rings beyond the outermost that change that are advanced with them."""


@compiled
def advance_sheet(
    potential: np.ndarray,
    gates: np.ndarray,
    first_activation: np.ndarray,
    last_activation: np.ndarray,
    conductances: np.ndarray,
    coefficient: np.ndarray,
    drive: np.ndarray,
    shunt: np.ndarray,
    n_theta: int,
    time: float,
    dt: float,
    n_steps: int,
    stages: np.ndarray,
    table: np.ndarray,
    half_table: np.ndarray,
    exact: bool,
    activation_level: float,
    constants: CellConstants,
) -> int:
    """Advance one sheet in place by n_steps of dt [ms] from `time` [ms]; -1, or the first cell out of range.

    potential [mV], first_activation and last_activation [ms] (rise through `activation_level`, nan before): size
    n_z*n_theta, flattened (z, theta). gates: (4, n). conductances [mS/cm^2]: (5, n). coefficient: see
    `conduction.diffuse`, in 1/ms. drive: stimulus current [uA/cm^2], inward positive, and shunt: extra
    conductance [mS/cm^2], whose current at 0 mV is part of the drive; both held over the call. stages: coefficients
    of `numerics.stabilised`, (s, 4), enough of them for dt. exact: no tables, and no cell waits.
    """
    size = potential.size
    ghosts = 2 * n_theta
    padded = np.empty((3, size + 2 * ghosts))
    v = potential.copy()
    flux = np.zeros(size + 3 * n_theta)
    spread = np.zeros(size)
    work = np.empty((5, size))  # rate of the first stage, m^3, and the three coefficients of the current
    conducts = coefficient.size == size - n_theta and size > n_theta
    scale = dt * constants.kinetics_rate / constants.capacitance
    per_capacitance = dt / constants.capacitance
    low, high = 0, size
    bad = plant.first_outside(v, low, high)
    if bad >= 0:
        return bad
    gates_before = gates.copy()
    plant.relax_cells(v, gates, half_table, exact, 0.5 * dt, constants, work[1], low, high)
    for step in range(n_steps):
        review = step % REVIEW == 0 and not exact
        if review:
            low, high = 0, size
        _coefficients(gates, conductances, drive, shunt, scale, per_capacitance, constants, low, high, work)
        padded[0, ghosts : ghosts + size] = v
        for j in range(stages.shape[0]):
            now = padded[j % 3]
            if j > 0:
                bad = plant.first_outside(now[ghosts : ghosts + size], low, high)
                if bad >= 0:
                    return bad
                plant.activation_cubed(now[ghosts : ghosts + size], table, exact, work[1], low, high)
            if conducts:
                fill_ghosts(now, n_theta)
                diffuse_rings(now, coefficient, flux, spread, n_theta, low, high)
            _stage(v, padded, j, ghosts, stages[j], dt, spread, constants.calcium_reversal, low, high, work)
            if j == 0 and review:
                low, high = _restless(work[0], gates, gates_before, step == 0, n_theta)
                # What waits keeps its potential in every stage.
                for row in range(1, 3):
                    padded[row, ghosts : ghosts + low] = v[:low]
                    padded[row, ghosts + high : ghosts + size] = v[high:]
        new = padded[stages.shape[0] % 3, ghosts : ghosts + size]
        bad = plant.first_outside(new, low, high)
        if bad >= 0:
            return bad
        for k in range(low, high):
            if v[k] < activation_level and new[k] >= activation_level:
                last_activation[k] = time + dt * (step + (activation_level - v[k]) / (new[k] - v[k]))
                if math.isnan(first_activation[k]):
                    first_activation[k] = last_activation[k]
            v[k] = new[k]
        last = step == n_steps - 1
        relaxing, span = (half_table, 0.5 * dt) if last else (table, dt)
        plant.relax_cells(v, gates, relaxing, exact, span, constants, work[1], low, high)
    potential[:] = v
    return -1


@compiled
def _restless(
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
        for g in range(4):
            for k in range(size):
                if not abs(gates[g, k] - gates_before[g, k]) <= QUIET_GATE:
                    low = min(low, k)
                    high = max(high, k + 1)
    if high == 0:
        return 0, 0
    return max(low // n_theta - MARGIN, 0) * n_theta, min((high - 1) // n_theta + 1 + MARGIN, size // n_theta) * n_theta


@compiled
def _coefficients(
    gates: np.ndarray,
    conductances: np.ndarray,
    drive: np.ndarray,
    shunt: np.ndarray,
    scale: float,
    per_capacitance: float,
    constants: CellConstants,
    low: int,
    high: int,
    work: np.ndarray,
) -> None:
    """Change of potential over a step is -work[2] m^3 (V - V_Ca) - work[3] V + work[4], by the held gates."""
    low, high = low & INDEX, high & INDEX
    for k in range(low, high):
        fast, slope, offset = plant.current_coefficients(
            gates[0, k], gates[1, k], gates[2, k], gates[3, k], conductances, k, constants
        )
        work[2, k] = scale * fast
        work[3, k] = scale * slope + per_capacitance * shunt[k]
        work[4, k] = scale * offset + per_capacitance * drive[k]


@compiled
def _stage(
    v: np.ndarray,
    padded: np.ndarray,
    j: int,
    ghosts: int,
    stage: np.ndarray,
    dt: float,
    spread: np.ndarray,
    calcium: float,
    low: int,
    high: int,
    work: np.ndarray,
) -> None:
    """Stage j of the step of the potential, from row j to row j + 1 of `padded` (counted by three)."""
    low, high, ghosts = low & INDEX, high & INDEX, ghosts & INDEX
    size = v.size
    mu, nu, mu_rate, gamma_rate = stage[0], stage[1], stage[2], stage[3]
    start = 1.0 - mu - nu
    now = padded[j % 3, ghosts : ghosts + size]
    new = padded[(j + 1) % 3, ghosts : ghosts + size]
    older = padded[(j + 2) % 3, ghosts : ghosts + size]
    if j == 0:
        for k in range(low, high):
            x = v[k]
            rate = dt * spread[k] - work[2, k] * work[1, k] * (x - calcium) - work[3, k] * x + work[4, k]
            work[0, k] = rate
            new[k] = x + mu_rate * rate
        return
    for k in range(low, high):
        x = now[k]
        rate = dt * spread[k] - work[2, k] * work[1, k] * (x - calcium) - work[3, k] * x + work[4, k]
        new[k] = start * v[k] + mu * x + nu * older[k] + mu_rate * rate + gamma_rate * work[0, k]
