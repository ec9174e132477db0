"""Kernels of a cell made from its description: any number of gates, other states and currents, Eq. (21) in general.

Stands in the slot of `plant`, with a description in the slot of `hodgkin_huxley`. What depends on the potential alone
(steady values, decays, instantaneous functions) is read from tables; gates relax exactly at a held potential
(Rush-Larsen), other states s' = a - b s by an exponential step of second order, whose source and decay are taken at the
mean of the old states and of those that a first step foresees.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...numerics.compiled import INDEX, compiled, inlined
from . import hodgkin_huxley as cell
from .hodgkin_huxley import CellConstants

Floats = NDArray[np.float64]

STATES, CHANNELS, INHIBITION = cell.STATES, cell.CHANNELS, cell.INHIBITION
N_STATES, N_GATES, N_CHANNELS = len(cell.STATES), cell.GATES, len(cell.CHANNELS)
N_OTHERS = N_STATES - N_GATES
INSTANT = max(cell.INSTANT, 1)
HELD = N_STATES + N_CHANNELS + 3
"""Rows of held coefficients: states, channels, and the scales of current, shunt and stimulus."""
CURRENT, SHUNT, STIMULUS = N_STATES + N_CHANNELS, N_STATES + N_CHANNELS + 1, N_STATES + N_CHANNELS + 2
COLUMNS = 2 * N_GATES + cell.INSTANT

TABLE_LOW, TABLE_HIGH, TABLE_STEP = cell.LOWEST, cell.HIGHEST, 0.00625
PER_STEP = 1.0 / TABLE_STEP


@compiled
def fill_row(v: float, dt: float, constants: CellConstants, row: np.ndarray) -> None:
    """Steady value and decay over `dt` [ms] of every gate in turn, then the instantaneous functions, at v."""
    cell.gates(v, constants, row)
    scaled = dt * constants.kinetics_rate
    for g in range(N_GATES):
        row[2 * g + 1] = math.exp(-scaled * row[2 * g + 1])
    cell.instant(v, constants, row[2 * N_GATES :])


@compiled
def _fill_table(dt: float, constants: CellConstants, table: np.ndarray) -> None:
    for i in range(table.shape[0]):
        fill_row(TABLE_LOW + i * TABLE_STEP, dt, constants, table[i])


@lru_cache(maxsize=16)
def gate_table(dt: float, constants: CellConstants) -> Floats:
    """Table of `fill_row` for steps of `dt` [ms] over the cell's range of potentials; shared, read-only."""
    rows = round((TABLE_HIGH - TABLE_LOW) / TABLE_STEP) + 1
    table = np.zeros((rows, COLUMNS + 1))
    _fill_table(dt, constants, table)
    table.setflags(write=False)
    return table


@compiled
def read_row(v: float, table: np.ndarray, exact: bool, dt: float, constants: CellConstants, row: np.ndarray) -> bool:
    """Coefficients at v, interpolated from the table or computed (`exact`); False outside the cell's range."""
    if not (v > TABLE_LOW and v < TABLE_HIGH):
        return False
    if exact:
        fill_row(v, dt, constants, row)
        return True
    position = (v - TABLE_LOW) * PER_STEP
    index = int(position)
    fraction = position - index
    for k in range(COLUMNS):
        row[k] = table[index, k] + fraction * (table[index + 1, k] - table[index, k])
    return True


@compiled
def first_outside(v: np.ndarray, low: int, high: int) -> int:
    """Index of the first of the cells low...high - 1 outside its range (or not a number), -1 if there is none."""
    low, high = low & INDEX, high & INDEX
    inside = 0
    for k in range(low, high):
        inside += 1 if (v[k] > TABLE_LOW) & (v[k] < TABLE_HIGH) else 0
    if inside >= high - low:
        return -1
    for k in range(low, high):
        if not (v[k] > TABLE_LOW and v[k] < TABLE_HIGH):
            return k
    return -1


@compiled
def out_of_range(v: np.ndarray) -> int:
    """`first_outside` among all cells."""
    return first_outside(v, 0, v.size)


