"""One muscle sheet advanced in time: gates, currents and conduction in one compiled loop, Eq. (31).

A step of length dt is G(dt/2) V(dt) G(dt/2): gates relax exactly at a held potential (Strang), the potential takes
one stabilised explicit step of second order with held gates. Neighbouring half steps of the gates are one full step.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled
from .cells import plant
from .cells.plant import CellConstants
from .conduction import diffuse, fill_ghosts


@compiled
def hold_gates(
    gates: np.ndarray,
    conductances: np.ndarray,
    drive: np.ndarray,
    shunt: np.ndarray,
    dt: float,
    constants: CellConstants,
    held: np.ndarray,
) -> None:
    """What the gates make of the currents over a step of dt [ms], into `held`, (3, n): fast, slope and offset.

    With them -dt I/C = offset - slope*V - fast*m^3(V)*(V - V_Ca) [mV], stimulus and shunt included.
    """
    scale = dt * constants.kinetics_rate / constants.capacitance
    per_capacitance = dt / constants.capacitance
    for k in range(held.shape[1]):
        f, s, o = plant.current_coefficients(
            gates[0, k], gates[1, k], gates[2, k], gates[3, k], conductances, k, constants
        )
        opened = per_capacitance * shunt[k]
        held[0, k] = scale * f
        held[1, k] = scale * s + opened
        held[2, k] = scale * o + per_capacitance * drive[k]


@compiled
def first_stage(
    v: np.ndarray,
    spread: np.ndarray,
    cubed: np.ndarray,
    held: np.ndarray,
    dt: float,
    calcium: float,
    weight: float,
    rate_0: np.ndarray,
    new: np.ndarray,
) -> None:
    """Stage 1 of the step: its change dt*F(V) [mV] into `rate_0`, its potential into `new`.

    spread: conduction at v [mV/ms]; cubed: m^3 at v; weight: mu~ of `numerics.stabilised`.
    """
    for k in range(v.size):
        x = v[k]
        rate_0[k] = dt * spread[k] - held[0, k] * cubed[k] * (x - calcium) - held[1, k] * x + held[2, k]
        new[k] = x + weight * rate_0[k]


@compiled
def next_stage(
    v: np.ndarray,
    last: np.ndarray,
    older: np.ndarray,
    spread: np.ndarray,
    cubed: np.ndarray,
    held: np.ndarray,
    dt: float,
    calcium: float,
    weights: np.ndarray,
    rate_0: np.ndarray,
    new: np.ndarray,
) -> None:
    """A later stage, from the start `v`, the stage before (`last`) and the one before that (`older`).

    spread and cubed belong to `last`; weights: a row of `numerics.stabilised`.
    """
    mu, nu, mu_rate, gamma_rate = weights
    start = 1.0 - mu - nu
    for k in range(v.size):
        x = last[k]
        rate = dt * spread[k] - held[0, k] * cubed[k] * (x - calcium) - held[1, k] * x + held[2, k]
        new[k] = start * v[k] + mu * x + nu * older[k] + mu_rate * rate + gamma_rate * rate_0[k]


@compiled
def note_activations(
    v: np.ndarray,
    new: np.ndarray,
    level: float,
    time: float,
    step: int,
    dt: float,
    first_activation: np.ndarray,
    last_activation: np.ndarray,
) -> None:
    """Times [ms] of rises through `level` in a step from v to new, `step` steps of dt after `time`; `v` becomes new."""
    for k in range(v.size):
        if v[k] < level and new[k] >= level:
            last_activation[k] = time + dt * (step + (level - v[k]) / (new[k] - v[k]))
            if math.isnan(first_activation[k]):
                first_activation[k] = last_activation[k]
        v[k] = new[k]


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
    of `numerics.stabilised`, (s, 4), enough of them for dt.
    """
    size = potential.size
    first = 2 * n_theta
    padded = np.empty((3, size + 4 * n_theta))
    inside = padded[:, first : first + size]
    v = np.empty(size)
    flux = np.zeros(size + 3 * n_theta)
    spread = np.zeros(size)
    rate_0 = np.empty(size)
    cubed = np.empty(size)
    held = np.empty((3, size))
    conducts = coefficient.size == size - n_theta and size > n_theta
    calcium = constants.calcium_reversal
    v[:] = potential
    bad = plant.out_of_range(v)
    if bad >= 0:
        return bad
    plant.relax_gates(v, gates, half_table, exact, 0.5 * dt, constants, cubed)
    for step in range(n_steps):
        hold_gates(gates, conductances, drive, shunt, dt, constants, held)
        inside[0] = v
        for j in range(stages.shape[0]):
            last = inside[j % 3]
            if j > 0:
                bad = plant.out_of_range(last)
                if bad >= 0:
                    return bad
                plant.activation_cubed(last, table, exact, cubed)
            if conducts:
                fill_ghosts(padded[j % 3], n_theta)
                diffuse(padded[j % 3], coefficient, flux, spread, n_theta)
            new = inside[(j + 1) % 3]
            if j == 0:
                first_stage(v, spread, cubed, held, dt, calcium, stages[0, 2], rate_0, new)
            else:
                older = inside[(j + 2) % 3]
                next_stage(v, last, older, spread, cubed, held, dt, calcium, stages[j], rate_0, new)
        new = inside[stages.shape[0] % 3]
        bad = plant.out_of_range(new)
        if bad >= 0:
            return bad
        note_activations(v, new, activation_level, time, step, dt, first_activation, last_activation)
        if step < n_steps - 1:
            plant.relax_gates(v, gates, table, exact, dt, constants, cubed)
        else:
            plant.relax_gates(v, gates, half_table, exact, 0.5 * dt, constants, cubed)
    potential[:] = v
    return -1
