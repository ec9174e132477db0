"""Plant's bursting cell: five currents and intracellular calcium, Eqs. (20)-(22).

Source: R. E. Plant, J. Math. Biol. 11 (1981); BioModels BIOMD0000000304. Units: mV, ms, mS/cm^2, uA/cm^2.
Gates are kept in the order h, n, x, c (c is calcium); m follows the potential at once.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...numerics.compiled import INDEX, compiled, inlined

Floats = NDArray[np.float64]

KIND = "cell"
NAME = "plant"
TITLE = "bursting cell of Plant (1981), the cell of the paper"
STATES = (("h", 0.0, 1.0), ("n", 0.0, 1.0), ("x", 0.0, 1.0), ("c", 0.0, 1e3))
"""Name and bounds of every state besides the potential; c is calcium."""
CALCIUM_STATE = ("c", "1")
"""Which state is calcium, and its unit: none, its half-saturation is 0.5."""
CHANNELS = ("fast_calcium", "slow_calcium", "potassium", "calcium_potassium", "leak")
"""Conductances in the order of their rows."""
INHIBITION = "potassium_reversal"
"""The constant towards which inhibiting nerves pull the potential."""
REVERSALS = ("calcium_reversal", "calcium_reversal", "potassium_reversal", "potassium_reversal", "chloride_reversal")
"""What the channels pull towards."""
FAST, SLOW, POTASSIUM, CALCIUM_POTASSIUM, LEAK = range(5)
H, N, X, C = range(4)
HELD, INSTANT = 3, 1
"""Rows of `hold`'s coefficients, and of what follows the potential at once."""

TABLE_LOW, TABLE_HIGH, TABLE_STEP = -200.0, 150.0, 0.00625
"""Range and spacing of the tables [mV]; linear between the entries."""
PER_STEP = 1.0 / TABLE_STEP


class CellConstants(NamedTuple):
    """Constants of the cell, the same in both layers; units as the parameter file states them."""

    calcium_reversal: float
    potassium_reversal: float
    chloride_reversal: float
    calcium_half_saturation: float
    calcium_rate: float
    calcium_influx: float
    calcium_entry_potential: float
    gate_time_factor: float
    slow_gate_time: float
    capacitance: float
    kinetics_rate: float


@compiled
def _ratio(x: float, scale: float) -> float:
    """x / (exp(x/scale) - 1), finite at x = 0."""
    y = x / scale
    if abs(y) < 1e-5:
        return scale * (1.0 - 0.5 * y + y * y / 12.0)
    return x / math.expm1(y)


@compiled
def fast_activation_cubed(v: float) -> float:
    """m_infinity(V)^3, the activation of the fast calcium current."""
    u = (127.0 * v + 8265.0) / 105.0
    alpha = 0.1 * _ratio(50.0 - u, 10.0)
    beta = 4.0 * math.exp((25.0 - u) / 18.0)
    m = alpha / (alpha + beta)
    return m * m * m


@compiled
def gate_targets(v: float, constants: CellConstants) -> tuple[float, float, float, float, float, float]:
    """Steady values and rates [1/ms, before the tissue's rate factor] of h, n and x at potential v [mV]."""
    u = (127.0 * v + 8265.0) / 105.0
    alpha_h = 0.07 * math.exp((25.0 - u) / 20.0)
    beta_h = 1.0 / (1.0 + math.exp((55.0 - u) / 10.0))
    alpha_n = 0.01 * _ratio(55.0 - u, 10.0)
    beta_n = 0.125 * math.exp((45.0 - u) / 80.0)
    x_steady = 1.0 / (1.0 + math.exp(0.15 * (-v - 50.0)))
    rate_h = alpha_h + beta_h
    rate_n = alpha_n + beta_n
    return (
        alpha_h / rate_h,
        rate_h / constants.gate_time_factor,
        alpha_n / rate_n,
        rate_n / constants.gate_time_factor,
        x_steady,
        1.0 / constants.slow_gate_time,
    )


@compiled
def fill_row(v: float, dt: float, constants: CellConstants, row: np.ndarray) -> None:
    """Steady values and decay factors over `dt` [ms] of h, n, x, and m^3, at v: one row of the table."""
    h, rate_h, n, rate_n, x, rate_x = gate_targets(v, constants)
    scaled = dt * constants.kinetics_rate
    row[0] = h
    row[1] = math.exp(-scaled * rate_h)
    row[2] = n
    row[3] = math.exp(-scaled * rate_n)
    row[4] = x
    row[5] = math.exp(-scaled * rate_x)
    row[6] = fast_activation_cubed(v)
    row[7] = 0.0


