"""The graded reflex, Eqs. (120)-(122): strength by stretch, fading by distance, a refractory time of each receptor."""

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.control.graded import answer, observe_receptors, saturated, spread
from peristalsis.control.reflex import SILENT, Reflex, ReflexState
from peristalsis.errors import ConfigurationError

REFLEX = Reflex(True, 1.05, 1.0, 2.0, 0.1, 0.7, 1.0, 0.5, 0.01, 0.5, "graded", 1.0, 0.2, 0.5, 1.0, 0.0)


def nodes(count: int = 401) -> np.ndarray:
    return np.linspace(0.0, 10.0, count)


def seen(girth: np.ndarray, state: ReflexState, time: float, reflex: Reflex = REFLEX) -> ReflexState:
    return observe_receptors(reflex, state, girth, np.ones(girth.size, bool), time)


def test_strength_grows_from_the_threshold_to_the_whole() -> None:
    state = seen(np.array([1.0, 1.05, 1.1, 1.15, 1.25, 1.5]), SILENT, 1.0)
    assert state.receptors is not None
    assert state.receptors.strength[0] == pytest.approx([0.0, 0.0, 0.25, 0.5, 1.0, 1.0])
    assert state.receptors.time[0].tolist() == [-np.inf, -np.inf, 1.0, 1.0, 1.0, 1.0]


def test_each_receptor_has_a_refractory_time_of_its_own() -> None:
    first = seen(np.array([1.2, 1.0]), SILENT, 0.0)
    both = seen(np.array([1.2, 1.2]), first, 0.5)
    assert both.receptors is not None
    assert both.receptors.time[0].tolist() == [0.0, 0.5]
    again = seen(np.array([1.2, 1.2]), both, 0.7)
    assert again.receptors is not None
    assert again.receptors.time[0].tolist() == [0.7, 0.5]
    assert again.fired == 0.0, "it never fell silent in between"


def test_a_late_answer_is_not_cut_off_by_the_next_discharge() -> None:
    """Delay and duration longer than the refractory time: the last answer goes on beside the next."""
    late = REFLEX._replace(delay=1.0, excitation_duration=0.7, refractory=0.7)
    state, place = SILENT, nodes()
    for k in range(4):
        state = seen(np.full(401, 1.25), state, 0.7 * k, late)
    assert state.receptors is not None
    for start in np.arange(2.1, 3.0, 0.1):
        brought = answer(late, state.receptors, place, np.array([5.0]), start, start + 0.05)
        assert brought is not None
        assert brought.excitation[0] == pytest.approx(saturated(np.array([(1.0 - np.exp(-5.0)) / 0.5]))[0], rel=1e-3)


def test_only_touching_wall_answers() -> None:
    assert observe_receptors(REFLEX, SILENT, np.full(9, 1.5), np.zeros(9, bool), 1.0) is SILENT
    assert observe_receptors(REFLEX, SILENT, None, np.ones(9, bool), 1.0) is SILENT


@pytest.mark.parametrize("cells", [80, 160, 320])
def test_fading_is_the_integral_whatever_the_grids(cells: int) -> None:
    """A band of receptors from 4 to 6 cm: L (exp(-(4 - z)/L) - exp(-(6 - z)/L)) ahead of it, nothing behind it."""
    place, spacing = nodes(), 0.025
    sent = np.where((place > 4.0 - 1e-9) & (place < 6.0 + 1e-9), 1.0, 0.0)
    sent[[160, 240]] = 0.5
    z = (np.arange(cells) + 0.5) * 10.0 / cells
    found = spacing * spread(sent, -place, -z, 1.5, spacing)
    near, far = np.maximum(4.0 - z, 0.0), np.maximum(6.0 - z, 0.0)
    exact = np.where(z < 6.0, 1.5 * (np.exp(-near / 1.5) - np.exp(-far / 1.5)), 0.0)
    assert np.abs(found - exact).max() < 1e-3
    assert found[z > 6.1].max() == 0.0


def test_polarity() -> None:
    """Law of the intestine: excitation lies on the oral side of the stretch, inhibition on the anal one."""
    girth = np.where(np.abs(nodes() - 5.0) < 0.2, 1.25, 1.0)
    state = seen(girth, SILENT, 0.0)
    assert state.receptors is not None
    cells = np.array([3.0, 7.0])
    brought = answer(REFLEX, state.receptors, nodes(), cells, 0.1, 0.2)
    assert brought is not None
    assert brought.excitation[0] > 0.0 == brought.excitation[1]
    assert brought.inhibition[1] > 0.0 == brought.inhibition[0]


def test_what_is_brought_over_a_step_is_its_mean() -> None:
    """An answer from 0.1 to 0.6 s: half of a step from 0.5 to 0.7 s, nothing before and after; the layers by theirs."""
    state = seen(np.full(401, 1.25), SILENT, 0.0)
    assert state.receptors is not None
    middle = np.array([5.0])

    def over(start: float, stop: float) -> float:
        assert state.receptors is not None
        brought = answer(REFLEX, state.receptors, nodes(), middle, start, stop)
        return 0.0 if brought is None else float(-np.log1p(-brought.excitation[0]))

    assert over(0.5, 0.7) == pytest.approx(0.5 * over(0.2, 0.3), rel=1e-12)
    assert over(0.7, 0.8) == 0.0
    assert answer(REFLEX._replace(longitudinal_delay=0.1), state.receptors, nodes(), middle, 0.0, 0.1) is None


def test_a_sum_saturates() -> None:
    small = np.array([1e-9, 1e-3])
    assert saturated(small) == pytest.approx(small, rel=1e-3)
    assert saturated(np.array([50.0])) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"grid.n_theta": 8}, "reflex.kind = graded"),
        ({"solver.integrator": "explicit"}, "reflex.kind = graded"),
        ({"reflex.refractory": "0 s"}, "reflex.refractory"),
    ],
)
def test_what_is_not_carried_out_is_refused(changes: dict[str, object], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        ps.configuration("baseline", changes={"reflex.kind": "graded", **changes})


def test_gain_scales_the_reflex_of_either_kind() -> None:
    """All-or-none pulses are as strong as the gain says; at 0 neither kind moves a pellet."""
    small = {"grid.n_z": 100, "grid.n_z_wall": 80, "run.duration": "0.2 s", "output.interval": "0.05 s"}
    simulation = ps.Simulation(ps.configuration("reflex_only", changes={**small, "reflex.gain": 0.5}))
    while not simulation.state.reflex.excitation:
        simulation.advance("10 ms")
    assert simulation.state.reflex.excitation[0].strength == 0.5
    assert simulation.state.reflex.inhibition[0].strength == 0.005
