"""Fields derived from a state, and the reactions at the ends."""

import numpy as np
import pytest

from peristalsis.model.fields import (
    contact_pressure,
    end_reactions,
    nodal,
    nodal_tensions,
    stretch_of_elements,
)
from peristalsis.model.step_summary import contact_summary
from verification.exact.runs import EXACT, started, wave_catches_pellet
from verification.exact.wall import axial_invariants


def test_end_reactions_are_the_axial_force_of_the_free_tube() -> None:
    """M4(i): both ends of a tube without pellet carry the same F, that of the independent formula."""
    model, state = started(EXACT, {"pellet.enabled": False})
    oral, anal, _ = end_reactions(state.wall, model.wall, state.pressure)
    position = state.wall.position[:, 0]
    force, _ = axial_invariants(position[:, 0], position[:, 2], state.pressure, model.wall)
    assert oral == pytest.approx(anal, abs=1e-6)
    assert oral == pytest.approx(force[200], abs=1e-6)
    assert abs(oral) > 1.0


def test_nodal_values_are_means() -> None:
    assert nodal(np.array([[1.0], [3.0], [5.0]]))[:, 0].tolist() == [1, 2, 4, 5]
    corners = np.zeros((2, 2, 1, 1))
    corners[:, :, 0, 0] = [[1.0, 2.0], [4.0, 8.0]]
    assert nodal_tensions(corners).ravel().tolist() == [1, 3, 8]


def test_stretch_of_the_resting_tube_averages_to_its_length() -> None:
    """The ends are clamped: the mean of lambda_l cos(alpha) is one."""
    model, state = started()
    stretch = stretch_of_elements(state.wall.position, model.wall.element_size)
    assert stretch.shape == (400, 1)
    assert stretch.mean() >= 1.0


def test_contact_pressure_is_density_over_the_deformed_area() -> None:
    """Sum of q dA over the band is the normal force of the summary."""
    run = wave_catches_pellet()
    state, model = run.states[200], run.model
    pressure = contact_pressure(state.wall, model.wall)[:, 0]
    stretch = nodal(stretch_of_elements(state.wall.position, model.wall.element_size))[:, 0]
    areas = 2.0 * np.pi * state.wall.position[:, 0, 0] * stretch * model.wall.element_size
    summary = contact_summary(model, state)
    assert pressure @ areas == pytest.approx(summary.normal_force, rel=1e-12)
    assert summary.largest_pressure == pytest.approx(pressure.max(), rel=1e-12)
    touching = np.flatnonzero(pressure > 0.0)
    assert (summary.start, summary.end) == tuple(state.wall.position[touching[[0, -1]], 0, 2])