@compiled
def _fill_table(dt: float, constants: CellConstants, table: np.ndarray) -> None:
    for i in range(table.shape[0]):
        fill_row(TABLE_LOW + i * TABLE_STEP, dt, constants, table[i])


@lru_cache(maxsize=16)
def gate_table(dt: float, constants: CellConstants) -> Floats:
    """Table of gate coefficients for steps of `dt` [ms], shape (7001, 8), over -200...150 mV; shared, read-only.

    Decay factors belong to one step length; steady values do not, so a cell at rest in one table is at rest in
    every table made with the same constants.
    """
    rows = round((TABLE_HIGH - TABLE_LOW) / TABLE_STEP) + 1
    table = np.zeros((rows, 8))
    _fill_table(dt, constants, table)
    table.setflags(write=False)
    return table


@compiled
def read_row(v: float, table: np.ndarray, exact: bool, dt: float, constants: CellConstants, row: np.ndarray) -> bool:
    """Coefficients at v, interpolated from the table or computed (`exact`); False outside the table's range."""
    if not (v > TABLE_LOW and v < TABLE_HIGH):
        return False
    if exact:
        fill_row(v, dt, constants, row)
        return True
    position = (v - TABLE_LOW) * PER_STEP
    index = int(position)
    fraction = position - index
    for k in range(7):
        low = table[index, k]
        row[k] = low + fraction * (table[index + 1, k] - low)
    return True


@compiled
def out_of_range(v: np.ndarray) -> int:
    """Index of the first potential outside the table (or not a number), -1 if there is none."""
    return first_outside(v, min(0, v.size), v.size)


@compiled
def first_outside(v: np.ndarray, low: int, high: int) -> int:
    """`out_of_range` among the cells low...high - 1."""
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
    """Relax h, n, x, c over dt [ms] at held potentials (in range), and leave m^3 at these in `instant`, (1, n)."""
    relax_cells(v, gates, table, exact, dt, constants, instant, channels, min(0, v.size), v.size)


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
    cubed = instant[0]
    calcium_decay = math.exp(-dt * constants.kinetics_rate * constants.calcium_rate)
    influx = 0.5 * constants.calcium_influx
    entry = constants.calcium_entry_potential
    if exact:
        row = np.empty(8)
        for k in range(low, high):
            fill_row(v[k], dt, constants, row)
            x = gates[2, k]
            gates[0, k] = row[0] + (gates[0, k] - row[0]) * row[1]
            gates[1, k] = row[2] + (gates[1, k] - row[2]) * row[3]
            gates[2, k] = row[4] + (x - row[4]) * row[5]
            inflow = influx * (x + gates[2, k]) * (entry - v[k])
            gates[3, k] = inflow + (gates[3, k] - inflow) * calcium_decay
            cubed[k] = row[6]
        return
    for k in range(low, high):
        position = (v[k] - TABLE_LOW) * PER_STEP
        i = int(position) & INDEX
        f = position - i
        g = 1.0 - f
        h_steady = g * table[i, 0] + f * table[i + 1, 0]
        h_decay = g * table[i, 1] + f * table[i + 1, 1]
        n_steady = g * table[i, 2] + f * table[i + 1, 2]
        n_decay = g * table[i, 3] + f * table[i + 1, 3]
        x_steady = g * table[i, 4] + f * table[i + 1, 4]
        x_decay = g * table[i, 5] + f * table[i + 1, 5]
        cubed[k] = g * table[i, 6] + f * table[i + 1, 6]
        x = gates[2, k]
        x_new = x_steady + (x - x_steady) * x_decay
        gates[0, k] = h_steady + (gates[0, k] - h_steady) * h_decay
        gates[1, k] = n_steady + (gates[1, k] - n_steady) * n_decay
        gates[2, k] = x_new
        inflow = influx * (x + x_new) * (entry - v[k])
        gates[3, k] = inflow + (gates[3, k] - inflow) * calcium_decay


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
    """What follows the potential at once, m_infinity^3, of the cells low...high - 1 into `instant`, (1, n)."""
    low, high = low & INDEX, high & INDEX
    cubed = instant[0]
    if exact:
        for k in range(low, high):
            cubed[k] = fast_activation_cubed(v[k])
        return
    for k in range(low, high):
        position = (v[k] - TABLE_LOW) * PER_STEP
        i = int(position) & INDEX
        f = position - i
        cubed[k] = (1.0 - f) * table[i, 6] + f * table[i + 1, 6]


