"""One muscle sheet advanced in time: gates, currents and conduction in one compiled loop, Eq. (31).

A step of length dt is G(dt/2) V(dt) G(dt/2): gates relax exactly at a held potential (Strang), the potential takes
one explicit midpoint step with held gates. Neighbouring half steps of the gates are one full step.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled
from .cells import plant
from .cells.plant import CellConstants
from .conduction import diffuse, fill_ghosts


@compiled
def _relax_gates(
    padded: np.ndarray,
    first: int,
    gates: np.ndarray,
    table: np.ndarray,
    exact: bool,
    dt: float,
    constants: CellConstants,
    cubed: np.ndarray,
) -> int:
    """Relax all gates over dt [ms] at the present potential; returns the first cell out of range, or -1."""
    row = np.empty(8)
    calcium_decay = math.exp(-dt * constants.kinetics_rate * constants.calcium_rate)
    for k in range(cubed.size):
        v = padded[first + k]
        if not plant.read_row(v, table, exact, dt, constants, row):
            return k
        x = gates[2, k]
        x_new = row[4] + (x - row[4]) * row[5]
        gates[0, k] = row[0] + (gates[0, k] - row[0]) * row[1]
        gates[1, k] = row[2] + (gates[1, k] - row[2]) * row[3]
        gates[2, k] = x_new
        inflow = constants.calcium_influx * 0.5 * (x + x_new) * (constants.calcium_entry_potential - v)
        gates[3, k] = inflow + (gates[3, k] - inflow) * calcium_decay
        cubed[k] = row[6]
    return -1


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
    table: np.ndarray,
    half_table: np.ndarray,
    exact: bool,
    activation_level: float,
    constants: CellConstants,
) -> int:
    """Advance one sheet in place by n_steps of dt [ms] from `time` [ms]; -1, or the first cell out of range.

    potential [mV], first_activation and last_activation [ms] (rise through `activation_level`, nan before): size
    n_z*n_theta, flattened (z, theta). gates: (4, n). conductances [mS/cm^2]: (5, n). coefficient: see
    `conduction.diffuse`, in 1/ms. drive: stimulus current [uA/cm^2], inward positive, and shunt:
    extra potassium conductance [mS/cm^2] (an inhibitory junction potential), both held over the call.
    """
    size = potential.size
    first = 2 * n_theta
    padded = np.empty(size + 4 * n_theta)
    middle = np.empty(size + 4 * n_theta)
    flux = np.zeros(size + 3 * n_theta)
    rate = np.empty(size)
    cubed = np.empty(size)
    fast = np.empty(size)
    slope = np.empty(size)
    offset = np.empty(size)
    conducts = coefficient.size == size - n_theta and size > n_theta
    row = np.empty(8)
    scale = constants.kinetics_rate / constants.capacitance
    calcium = constants.calcium_reversal
    padded[first : first + size] = potential
    for step in range(n_steps):
        if step == 0:
            bad = _relax_gates(padded, first, gates, half_table, exact, 0.5 * dt, constants, cubed)
        else:
            bad = _relax_gates(padded, first, gates, table, exact, dt, constants, cubed)
        if bad >= 0:
            return bad
        if conducts:
            fill_ghosts(padded, n_theta)
            diffuse(padded, coefficient, flux, rate, n_theta)
        else:
            rate[:] = 0.0
        for k in range(size):
            f, s, o = plant.current_coefficients(
                gates[0, k], gates[1, k], gates[2, k], gates[3, k], conductances, k, constants
            )
            fast[k] = f * scale
            opened = shunt[k] / constants.capacitance
            slope[k] = s * scale + opened
            offset[k] = o * scale + drive[k] / constants.capacitance + opened * constants.potassium_reversal
            v = padded[first + k]
            middle[first + k] = v + 0.5 * dt * (
                rate[k] - fast[k] * cubed[k] * (v - calcium) - slope[k] * v + offset[k]
            )
        if conducts:
            fill_ghosts(middle, n_theta)
            diffuse(middle, coefficient, flux, rate, n_theta)
        for k in range(size):
            v = middle[first + k]
            if not plant.read_row(v, table, exact, dt, constants, row):
                return k
            change = dt * (rate[k] - fast[k] * row[6] * (v - calcium) - slope[k] * v + offset[k])
            old = padded[first + k]
            new = old + change
            padded[first + k] = new
            if old < activation_level <= new:
                last_activation[k] = time + dt * (step + (activation_level - old) / change)
                if math.isnan(first_activation[k]):
                    first_activation[k] = last_activation[k]
    bad = _relax_gates(padded, first, gates, half_table, exact, 0.5 * dt, constants, cubed)
    potential[:] = padded[first : first + size]
    return bad
