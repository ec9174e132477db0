"""One cell by the sheet's own kernel against an independent solution, Eqs. (20)-(22) and (31)."""

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from verification.problems.cell import BURSTING_START, ReferenceCell
from verification.problems.orders import assert_order

from peristalsis.build import cell_constants
from peristalsis.config import Configuration
from peristalsis.numerics.stabilised import coefficients
from peristalsis.tissue.cells.plant import CellConstants, gate_table
from peristalsis.tissue.sheet import advance_sheet

Floats = NDArray[np.float64]

MUSCLE = ReferenceCell(slow=0.004, rate=0.125)
PULSE, WATCH, AFTER = 50.0, 100.0, 1400.0
"""A pulse of 50 ms, then the spike and its repolarisation; V is compared every 100 ms and over the upstroke."""


def constants(rate: float) -> CellConstants:
    return cell_constants(Configuration(), rate)


class Cell:
    """A sheet of one cell: no conduction."""

    def __init__(self, start: Floats, slow: float, rate: float, dt: float, exact: bool) -> None:
        self.constants = constants(rate)
        self.dt, self.exact, self.time = dt, exact, 0.0
        self.table, self.half = gate_table(dt, self.constants), gate_table(0.5 * dt, self.constants)
        self.potential = np.array([start[0]])
        self.gates = np.array(start[1:]).reshape(4, 1)
        self.conductances = np.array([4.0, slow, 0.3, 0.03, 0.003]).reshape(5, 1)
        self.first, self.latest = np.full(1, np.nan), np.full(1, np.nan)

    def advance(self, steps: int, stimulus: float = 0.0) -> float:
        verdict = advance_sheet(
            self.potential,
            self.gates,
            self.first,
            self.latest,
            self.conductances,
            np.empty(0),
            np.array([stimulus]),
            np.zeros(1),
            1,
            self.time,
            self.dt,
            steps,
            coefficients(2),
            self.table,
            self.half,
            self.exact,
            -40.0,
            self.constants,
        )
        assert verdict == -1
        self.time += steps * self.dt
        return float(self.potential[0])


@cache
def resting_start() -> tuple[float, ...]:
    v = MUSCLE.steady_states()[0]
    return (v, *MUSCLE.steady_gates(v))


def times() -> Floats:
    """Every 10 ms through the pulse, the spike and the return."""
    return np.arange(10.0, PULSE + AFTER + 1.0, 10.0)


@cache
def reference() -> Floats:
    return MUSCLE.solve(np.array(resting_start()), [(PULSE, 2.0), (AFTER, 0.0)], times())


def traced(dt: float, exact: bool) -> Floats:
    cell = Cell(np.array(resting_start()), 0.004, 0.125, dt, exact)
    steps = round(10.0 / dt)
    return np.array([cell.advance(steps, 2.0 if t <= PULSE + 1e-9 else 0.0) for t in times()])


def test_reference_spikes() -> None:
    """The comparison is worth something: the pulse makes a full spike, and the cell returns to rest."""
    v = reference()
    assert v.max() > 0.0
    assert v[-1] < -50.0


def test_single_cell_is_second_order_and_exact_in_the_limit() -> None:
    """E10: order 2 on five levels, and 1e-6 of the range of V at the finest step (exact kinetics)."""
    levels = [0.25 / 2**k for k in range(2, 8)]
    span = np.ptp(reference())
    errors = [float(np.abs(traced(dt, True) - reference()).max() / span) for dt in levels]
    assert_order(levels, errors, 2.0)
    assert errors[-1] <= 1e-6


def test_production_step_places_the_spike() -> None:
    """At 0.25 ms and with tables, the upstroke is where the exact cell has it, to a five-hundredth of a step."""
    fine = np.arange(0.05, 300.0, 0.05)
    v = MUSCLE.solve(np.array(resting_start()), [(PULSE, 2.0), (250.0, 0.0)], fine)
    k = int(np.flatnonzero((v[:-1] < -40.0) & (v[1:] >= -40.0))[0])
    exact = float(np.interp(-40.0, v[k : k + 2], fine[k : k + 2]))
    cell = Cell(np.array(resting_start()), 0.004, 0.125, 0.25, False)
    cell.advance(round(PULSE / 0.25), 2.0)
    cell.advance(1000)
    assert abs(cell.first[0] - exact) <= 5e-4
    assert np.abs(traced(0.25, False) - reference()).max() <= 2e-3 * np.ptp(reference())


def test_tables_add_less_than_the_step_does() -> None:
    """Interpolated gates differ from computed ones by less than the time step's own error at 0.25 ms."""
    difference = np.abs(traced(0.25, False) - traced(0.25, True)).max()
    assert 0.0 < difference <= np.abs(traced(0.25, True) - reference()).max()


def burst(dt: float, seconds: float, exact: bool = True) -> Floats:
    v, h, x, n, c = BURSTING_START
    cell = Cell(np.array([v, h, n, x, c]), 0.01, 1.0, dt, exact)
    steps = round(1.0 / dt)
    return np.array([cell.advance(steps) for _ in range(round(1e3 * seconds))])


def test_plants_cell_bursts_as_published() -> None:
    """E10: period 10.48 s +- 0.5 %, six spikes a burst, -64.6 ... +28.6 mV, on the cell's own clock."""
    v = burst(0.125, 36.0)
    rises = np.flatnonzero((v[:-1] < -20.0) & (v[1:] >= -20.0)) * 1e-3
    fresh = np.flatnonzero(np.diff(rises, prepend=-10.0) > 3.0)
    periods = np.diff(rises[fresh])
    assert periods[1:] == pytest.approx(10.48, rel=5e-3)
    assert np.diff(fresh)[1:].tolist() == [6] * (len(fresh) - 2)
    settled = v[12_000:]
    assert settled.min() == pytest.approx(-64.6, abs=0.1)
    assert settled.max() == pytest.approx(28.6, abs=0.3)


def test_rate_factor_is_a_change_of_clock() -> None:
    """Kinetics slowed eight times is the same cell watched at an eighth of the speed, bit for bit in the limit."""
    start = np.array(resting_start())
    start[0] += 6.0
    quick = Cell(start, 0.004, 1.0, 0.0125, True)
    slow = Cell(start, 0.004, 0.125, 0.1, True)
    pairs = [(quick.advance(80), slow.advance(80)) for _ in range(60)]
    assert np.ptp([v for v, _ in pairs]) > 1.0
    assert max(abs(a - b) for a, b in pairs) <= 1e-9
