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
    rate = np.empty(size)
    cubed = np.empty(size)
    fast = np.empty(size)
    slope = np.empty(size)
    offset = np.empty(size)
    conducts = coefficient.size == size - n_theta and size > n_theta
    scale = dt * constants.kinetics_rate / constants.capacitance
    per_capacitance = dt / constants.capacitance
    calcium = constants.calcium_reversal
    v[:] = potential
    bad = plant.out_of_range(v)
    if bad >= 0:
        return bad
    plant.relax_gates(v, gates, half_table, exact, 0.5 * dt, constants, cubed)
    for step in range(n_steps):
        for k in range(size):
            f, s, o = plant.current_coefficients(
                gates[0, k], gates[1, k], gates[2, k], gates[3, k], conductances, k, constants
            )
            opened = per_capacitance * shunt[k]
            fast[k] = scale * f
            slope[k] = scale * s + opened
            offset[k] = scale * o + per_capacitance * drive[k]
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
            mu, nu, mu_rate, gamma_rate = stages[j]
            start = 1.0 - mu - nu
            new = inside[(j + 1) % 3]
            if j == 0:
                for k in range(size):
                    x = v[k]
                    rate_0[k] = dt * spread[k] - fast[k] * cubed[k] * (x - calcium) - slope[k] * x + offset[k]
                    new[k] = x + mu_rate * rate_0[k]
            else:
                older = inside[(j + 2) % 3]
                for k in range(size):
                    x = last[k]
                    rate[k] = dt * spread[k] - fast[k] * cubed[k] * (x - calcium) - slope[k] * x + offset[k]
                    new[k] = start * v[k] + mu * x + nu * older[k] + mu_rate * rate[k] + gamma_rate * rate_0[k]
        new = inside[stages.shape[0] % 3]
        bad = plant.out_of_range(new)
        if bad >= 0:
            return bad
        for k in range(size):
            if v[k] < activation_level and new[k] >= activation_level:
                last_activation[k] = time + dt * (step + (activation_level - v[k]) / (new[k] - v[k]))
                if math.isnan(first_activation[k]):
                    first_activation[k] = last_activation[k]
            v[k] = new[k]
        if step < n_steps - 1:
            plant.relax_gates(v, gates, table, exact, dt, constants, cubed)
        else:
            plant.relax_gates(v, gates, half_table, exact, 0.5 * dt, constants, cubed)
    potential[:] = v
    return -1
