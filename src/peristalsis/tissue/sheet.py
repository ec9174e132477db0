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
    v_now = padded[first : first + size]
    v_middle = middle[first : first + size]
    flux = np.zeros(size + 3 * n_theta)
    rate = np.zeros(size)
    cubed = np.empty(size)
    fast = np.empty(size)
    slope = np.empty(size)
    offset = np.empty(size)
    conducts = coefficient.size == size - n_theta and size > n_theta
    scale = dt * constants.kinetics_rate / constants.capacitance
    per_capacitance = dt / constants.capacitance
    calcium = constants.calcium_reversal
    v_now[:] = potential
    bad = plant.out_of_range(v_now)
    if bad >= 0:
        return bad
    plant.relax_gates(v_now, gates, half_table, exact, 0.5 * dt, constants, cubed)
    for step in range(n_steps):
        if conducts:
            fill_ghosts(padded, n_theta)
            diffuse(padded, coefficient, flux, rate, n_theta)
        for k in range(size):
            f, s, o = plant.current_coefficients(
                gates[0, k], gates[1, k], gates[2, k], gates[3, k], conductances, k, constants
            )
            opened = per_capacitance * shunt[k]
            fast[k] = scale * f
            slope[k] = scale * s + opened
            offset[k] = scale * o + per_capacitance * drive[k] + opened * constants.potassium_reversal
            v = v_now[k]
            change = dt * rate[k] - fast[k] * cubed[k] * (v - calcium) - slope[k] * v + offset[k]
            v_middle[k] = v + 0.5 * change
        bad = plant.out_of_range(v_middle)
        if bad >= 0:
            return bad
        if conducts:
            fill_ghosts(middle, n_theta)
            diffuse(middle, coefficient, flux, rate, n_theta)
        plant.activation_cubed(v_middle, table, exact, cubed)
        for k in range(size):
            v = v_middle[k]
            change = dt * rate[k] - fast[k] * cubed[k] * (v - calcium) - slope[k] * v + offset[k]
            old = v_now[k]
            new = old + change
            v_now[k] = new
            if old < activation_level and new >= activation_level:
                last_activation[k] = time + dt * (step + (activation_level - old) / change)
                if math.isnan(first_activation[k]):
                    first_activation[k] = last_activation[k]
        bad = plant.out_of_range(v_now)
        if bad >= 0:
            return bad
        if step < n_steps - 1:
            plant.relax_gates(v_now, gates, table, exact, dt, constants, cubed)
        else:
            plant.relax_gates(v_now, gates, half_table, exact, 0.5 * dt, constants, cubed)
    potential[:] = v_now
    return -1
