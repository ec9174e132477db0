"""The resting state, Eq. (23): the lowest steady state, and whether the cell stays on it."""

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.errors import ConfigurationError
from peristalsis.inputs.build import cell_constants
from peristalsis.inputs.config import Configuration
from peristalsis.tissue.cells.plant import CHANNELS, gate_table
from peristalsis.tissue.rest import NoRestError, RestState, rest_state
from verification.exact.cell import ReferenceCell

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


OPEN = np.array([4.0, 0.004, 0.3, 0.03, 0.003])


@pytest.mark.parametrize(
    ("conductances", "changed", "potential"),
    [
        ([0.0, 1.0, 0.0, 0.0, 0.0], {}, 30.0),  # slow calcium channels alone: their reversal potential
        ([0.0, 0.0, 0.0, 0.0, 0.003], {"chloride_reversal": -150.0}, -150.0),
        ([0.0, 0.0, 0.0, 0.0, 0.003], {"chloride_reversal": 120.0}, 120.0),
    ],
)
def test_rest_is_found_wherever_the_tables_reach(
    conductances: list[float], changed: dict[str, float], potential: float
) -> None:
    found = rest_state(np.array(conductances), CONSTANTS._replace(**changed), TABLE, True)
    assert found.potential == pytest.approx(potential, abs=1e-9)
    assert min(found.gates) >= 0.0


@pytest.mark.parametrize(
    ("conductances", "changed", "why"),
    [
        (
            OPEN,
            {"potassium_reversal": 300.0},
            r"inward, most of it through potassium.*cell.potassium_reversal = 300 mV",
        ),
        (OPEN, {"chloride_reversal": -300.0}, r"outward, most of it through leak.*cell.chloride_reversal = -300 mV"),
        (0.0 * OPEN, {}, "all its conductances"),
        (OPEN, {"calcium_entry_potential": -300.0}, "cell.calcium_entry_potential = -300 mV"),
    ],
)
def test_cell_without_rest_is_a_sentence(conductances: np.ndarray, changed: dict[str, float], why: str) -> None:
    """The channel and the parameter that leave it none."""
    with pytest.raises(NoRestError, match=why):
        rest_state(conductances, CONSTANTS._replace(**changed), TABLE)


TINY = {"grid.n_z": 50, "grid.n_z_wall": 60, "run.duration": "20 ms"}


@pytest.mark.parametrize("layer", ["longitudinal", "circular"])
def test_runs_without_rest_are_refused_and_odd_rests_remarked_on(layer: str) -> None:
    odd = ps.run("baseline", {**TINY, f"{layer}.slow_calcium": "100 mS/cm^2"})
    assert any(f"above {layer}.threshold" in remark for remark in odd.remarks)
    closed = {f"{layer}.{name}": "0 mS/cm^2" for name in CHANNELS}
    with pytest.raises(ConfigurationError, match=f"{layer} layer: the cell has no resting potential"):
        ps.run("baseline", {**TINY, **closed})


@pytest.mark.parametrize(("key", "layer"), [("pacemaker", "longitudinal"), ("trigger", "circular")])
def test_stimulus_that_is_too_strong_is_named(key: str, layer: str) -> None:
    """And not the step: no step would hold it."""
    result = ps.run(
        "baseline", {**TINY, "run.duration": "60 ms", "trigger.timing": "step", f"{key}.intensity": "1000 uA/cm^2"}
    )
    assert result.status == "diverged"
    assert f"{layer} potential" in str(result.error)
    assert "a stimulus of 1000 uA/cm^2" in str(result.error)
    assert f"{key}.intensity" in str(result.error)
    assert "step" not in str(result.error)
