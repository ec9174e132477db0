"""The true resting state of a cell: solved for, and checked for stability, Eq. (23)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled
from ..numerics.roots import find_root
from .cells import plant
from .cells.plant import CellConstants
from .steady import NoRestError, RestState

Floats = NDArray[np.float64]


@compiled
def _steady_currents(
    v: np.ndarray,
    table: np.ndarray,
    exact: bool,
    conductances: np.ndarray,
    constants: CellConstants,
    currents: np.ndarray,
) -> None:
    """Ionic current [uA/cm^2] at potentials v [mV] with every gate and calcium at its steady value."""
    row = np.zeros(8)
    for k in range(v.size):
        plant.read_row(v[k], table, exact, 1.0, constants, row)
        c = constants.calcium_influx * row[4] * (constants.calcium_entry_potential - v[k])
        fast, slope, offset = plant.current_coefficients(row[0], row[2], row[4], c, conductances, 0, constants)
        currents[k] = fast * row[6] * (v[k] - constants.calcium_reversal) + slope * v[k] - offset


def _steady_gates(v: float, table: Floats, exact: bool, constants: CellConstants) -> tuple[float, float, float, float]:
    row = np.zeros(8)
    plant.read_row(v, table, exact, 1.0, constants, row)
    h, _, n, _, x, _, _, _ = row.tolist()
    return h, n, x, constants.calcium_influx * x * (constants.calcium_entry_potential - v)


def _derivative(state: Floats, conductances: Floats, constants: CellConstants) -> Floats:
    v, h, n, x, c = state
    h_steady, rate_h, n_steady, rate_n, x_steady, rate_x = plant.gate_targets(v, constants)
    fast, slope, offset = plant.current_coefficients(h, n, x, c, conductances, 0, constants)
    current = fast * plant.fast_activation_cubed(v) * (v - constants.calcium_reversal) + slope * v - offset
    inflow = constants.calcium_influx * x * (constants.calcium_entry_potential - v)
    return constants.kinetics_rate * np.array(
        [
            -current / constants.capacitance,
            rate_h * (h_steady - h),
            rate_n * (n_steady - n),
            rate_x * (x_steady - x),
            constants.calcium_rate * (inflow - c),
        ]
    )


def _is_stable(state: Floats, conductances: Floats, constants: CellConstants) -> bool:
    jacobian = np.empty((5, 5))
    for k in range(5):
        step = 1e-6 * max(1.0, abs(state[k]))
        up, down = state.copy(), state.copy()
        up[k] += step
        down[k] -= step
        slope = _derivative(up, conductances, constants) - _derivative(down, conductances, constants)
        jacobian[:, k] = slope / (2.0 * step)
    return bool(np.linalg.eigvals(jacobian).real.max() < 0.0)


def rest_state(conductances: Floats, constants: CellConstants, table: Floats, exact: bool = False) -> RestState:
    """The lowest steady state in the range of the tables; `stable` says whether the cell stays on it.

    Only where calcium is positive: below `calcium_entry_potential`.

    conductances: the five maximal conductances [mS/cm^2], shape (5,), order of `plant.CHANNELS`. The root is
    found with the coefficients that the sheet uses (table or exact), so that the sheet starts without a twitch.
    Raises NoRestError when there is no steady state in the range.
    """
    return rest_states(np.reshape(conductances, (5, 1)), constants, table, exact)[0]


def rest_states(conductances: Floats, constants: CellConstants, table: Floats, exact: bool = False) -> list[RestState]:
    """As `rest_state`, for many cells at once: conductances of shape (5, n)."""
    kinds = np.ascontiguousarray(conductances, dtype=np.float64)
    # The steady current is linear in the conductances, so one scan of the gates serves every cell.
    units = np.empty((5, _SCAN.size))
    for unit, values in zip(np.eye(5), units, strict=True):
        _steady_currents(_SCAN, table, exact, unit.reshape(5, 1).copy(), constants, values)
    states = []
    for k in range(kinds.shape[1]):
        values = kinds[:, k] @ units
        crossings = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
        crossings = crossings[_SCAN[crossings + 1] <= constants.calcium_entry_potential]
        if crossings.size == 0:
            raise NoRestError(_why_none(kinds[:, k], units, constants))
        low = int(crossings[0])
        states.append(_settle(_SCAN[low], _SCAN[low + 1], kinds[:, k : k + 1].copy(), constants, table, exact))
    return states


_SCAN = np.concatenate(
    [np.arange(-199.95, -100.0, 0.05), np.linspace(-100.0, 0.0, 2001), np.arange(0.05, 149.99, 0.05)]
)
"""Potentials at which the sign of the steady current is looked at [mV], within the tables."""


def _why_none(conductances: Floats, units: Floats, constants: CellConstants) -> str:
    """Cause and cure where the steady current never changes its sign. units: currents of unit conductances."""
    allowed = constants.calcium_entry_potential >= _SCAN
    if not allowed.any():
        return (
            f"cell.calcium_entry_potential = {constants.calcium_entry_potential:g} mV leaves the cell no potential at "
            "which its calcium is positive; raise it"
        )
    if not conductances.any():
        return f"all its conductances ({', '.join(plant.CHANNELS)}) are 0, so nothing sets a potential; open one"
    currents = conductances[:, None] * units[:, allowed]
    outward = bool(currents.sum(axis=0)[0] > 0.0)
    shares = currents[:, 0 if outward else -1] * (1.0 if outward else -1.0)
    strongest = int(np.argmax(shares))
    reversal = plant.REVERSALS[strongest]
    return (
        f"at every potential from {_SCAN[0]:.0f} to {_SCAN[allowed][-1]:.0f} mV the current flows "
        f"{'outward' if outward else 'inward'}, most of it through {plant.CHANNELS[strongest]} = "
        f"{conductances[strongest]:g} mS/cm^2 towards cell.{reversal} = {getattr(constants, reversal):g} mV; bring "
        "that reversal potential into the range, or lower that conductance"
    )


def _settle(low: float, high: float, column: Floats, constants: CellConstants, table: Floats, exact: bool) -> RestState:
    """The steady state between two potentials."""

    def current(v: float) -> float:
        value = np.empty(1)
        _steady_currents(np.array([v]), table, exact, column, constants, value)
        return float(value[0])

    v = find_root(current, float(low), float(high), 1e-14)
    h, n, x, c = _steady_gates(v, table, exact, constants)
    stable = _is_stable(np.array([v, h, n, x, c]), column, constants)
    return RestState(v, (h, n, x, c), stable)
