"""The pellet in the tube while it is driven; the exact problems are C1-C7."""

import numpy as np
import pytest
from numpy.typing import NDArray

from peristalsis.pellet.contact import smallest_gap
from verification.contact import force_from_pressure, gaps
from verification.exact.runs import IDLE, March, march, wave_catches_pellet

Floats = NDArray[np.float64]


@pytest.fixture(scope="module")
def run() -> March:
    return wave_catches_pellet()


def test_run_is_worth_checking(run: March) -> None:
    """The wave reaches the pellet, contact comes and goes, and the pellet slides both ways or far."""
    touching = {int((s.wall.contact > 0.0).sum()) for s in run.states}
    assert len(touching) > 10
    assert max(s.pellet.axial_force for s in run.states) > 100.0
    assert run.last.pellet.position - run.states[0].pellet.position > 0.3


def test_friction_balances_the_force_of_the_wall(run: March) -> None:
    """C1, Eq. (13): eta v + F_d sgn v equals F_z to rounding whenever the pellet slides."""
    pellet = run.model.pellet
    sliding = [s.pellet for s in run.states[1:] if s.pellet.velocity != 0.0]
    assert len(sliding) > 50
    for p in sliding:
        friction = pellet.viscous * p.velocity + pellet.dry * np.sign(p.velocity)
        assert friction == pytest.approx(p.axial_force, rel=1e-12)


def test_force_from_the_contact_pressure_in_motion(run: March) -> None:
    """C1 while the pellet is driven: both evaluations within a per cent of the largest force."""
    largest = max(abs(s.pellet.axial_force) for s in run.states)
    for state in run.states[10::10]:
        assert abs(force_from_pressure(run.model, state) - state.pellet.axial_force) <= 0.01 * largest


def test_looser_tube_does_not_touch() -> None:
    """A pellet narrower than the inflated tube has no contact, feels no force and does not move."""
    taken = march(0.02, IDLE, {"pellet.radius": "0.7 cm"})
    assert taken.last.wall.contact.max() == 0.0
    assert taken.last.pellet.axial_force == 0.0
    assert taken.last.pellet.position == taken.states[0].pellet.position


def test_smallest_gap_is_that_of_the_nodes(run: March) -> None:
    """What a run records is the least of the gaps summed here by hand."""
    for state in run.states[::40]:
        assert smallest_gap(
            np.ascontiguousarray(state.wall.position[:, 0, 0]),
            np.ascontiguousarray(state.wall.position[:, 0, 2]),
            state.pellet.position,
            run.model.pellet.shape,
        ) == pytest.approx(gaps(run.model, state)[1:-1].min(), abs=1e-14)
