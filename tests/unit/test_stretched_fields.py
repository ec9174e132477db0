"""Stretches and contact pressure of walls whose shape says what they must be."""

import numpy as np
import pytest

from peristalsis.geometry.surface import from_frames
from peristalsis.model.fields import contact_pressure, nodal_stretches
from peristalsis.model.state import WallState
from verification.exact.surface_wall import uniform
from verification.exact.wall import wall_constants

ELEMENTS = 6
WALL = wall_constants(ELEMENTS, 1.0)


def placed(places: np.ndarray, contact: np.ndarray) -> WallState:
    """A wall at rest with its nodes at these places (n, 3, m), in the frames of their columns."""
    position, (n, _, m) = from_frames(places), places.shape
    still, around = np.zeros((n, m, 3)), np.zeros((n, m))
    drive = np.zeros((2, 2 * n - 2, m))
    return WallState(position, position, still, still, contact, np.zeros((n - 1, m)), around, drive, 0.0)


@pytest.mark.parametrize("columns", [1, 5])
def test_a_cylinder_shows_its_two_stretches(columns: int) -> None:
    """lambda_l from its length and lambda_c from its radius at every node; Q is spread over their product."""
    n = ELEMENTS + 1
    places = uniform(np.full(n, 1.3 * WALL.radius), 1.1 * np.linspace(0.0, 1.0, n), columns)
    contact = np.random.default_rng(3).uniform(0.0, 50.0, (n, columns))
    wall = placed(places, contact)
    along, around = nodal_stretches(wall, WALL)
    assert along == pytest.approx(np.full((n, columns), 1.1), rel=1e-12)
    assert around == pytest.approx(np.full((n, columns), 1.3), rel=1e-12)
    assert contact_pressure(wall, WALL) == pytest.approx(contact / (1.1 * 1.3), rel=1e-12)


def test_a_tube_put_beside_the_axis_is_the_same_tube() -> None:
    """Distance from the axis is no stretch there: pressure and stretches are those of the tube on the axis."""
    n, columns = ELEMENTS + 1, 7
    rng = np.random.default_rng(4)
    centred = uniform(rng.uniform(0.7, 1.0, n), np.linspace(0.0, 1.1, n), columns)
    angle = 2.0 * np.pi * np.arange(columns) / columns
    aside = centred.copy()
    aside[:, 0] += 0.2 * np.cos(angle)
    aside[:, 1] -= 0.2 * np.sin(angle)
    contact = rng.uniform(0.0, 50.0, (n, columns))
    on_axis, off_axis = placed(centred, contact), placed(aside, contact)
    assert np.ptp(off_axis.position[:, :, 0], axis=1).min() > 0.3
    for found, expected in zip(nodal_stretches(off_axis, WALL), nodal_stretches(on_axis, WALL), strict=True):
        assert found == pytest.approx(expected, rel=1e-12)
    assert contact_pressure(off_axis, WALL) == pytest.approx(contact_pressure(on_axis, WALL), rel=1e-12)
