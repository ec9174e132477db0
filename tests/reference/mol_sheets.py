"""Method of lines, the two sheets: second-order finite volumes, Crank-Nicolson diffusion, explicit kinetics.

Strang's splitting: diffusion over half a step, kinetics over a whole one (explicit midpoint rule on all five
variables), diffusion over the other half. Rates are evaluated directly. Time in ms, potential in mV.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.optimize import brentq

from reference.constants import Constants, Layer


class Kinetics(NamedTuple):
    """What the compiled functions need of a layer's cells."""

    fast: float
    slow: float
    potassium: float
    calcium_potassium: float
    leak: float
    reversal_calcium: float
    reversal_potassium: float
    reversal_leak: float
    half_saturation: float
    calcium_rate: float
    calcium_influx: float
    calcium_entry: float
    gate_factor: float
    slow_time: float
    kappa: float
    capacitance: float


def kinetics_of(c: Constants, layer: Layer) -> Kinetics:
    """Constants of the cells of one layer."""
    return Kinetics(
        layer.fast, layer.slow, layer.potassium, layer.calcium_potassium, layer.leak, c.reversal_calcium,
        c.reversal_potassium, c.reversal_leak, c.half_saturation, c.calcium_rate, c.calcium_influx, c.calcium_entry,
        c.gate_factor, c.slow_time, c.kinetics, c.capacitance,
    )  # fmt: skip


@njit(cache=True)
def ratio(argument: float) -> float:
    """y/(e^y - 1), with its limit at 0."""
    if abs(argument) < 1e-7:
        return 1.0 - 0.5 * argument
    return argument / np.expm1(argument)


@njit(cache=True)
def rates(v: float, h: float, n: float, x: float, c: float, stimulus: float, shunt: float, k: Kinetics):
    """Derivatives of V, h, n, x, c per ms, (20) to (22), with stimulus [µA/cm^2] and potassium shunt [mS/cm^2]."""
    u = (127.0 * v + 8265.0) / 105.0
    am, bm = ratio((50.0 - u) / 10.0), 4.0 * np.exp((25.0 - u) / 18.0)
    ah, bh = 0.07 * np.exp((25.0 - u) / 20.0), 1.0 / (1.0 + np.exp((55.0 - u) / 10.0))
    an, bn = 0.1 * ratio((55.0 - u) / 10.0), 0.125 * np.exp((45.0 - u) / 80.0)
    m = am / (am + bm)
    current = (
        (k.fast * m * m * m * h + k.slow * x) * (v - k.reversal_calcium)
        + (k.potassium * n**4 + k.calcium_potassium * c / (k.half_saturation + c)) * (v - k.reversal_potassium)
        + k.leak * (v - k.reversal_leak)
    )
    dv = (stimulus - k.kappa * current - shunt * (v - k.reversal_potassium)) / k.capacitance
    dh = k.kappa * (ah * (1.0 - h) - bh * h) / k.gate_factor
    dn = k.kappa * (an * (1.0 - n) - bn * n) / k.gate_factor
    dx = k.kappa * (1.0 / (1.0 + np.exp(0.15 * (-v - 50.0))) - x) / k.slow_time
    dc = k.kappa * k.calcium_rate * (k.calcium_influx * x * (k.calcium_entry - v) - c)
    return dv, dh, dn, dx, dc


def rest(c: Constants, layer: Layer) -> np.ndarray:
    """The lowest root of the steady current: V, h, n, x, c (23)."""
    k = kinetics_of(c, layer)

    def steady(v: float) -> np.ndarray:
        _, h0, n0, x0, _ = rates(v, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, k)
        _, h1, n1, _, _ = rates(v, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, k)
        x = x0 * k.slow_time / k.kappa
        return np.array([v, h0 / (h0 - h1), n0 / (n0 - n1), x, k.calcium_influx * x * (k.calcium_entry - v)])

    def current(v: float) -> float:
        return rates(*steady(v), 0.0, 0.0, k)[0]

    grid = np.linspace(-74.9, -30.0, 2000)
    values = [current(v) for v in grid]
    first = next(i for i in range(len(grid) - 1) if values[i] * values[i + 1] <= 0.0)
    return steady(brentq(current, grid[first], grid[first + 1], xtol=1e-13))