@compiled
def relax_gates(
    v: np.ndarray,
    gates: np.ndarray,
    table: np.ndarray,
    exact: bool,
    dt: float,
    constants: CellConstants,
    instant: np.ndarray,
    channels: np.ndarray,
) -> None:
    """Relax all states over dt [ms] at held potentials (in range), and leave the instantaneous functions at these."""
    relax_cells(v, gates, table, exact, dt, constants, instant, channels, 0, v.size)


@inlined
def _factor(decay: float, dt: float) -> float:
    """(1 - exp(-b dt)) / b, finite at b = 0."""
    x = decay * dt
    small = abs(x) < 1e-8
    return dt * (1.0 - 0.5 * x) if small else -math.expm1(-x) / (decay if not small else 1.0)


@compiled
def relax_cells(
    v: np.ndarray,
    gates: np.ndarray,
    table: np.ndarray,
    exact: bool,
    dt: float,
    constants: CellConstants,
    instant: np.ndarray,
    channels: np.ndarray,
    low: int,
    high: int,
) -> None:
    """`relax_gates` of the cells low...high - 1."""
    low, high = low & INDEX, high & INDEX
    row = np.empty(COLUMNS + 1)
    scaled = dt * constants.kinetics_rate
    before, rates = np.empty((N_STATES, 1)), np.empty(2 * N_OTHERS + 1)
    mean = np.empty((N_STATES, 1))
    one = np.empty((N_CHANNELS, 1))
    for k in range(low, high):
        read_row(v[k], table, exact, dt, constants, row)
        if N_OTHERS > 0:
            for c in range(N_CHANNELS):
                one[c, 0] = channels[c, k]
            for s in range(N_STATES):
                before[s, 0] = gates[s, k]
        for g in range(N_GATES):
            gates[g, k] = row[2 * g] + (gates[g, k] - row[2 * g]) * row[2 * g + 1]
        for i in range(cell.INSTANT):
            instant[i, k] = row[2 * N_GATES + i]
        if N_OTHERS > 0:
            # Once with the states as they were, to foresee the end, and once with the means of both.
            for s in range(N_STATES):
                mean[s, 0] = before[s, 0]
            for g in range(N_GATES):
                mean[g, 0] = 0.5 * (before[g, 0] + gates[g, k])
            for _ in range(2):
                cell.others(v[k], mean, one, 0, constants, rates)
                for s in range(N_OTHERS):
                    old, source, decay = before[N_GATES + s, 0], rates[2 * s], rates[2 * s + 1]
                    new = old + (source - decay * old) * _factor(decay, scaled)
                    gates[N_GATES + s, k] = new
                    mean[N_GATES + s, 0] = 0.5 * (old + new)


@compiled
def respond(
    v: np.ndarray,
    table: np.ndarray,
    exact: bool,
    constants: CellConstants,
    instant: np.ndarray,
    low: int,
    high: int,
) -> None:
    """The instantaneous functions at the potentials (in range) of the cells low...high - 1 into `instant`."""
    low, high = low & INDEX, high & INDEX
    if exact:
        row = np.empty(cell.INSTANT + 1)
        for k in range(low, high):
            cell.instant(v[k], constants, row)
            for j in range(cell.INSTANT):
                instant[j, k] = row[j]
        return
    for k in range(low, high):
        position = (v[k] - TABLE_LOW) * PER_STEP
        i = int(position) & INDEX
        f = position - i
        for j in range(cell.INSTANT):
            c = 2 * N_GATES + j
            instant[j, k] = (1.0 - f) * table[i, c] + f * table[i + 1, c]


