"""The implicit step: failures are verdicts, the answer does not depend on the way to it."""

import numpy as np
import pytest

from peristalsis.model.step import advance
from peristalsis.model.verdicts import CONVERGED, REASONS
from verification.exact.runs import EXACT, IDLE, march, started
from verification.exact.wall import InflatedTube, settle, wall_constants


def test_every_verdict_has_its_words() -> None:
    assert REASONS[CONVERGED] == "converged"
    assert len(set(REASONS)) == 5


def test_same_equilibrium_from_different_guesses() -> None:
    """Three starts, one tube."""
    wall = wall_constants(40, 4.0)
    found = []
    for bump in (-0.05, 0.0, 0.08):
        s = np.linspace(0.0, 1.0, 41)
        rho, zeta = 0.82 + bump * np.sin(np.pi * s), 4.2 * s
        rho[[0, -1]] = 0.795
        settle(rho, zeta, 10.0, wall)
        found.append(rho)
    assert np.abs(found[0] - found[1]).max() <= 1e-9
    assert np.abs(found[2] - found[1]).max() <= 1e-9
    assert InflatedTube(10.0, wall, 1.05).hoop_stretch() * 0.795 == pytest.approx(found[0][20], abs=2e-5)


def test_answer_does_not_depend_on_the_tolerance() -> None:
    """A tolerance a hundred times finer moves the pellet by less than a micrometre in 0.3 s."""
    loose = march(0.3, {"solver.residual_tolerance": 1e-8, "solver.penetration_tolerance": 1e-7})
    tight = march(0.3)
    assert loose.last.pellet.position == pytest.approx(tight.last.pellet.position, abs=1e-6)
    assert loose.last.pellet.position != loose.states[0].pellet.position


def test_step_without_a_cause_is_one_look() -> None:
    """A state in equilibrium is recognised: no iteration, no motion."""
    model, state = started(EXACT, IDLE, {"pellet.dry_friction": "1000 mN", "solver.residual_tolerance": 1e-7})
    after, report = advance(model, state)
    assert report.newton_iterations == 0
    assert np.array_equal(after.wall.position, state.wall.position)
    assert after.pellet.position == state.pellet.position
