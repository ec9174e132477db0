"""The mechanoreceptor reflex: excitation above, inhibition below the pellet, Eq. (26)."""

import numpy as np
import pytest

from peristalsis.control.reflex import SILENT, Reflex, ReflexState, observe_stretch

REFLEX = Reflex(True, 1.05, 1.5, 2.0, 0.1, 0.7, 1.0, 0.05, 0.01, 0.3)
NODES = np.linspace(0.0, 10.0, 101)


def seen(
    girth: float, low: float, high: float, state: ReflexState = SILENT, time: float = 1.0, reflex: Reflex = REFLEX
) -> ReflexState:
    """The receptors where the wall touches between `low` and `high`, stretched `girth` times everywhere."""
    touching = (low - 1e-9 <= NODES) & (high + 1e-9 >= NODES)
    return observe_stretch(reflex, state, NODES, np.full(101, girth), touching, time)


def test_polarity_and_places() -> None:
    """Law of the intestine: 1.5 cm excited on the oral side of the contact, 2 cm inhibited on the anal side."""
    state = seen(1.06, 4.0, 5.0)
    (above,), (below,) = state.excitation, state.inhibition
    assert (above.low, above.high, above.strength) == (pytest.approx(2.5), pytest.approx(4.0), 1.0)
    assert (below.low, below.high, below.strength) == (pytest.approx(5.0), pytest.approx(7.0), 0.01)
    assert (above.begin, above.end) == (pytest.approx(1.1), pytest.approx(1.15))
    assert (below.begin, below.end) == (pytest.approx(1.1), pytest.approx(1.4))


@pytest.mark.parametrize(("girth", "fires"), [(1.049, False), (1.05, False), (1.051, True)])
def test_threshold_is_105_per_cent(girth: float, fires: bool) -> None:
    assert bool(seen(girth, 4.0, 5.0).excitation) is fires


def test_only_touching_wall_counts() -> None:
    """Wall stretched by pressure ahead of the pellet does not fire; the stretched part of the band sets the place."""
    assert observe_stretch(REFLEX, SILENT, NODES, np.full(101, 1.2), np.zeros(101, bool), 1.0) == SILENT
    girth = np.where((NODES > 4.15) & (NODES < 4.65), 1.1, 1.0)
    state = observe_stretch(REFLEX, SILENT, NODES, girth, (NODES > 3.9) & (NODES < 5.1), 1.0)
    assert state.excitation[0].high == pytest.approx(4.2)
    assert state.inhibition[0].low == pytest.approx(4.6)


def test_refractory_time() -> None:
    """Steady stretch discharges every 0.7 s, and what is over is forgotten."""
    state, fired, dt = SILENT, [], 0.002
    for k in range(1500):
        before = state.fired
        state = seen(1.1, 4.0, 5.0, state, k * dt)
        if state.fired != before:
            fired.append(state.fired)
        assert len(state.excitation) <= 2
    assert np.diff(fired) == pytest.approx(0.7, abs=1e-9)


def test_switched_off_stays_silent() -> None:
    assert seen(2.0, 4.0, 5.0, reflex=REFLEX._replace(enabled=False)) == SILENT
