"""Steady states of a described cell, by continuation along the potential; stands in the slot of `rest`.

At every potential the gates are known; states that depend on one another are found by Newton's method from those of the
neighbouring potential. The steady current changes its sign at a steady state of the whole cell.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..numerics.compiled import compiled
from ..numerics.roots import find_root
from .cells import general as kernels
from .cells import hodgkin_huxley as cell
from .cells.hodgkin_huxley import CellConstants
from .steady import NoRestError, RestState

Floats = NDArray[np.float64]

SPACING = 0.5
"""Distance of the potentials at which the steady current is looked at [mV]."""
MOST_NEWTON = 60


def rest_state(conductances: Floats, constants: CellConstants, table: Floats, exact: bool = False) -> RestState:
    """The lowest stable steady state; START of the description, or the lowest, if none is stable."""
    return rest_states(np.reshape(conductances, (-1, 1)), constants, table, exact)[0]


def rest_states(conductances: Floats, constants: CellConstants, table: Floats, exact: bool = False) -> list[RestState]:
    """As `rest_state`, for many cells at once: conductances of shape (channels, n)."""
    found = []
    for k in range(conductances.shape[1]):
        column = np.ascontiguousarray(conductances[:, k : k + 1], dtype=np.float64)
        found.append(_Steady(column, constants, table, exact).rest())
    return found


class _Steady:
    """A cell with its conductances, (channels, 1), at held potentials."""

    def __init__(self, channels: Floats, constants: CellConstants, table: Floats, exact: bool) -> None:
        self.channels, self.constants, self.table, self.exact = channels, constants, table, exact
        low, high = zip(*((state[1], state[2]) for state in cell.STATES), strict=True)
        self.low, self.high = np.array(low, dtype=np.float64), np.array(high, dtype=np.float64)

    def rest(self) -> RestState:
        places = np.arange(cell.LOWEST + SPACING, cell.HIGHEST - SPACING, SPACING)
        states, currents = self._along(places)
        known = np.isfinite(currents)
        signs = np.sign(currents)
        crossings = np.flatnonzero((signs[:-1] != signs[1:]) & known[:-1] & known[1:])
        if crossings.size == 0:
            raise NoRestError(self._why_none(currents))
        found = []
        for low in crossings:
            found.append(self._between(float(places[low]), float(places[low + 1]), states[low]))
            if found[-1].stable:
                return found[-1]
        start = getattr(cell, "START", None)  # a pacemaker begins where its source begins
        return found[0] if start is None else RestState(start[0], tuple(start[1:]), False)

    def _along(self, places: Floats) -> tuple[Floats, Floats]:
        """States (n, N) and currents (n,) at potentials, each begun from its neighbour; nan where none is found."""
        states, currents = np.full((places.size, self.low.size), np.nan), np.full(places.size, np.nan)
        middle = 0.5 * (np.maximum(self.low, -1e3) + np.minimum(self.high, 1e3))
        guesses = [self.low + 0.1 * (middle - self.low), middle, self.low.copy()]
        for k, v in enumerate(places):
            for guess in ([states[k - 1]] if k > 0 and np.isfinite(states[k - 1]).all() else []) + guesses:
                one = self._states(float(v), guess)
                if one is not None:
                    states[k] = one
                    currents[k] = _current(float(v), one, self.channels, self.constants, self.table, self.exact)
                    break
        return states, currents

    def _states(self, v: float, guess: Floats) -> Floats | None:
        """The steady states at a held potential, or None."""
        states = guess.copy()
        row = np.empty(kernels.COLUMNS + 1)
        kernels.read_row(v, self.table, self.exact, 1.0, self.constants, row)
        states[: cell.GATES] = row[: 2 * cell.GATES : 2]
        if states.size == cell.GATES:
            return states
        jacobian = np.empty((states.size - cell.GATES,) * 2)
        scale = np.maximum(np.abs(states[cell.GATES :]), 1e-3)
        for _ in range(MOST_NEWTON):
            if not np.isfinite(states).all():
                return None
            wrong = _off_steady(v, states, self.channels, self.constants)
            for j in range(len(jacobian)):
                moved = states.copy()
                step = 1e-6 * max(abs(moved[cell.GATES + j]), 1e-6)
                moved[cell.GATES + j] += step
                jacobian[:, j] = (_off_steady(v, moved, self.channels, self.constants) - wrong) / step
            try:
                change = np.linalg.solve(jacobian, -wrong)
            except np.linalg.LinAlgError:
                return None
            new = np.clip(states[cell.GATES :] + change, self.low[cell.GATES :], self.high[cell.GATES :])
            moved_by = np.abs(new - states[cell.GATES :])
            states[cell.GATES :] = new
            scale = np.maximum(np.abs(new), 1e-12)
            if (moved_by <= 1e-12 * scale).all():
                return states
        return states if (moved_by <= 1e-8 * scale).all() else None

    def _between(self, low: float, high: float, guess: Floats) -> RestState:
        def current(v: float) -> float:
            states = self._states(v, guess)
            if states is None:
                return float("nan")
            return _current(v, states, self.channels, self.constants, self.table, self.exact)

        v = find_root(current, low, high, 1e-14)
        states = self._states(v, guess)
        assert states is not None
        return RestState(v, tuple(states.tolist()), self._is_stable(np.array([v, *states])))

    def _is_stable(self, state: Floats) -> bool:
        jacobian = np.empty((state.size, state.size))
        for k in range(state.size):
            step = 1e-6 * max(1e-3, abs(state[k]))
            up, down = state.copy(), state.copy()
            up[k] += step
            down[k] -= step
            jacobian[:, k] = (self._rates(up) - self._rates(down)) / (2.0 * step)
        return bool(np.linalg.eigvals(jacobian).real.max() < 0.0)

    def _rates(self, state: Floats) -> Floats:
        out = np.empty(state.size)
        _derivative(state, self.channels, self.constants, out)
        return out

    def _why_none(self, currents: Floats) -> str:
        known = currents[np.isfinite(currents)]
        if known.size == 0:
            return (
                f"at no potential from {cell.LOWEST:g} to {cell.HIGHEST:g} mV do its states come to rest; give the "
                "states bounds within which they do"
            )
        way = "outward" if known[0] > 0.0 else "inward"
        names = ", ".join(f"{name} = {g:g}" for name, g in zip(cell.CHANNELS, self.channels[:, 0], strict=True))
        return (
            f"at every potential from {cell.LOWEST:g} to {cell.HIGHEST:g} mV its current flows {way} ({names} "
            "mS/cm^2); change those conductances or its reversal potentials"
        )


@compiled
def _current(
    v: float, states: np.ndarray, channels: np.ndarray, constants: CellConstants, table: np.ndarray, exact: bool
) -> float:
    """Ionic current [uA/cm^2] at v with these states, functions of the potential as the sheet reads them."""
    row = np.empty(kernels.COLUMNS + 1)
    kernels.read_row(v, table, exact, 1.0, constants, row)
    instants = np.empty((kernels.INSTANT, 1))
    for i in range(cell.INSTANT):
        instants[i, 0] = row[2 * cell.GATES + i]
    return cell.current(v, states.reshape((-1, 1)), channels, instants, 0, constants)


@compiled
def _off_steady(v: float, states: np.ndarray, channels: np.ndarray, constants: CellConstants) -> np.ndarray:
    """a - b s of the states that are no gates."""
    count = states.size - cell.GATES
    rates = np.empty(2 * count + 1)
    cell.others(v, states.reshape((-1, 1)), channels, 0, constants, rates)
    out = np.empty(count)
    for k in range(count):
        out[k] = rates[2 * k] - rates[2 * k + 1] * states[cell.GATES + k]
    return out


@compiled
def _derivative(state: np.ndarray, channels: np.ndarray, constants: CellConstants, out: np.ndarray) -> None:
    """Rates [per ms] of the potential and all states."""
    v, states = state[0], state[1:].copy()
    row, instants = np.empty(2 * cell.GATES + 1), np.empty((kernels.INSTANT, 1))
    cell.gates(v, constants, row)
    cell.instant(v, constants, instants[:, 0])
    ionic = cell.current(v, states.reshape((-1, 1)), channels, instants, 0, constants)
    out[0] = -constants.kinetics_rate * ionic / constants.capacitance
    for g in range(cell.GATES):
        out[1 + g] = constants.kinetics_rate * row[2 * g + 1] * (row[2 * g] - states[g])
    wrong = _off_steady(v, states, channels, constants)
    for k in range(wrong.size):
        out[1 + cell.GATES + k] = constants.kinetics_rate * wrong[k]
