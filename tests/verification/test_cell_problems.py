"""The production step and the tables of one cell, Eqs. (20)-(22) and (31); the exact limit is E10."""

import numpy as np
from numpy.typing import NDArray

from verification.cell import MUSCLE, PULSE, Cell, reference, resting_start, traced

Floats = NDArray[np.float64]


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


def test_rate_factor_is_a_change_of_clock() -> None:
    """Kinetics slowed eight times is the same cell watched at an eighth of the speed, bit for bit in the limit."""
    start = np.array(resting_start())
    start[0] += 6.0
    quick = Cell(start, 0.004, 1.0, 0.0125, True)
    slow = Cell(start, 0.004, 0.125, 0.1, True)
    pairs = [(quick.advance(80), slow.advance(80)) for _ in range(60)]
    assert np.ptp([v for v, _ in pairs]) > 1.0
    assert max(abs(a - b) for a, b in pairs) <= 1e-9
