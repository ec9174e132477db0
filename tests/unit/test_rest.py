"""The resting state, Eq. (23): the lowest steady state, and whether the cell stays on it."""

import numpy as np
import pytest

from peristalsis.build import cell_constants
from peristalsis.config import Configuration
from peristalsis.tissue.cells.plant import gate_table
from peristalsis.tissue.rest import RestState, rest_state
from peristalsis.verification.exact.cell import ReferenceCell

CONSTANTS = cell_constants(Configuration(), 0.125)
TABLE = gate_table(0.25, CONSTANTS)


def rest(slow: float, exact: bool = True) -> RestState:
    return rest_state(np.array([4.0, slow, 0.3, 0.03, 0.003]), CONSTANTS, TABLE, exact)


@pytest.mark.parametrize(("slow", "potential"), [(0.004, -62.56), (0.005, -61.78)])
def test_resting_potentials(slow: float, potential: float) -> None:
    """The two documented values, and the independent root to 1e-9 mV, with its gates."""
    found, cell = rest(slow), ReferenceCell(slow=slow)
    lowest = cell.steady_states()[0]
    assert found.potential == pytest.approx(potential, abs=0.006)
    assert found.potential == pytest.approx(lowest, abs=1e-9)
    assert found.gates == pytest.approx(cell.steady_gates(lowest), rel=1e-9)
    assert found.stable


def test_lowest_of_three_roots_is_taken() -> None:
    """At 0.004 there are three steady states: only the lowest is rest."""
    roots = ReferenceCell(slow=0.004).steady_states()
    assert len(roots) == 3
    assert rest(0.004).potential == pytest.approx(roots[0], abs=1e-9)


@pytest.mark.parametrize("slow", [0.001, 0.004, 0.0075, 0.0085, 0.01])
def test_stability_is_that_of_the_eigenvalues(slow: float) -> None:
    cell = ReferenceCell(slow=slow)
    assert rest(slow).stable == (cell.growth(cell.steady_states()[0]) < 0.0)


def test_rest_is_lost_near_0008() -> None:
    """Resting muscle at the default, no rest for Plant's own bursting cell; the loss lies near 0.008."""
    assert rest(0.0075).stable
    assert not rest(0.0085).stable
    assert not rest(0.01).stable


def test_table_and_formulas_rest_at_the_same_place() -> None:
    assert rest(0.004, exact=False).potential == pytest.approx(rest(0.004).potential, abs=2e-3)


def test_cell_without_rest_is_an_error() -> None:
    """A cell with calcium channels alone reverses at +30 mV: there is nothing between -100 and 0."""
    with pytest.raises(ValueError, match="no steady state"):
        rest_state(np.array([0.0, 1.0, 0.0, 0.0, 0.0]), CONSTANTS, TABLE)
