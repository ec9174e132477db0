"""Plant's cell: currents and gates against the formulas written anew, the tables, the 0/0 limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis.inputs.build import cell_constants
from peristalsis.inputs.config import Configuration
from peristalsis.tissue.cells import plant
from verification.exact.cell import ReferenceCell

CONSTANTS = cell_constants(Configuration(), 0.125)
CONDUCTANCES = np.array([4.0, 0.004, 0.3, 0.03, 0.003])
fractions = st.floats(0.0, 1.0)


@given(st.floats(-100, 60), fractions, fractions, fractions, st.floats(0.0, 2.0))
def test_currents_are_those_of_the_source(v: float, h: float, n: float, x: float, c: float) -> None:
    """Eq. (21) coded twice: the sum, and the form in which the sheet uses it."""
    exact = ReferenceCell().current(v, h, n, x, c)
    gates = np.array([[h], [n], [x], [c]])
    parts = plant.currents(np.array([v]), gates, CONDUCTANCES[:, None], CONSTANTS)
    assert sum(float(part[0]) for part in parts.values()) == pytest.approx(exact, rel=1e-12, abs=1e-13)
    fast, slope, offset = plant.current_coefficients(h, n, x, c, CONDUCTANCES[:, None], 0, CONSTANTS)
    linear = fast * plant.fast_activation_cubed(v) * (v - 30.0) + slope * v - offset
    assert linear == pytest.approx(exact, rel=1e-11, abs=1e-12)


@given(st.floats(-100, 60))
def test_gate_targets_and_rates_are_those_of_the_source(v: float) -> None:
    """Eq. (20): where the source's rate of change vanishes, and how fast it returns."""
    h, rate_h, n, rate_n, x, rate_x = plant.gate_targets(v, CONSTANTS)
    cell = ReferenceCell(rate=1.0)
    assert (h, n, x) == pytest.approx(cell.steady_gates(v)[:3], rel=1e-12)
    slope = cell.slope(np.array([v, h + 0.1, n + 0.1, x + 0.1, 0.0]))
    assert slope[1:4] == pytest.approx([-0.1 * rate_h, -0.1 * rate_n, -0.1 * rate_x], rel=1e-9)


@pytest.mark.parametrize("u", [50.0, 55.0])
def test_removable_singularities_are_removed(u: float) -> None:
    """alpha_m at U = 50 and alpha_n at U = 55 are 0/0: at and around them the values are smooth."""
    v = (105.0 * u - 8265.0) / 127.0
    values = [plant.fast_activation_cubed(v + d) for d in (-1e-4, -1e-9, 0.0, 1e-9, 1e-4)]
    gates = [plant.gate_targets(v + d, CONSTANTS)[3] for d in (-1e-4, -1e-9, 0.0, 1e-9, 1e-4)]
    for row in (values, gates):
        assert np.all(np.isfinite(row))
        assert row[2] == pytest.approx(0.5 * (row[0] + row[4]), rel=1e-8)
        assert row[1] == pytest.approx(row[3], rel=1e-8)


def test_each_current_vanishes_at_its_reversal_potential() -> None:
    gates = np.full((4, 3), 0.5)
    found = plant.currents(np.array([30.0, -75.0, -40.0]), gates, np.repeat(CONDUCTANCES[:, None], 3, 1), CONSTANTS)
    assert found["fast_calcium"][0] == found["slow_calcium"][0] == 0.0
    assert found["potassium"][1] == found["calcium_potassium"][1] == 0.0
    assert found["leak"][2] == 0.0


@given(st.floats(-119.9, 60.0))
def test_tables_are_close_to_what_they_tabulate(v: float) -> None:
    """Linear interpolation over 0.00625 mV: within 2e-7 of gates and decays that lie in [0, 1]."""
    table, row, exact = TABLE, np.zeros(8), np.zeros(8)
    assert plant.read_row(v, table, False, 0.25, CONSTANTS, row)
    assert plant.read_row(v, table, True, 0.25, CONSTANTS, exact)
    assert np.abs(row - exact).max() <= 2e-7


TABLE = plant.gate_table(0.25, CONSTANTS)


@pytest.mark.parametrize("exact", [False, True])
def test_gates_relax_exponentially_at_a_held_potential(exact: bool) -> None:
    """E10: each gate to its target as exp(-t/tau), exactly, whatever the step; calcium follows the mean of x."""
    v = np.array([-30.0])
    start = np.array([0.9, 0.1, 0.2, 0.3]).reshape(4, 1)
    gates = start.copy()
    for _ in range(40):
        plant.relax_gates(v, gates, TABLE, exact, 0.25, CONSTANTS, np.empty((1, 1)), np.ones((5, 1)))
    h, rate_h, n, rate_n, x, rate_x = plant.gate_targets(-30.0, CONSTANTS)
    targets, rates = np.array([h, n, x]), np.array([rate_h, rate_n, rate_x])
    wanted = targets + (start[:3, 0] - targets) * np.exp(-10.0 * 0.125 * rates)
    assert gates[:3, 0] == pytest.approx(wanted, rel=1e-12 if exact else 1e-6)


@pytest.mark.parametrize("bad", [200.0, -250.0, np.nan, np.inf])
def test_range_guard_names_the_cell(bad: float) -> None:
    """A potential outside the tables is found before it is looked up."""
    v = np.full(7, -60.0)
    assert plant.out_of_range(v) == -1
    v[4] = bad
    assert plant.out_of_range(v) == 4