@inlined
def current_coefficients(
    h: float, n: float, x: float, c: float, conductances: np.ndarray, node: int, constants: CellConstants
) -> tuple[float, float, float]:
    """(fast, slope, offset) with I_ion = fast*m^3*(V - V_Ca) + slope*V - offset at these gates, Eq. (21)."""
    calcium = constants.calcium_reversal
    slow = conductances[SLOW, node] * x
    n2 = n * n
    potassium = conductances[POTASSIUM, node] * n2 * n2
    potassium += conductances[CALCIUM_POTASSIUM, node] * c / (constants.calcium_half_saturation + c)
    leak = conductances[LEAK, node]
    return (
        conductances[FAST, node] * h,
        slow + potassium + leak,
        slow * calcium + potassium * constants.potassium_reversal + leak * constants.chloride_reversal,
    )


@compiled
def hold(
    gates: np.ndarray,
    conductances: np.ndarray,
    drive: np.ndarray,
    shunt: np.ndarray,
    dt: float,
    constants: CellConstants,
    low: int,
    high: int,
    held: np.ndarray,
) -> None:
    """Coefficients of the current with gates held over a step of dt [ms], cells low...high - 1, into `held`, (3, n).

    Its rows are fast, slope and offset: -dt I/C = offset - slope*V - fast*m^3(V)*(V - V_Ca) [mV], stimulus and shunt
    included.
    """
    low, high = low & INDEX, high & INDEX
    scale = dt * constants.kinetics_rate / constants.capacitance
    per_capacitance = dt / constants.capacitance
    for k in range(low, high):
        f, s, o = current_coefficients(gates[0, k], gates[1, k], gates[2, k], gates[3, k], conductances, k, constants)
        held[0, k] = scale * f
        held[1, k] = scale * s + per_capacitance * shunt[k]
        held[2, k] = scale * o + per_capacitance * drive[k]


@inlined
def with_current(
    rate: float, v: float, held: np.ndarray, instant: np.ndarray, node: int, constants: CellConstants
) -> float:
    """A change over a step [mV] and that by the held current at potential v: rate - dt I/C; see `hold`."""
    return (
        rate - held[0, node] * instant[0, node] * (v - constants.calcium_reversal) - held[1, node] * v + held[2, node]
    )


def leakiness(conductances: Floats, constants: CellConstants) -> float:
    """Largest sum of the conductances of a cell [mS/cm^2]; conductances: (5, n)."""
    return float(conductances.sum(axis=0).max())


def standing_current(conductances: Floats, constants: CellConstants) -> tuple[float, float]:
    """Current at 0 mV [uA/cm^2] and conductance [mS/cm^2] of a cell with every channel open but the fast one.

    The fast channel inactivates, and channels that are closed hold a cell back even less. conductances: (5,).
    """
    g = constants.kinetics_rate * conductances
    g[FAST] = 0.0
    return float(g @ np.array([getattr(constants, name) for name in REVERSALS])), float(g.sum())


def currents(v: Floats, gates: Floats, conductances: Floats, constants: CellConstants) -> dict[str, Floats]:
    """The five currents [uA/cm^2] by name; v: shape (n,), gates: (4, n), conductances: (5, n) [mS/cm^2]."""
    h, n, x, c = gates
    m3 = np.array([fast_activation_cubed(float(value)) for value in np.ravel(v)]).reshape(np.shape(v))
    fast, slow, potassium, calcium_potassium, leak = conductances
    to_calcium = v - constants.calcium_reversal
    to_potassium = v - constants.potassium_reversal
    return {
        "fast_calcium": fast * m3 * h * to_calcium,
        "slow_calcium": slow * x * to_calcium,
        "potassium": potassium * n**4 * to_potassium,
        "calcium_potassium": calcium_potassium * c / (constants.calcium_half_saturation + c) * to_potassium,
        "leak": leak * (v - constants.chloride_reversal),
    }