@compiled
def hold(
    gates: np.ndarray,
    channels: np.ndarray,
    drive: np.ndarray,
    shunt: np.ndarray,
    dt: float,
    constants: CellConstants,
    low: int,
    high: int,
    held: np.ndarray,
) -> None:
    """States and channels held over a step of dt [ms], and the scales of current, shunt and stimulus, (HELD, n)."""
    low, high = low & INDEX, high & INDEX
    scale = dt * constants.kinetics_rate / constants.capacitance
    per_capacitance = dt / constants.capacitance
    for k in range(low, high):
        for s in range(N_STATES):
            held[s, k] = gates[s, k]
        for c in range(N_CHANNELS):
            held[N_STATES + c, k] = channels[c, k]
        held[CURRENT, k] = scale
        held[SHUNT, k] = per_capacitance * shunt[k]
        held[STIMULUS, k] = per_capacitance * drive[k]


@inlined
def with_current(
    rate: float, v: float, held: np.ndarray, instant: np.ndarray, node: int, constants: CellConstants
) -> float:
    """A change over a step [mV] and that by the held current at potential v: rate - dt I/C; see `hold`."""
    ionic = cell.current(v, held[:N_STATES], held[N_STATES:CURRENT], instant, node, constants)
    return rate - held[CURRENT, node] * ionic - held[SHUNT, node] * v + held[STIMULUS, node]


def leakiness(conductances: Floats, constants: CellConstants) -> float:
    """Largest slope of the current by the potential [mS/cm^2], states at either bound; conductances: (channels, n)."""
    return _steepest(conductances.max(axis=1).tobytes(), constants)


@lru_cache(maxsize=64)
def _steepest(largest: bytes, constants: CellConstants) -> float:
    channels = np.frombuffer(largest).reshape(-1, 1).copy()
    v = np.arange(cell.LOWEST + 1.0, cell.HIGHEST - 1.0, 0.5)
    found = np.empty(v.size)
    steepest = 0.0
    for end in (1, 2):
        states = np.array([state[end] for state in cell.STATES], dtype=np.float64).reshape(-1, 1)
        _currents_along(v, states, channels, constants, found)
        slopes = np.diff(found) / np.diff(v)
        steepest = max(steepest, float(slopes[np.isfinite(slopes)].max(initial=0.0)))
    return steepest


@compiled
def _currents_along(
    v: np.ndarray, states: np.ndarray, channels: np.ndarray, constants: CellConstants, out: np.ndarray
) -> None:
    """Ionic current [uA/cm^2] at potentials v with the same states, (N_STATES, 1)."""
    instants = np.empty((INSTANT, 1))
    for k in range(v.size):
        cell.instant(v[k], constants, instants[:, 0])
        out[k] = cell.current(v[k], states, channels, instants, 0, constants)


def standing_current(conductances: Floats, constants: CellConstants) -> tuple[float, float]:
    """Nothing is known of the current with every channel open but its steepest slope; see `plant.standing_current`."""
    return 0.0, constants.kinetics_rate * leakiness(conductances.reshape(-1, 1), constants)


def currents(v: Floats, states: Floats, conductances: Floats, constants: CellConstants) -> dict[str, Floats]:
    """The current [uA/cm^2] that ceases with each channel, by its name, and what is left without any as "other".

    v: (n,), states: (states, n), conductances: (channels, n) [mS/cm^2].
    """
    found = np.empty((N_CHANNELS + 1, v.size))
    _currents_by_channel(v, np.ascontiguousarray(states), np.ascontiguousarray(conductances), constants, found)
    shares = dict(zip(CHANNELS, found, strict=False))
    return shares if not found[-1].any() else shares | {"other": found[-1]}


@compiled
def _currents_by_channel(
    v: np.ndarray, states: np.ndarray, channels: np.ndarray, constants: CellConstants, out: np.ndarray
) -> None:
    instants = np.empty((INSTANT, v.size))
    alone = np.zeros((N_CHANNELS, v.size))
    for k in range(v.size):
        cell.instant(v[k], constants, instants[:, k])
        out[N_CHANNELS, k] = cell.current(v[k], states, alone, instants, k, constants)
        for c in range(N_CHANNELS):
            alone[c, k] = channels[c, k]
            out[c, k] = cell.current(v[k], states, alone, instants, k, constants) - out[N_CHANNELS, k]
            alone[c, k] = 0.0