@njit(cache=True)
def react(cells: np.ndarray, dt: float, stimulus: np.ndarray, shunt: np.ndarray, k: Kinetics) -> None:
    """Explicit midpoint step of all cells (5, n), in place."""
    for i in range(cells.shape[1]):
        v, h, n, x, c = cells[0, i], cells[1, i], cells[2, i], cells[3, i], cells[4, i]
        a, b, d, e, f = rates(v, h, n, x, c, stimulus[i], shunt[i], k)
        half = 0.5 * dt
        a, b, d, e, f = rates(
            v + half * a, h + half * b, n + half * d, x + half * e, c + half * f, stimulus[i], shunt[i], k
        )
        cells[0, i] = v + dt * a
        cells[1, i] = h + dt * b
        cells[2, i] = n + dt * d
        cells[3, i] = x + dt * e
        cells[4, i] = c + dt * f


@njit(cache=True)
def diffuse(v: np.ndarray, dt: float, conductance: np.ndarray, h: float, work: np.ndarray) -> None:
    """Crank-Nicolson step of v_t = ∂_z(d ∂_z v), d (n + 1) at faces [cm^2/ms], sealed ends, in place (Thomas)."""
    n = v.shape[0]
    r = 0.5 * dt / (h * h)
    last = v[0]
    slope = 1.0
    for i in range(n):
        left = r * conductance[i] if i > 0 else 0.0
        right = r * conductance[i + 1] if i < n - 1 else 0.0
        here = v[i]
        value = here
        if i > 0:
            value += left * (last - here)
        if i < n - 1:
            value += right * (v[i + 1] - here)
        last = here
        slope = 1.0 + left + right
        if i > 0:
            slope -= left * work[i - 1]
            value += left * v[i - 1]
        work[i] = right / slope
        v[i] = value / slope
    for i in range(n - 2, -1, -1):
        v[i] += work[i] * v[i + 1]


@njit(cache=True)
def covered(begin: float, end: float, a: float, b: float) -> float:
    """Share of [a, b] inside [begin, end]."""
    return max(0.0, min(end, b) - max(begin, a)) / (b - a)


@njit(cache=True)
def march(
    cells: np.ndarray,
    begin: float,
    end: float,
    steps: int,
    conductance: np.ndarray,
    h: float,
    pulses: np.ndarray,
    onset: np.ndarray,
    trigger: np.ndarray,
    k: Kinetics,
) -> None:
    """Both parts over `steps` steps from begin to end [ms], in place.

    pulses (m, 6): first and last cell, times [ms], µA/cm^2, mS/cm^2 (potassium). onset (n): start of the triggered
    pulse of each cell [ms]; trigger: its intensity and duration.
    """
    n = cells.shape[1]
    dt = (end - begin) / steps
    stimulus, shunt, work = np.zeros(n), np.zeros(n), np.zeros(n)
    for step in range(steps):
        a = begin + step * dt
        stimulus[:] = 0.0
        shunt[:] = 0.0
        for m in range(pulses.shape[0]):
            share = covered(pulses[m, 2], pulses[m, 3], a, a + dt)
            if share > 0.0:
                for i in range(int(pulses[m, 0]), int(pulses[m, 1])):
                    stimulus[i] += share * pulses[m, 4]
                    shunt[i] += share * pulses[m, 5]
        for i in range(n):
            if onset[i] > -1e9:
                stimulus[i] += trigger[0] * covered(onset[i], onset[i] + trigger[1], a, a + dt)
        diffuse(cells[0], 0.5 * dt, conductance, h, work)
        react(cells, dt, stimulus, shunt, k)
        diffuse(cells[0], 0.5 * dt, conductance, h, work)
