"""Contact forces across the axis, and trial walls of the whole surface that are refused."""

import numpy as np
import pytest

from peristalsis.pellet.surface_contact import force_on_pellet
from peristalsis.wall.laws.tong_fung import LARGEST_EXPONENT
from peristalsis.wall.surface import load_edges, measure_edges, new_edges
from verification.exact.surface_wall import at_rest, padded, uniform
from verification.exact.wall import COUPLED, wall_constants

ROWS, COLUMNS = 6, 7


def test_force_on_the_pellet_is_the_sum_of_its_parts_in_the_room() -> None:
    """Normals are in the frames of their columns, which are turned against column 0."""
    rng = np.random.default_rng(2)
    density, normal = rng.random((ROWS, COLUMNS)), rng.normal(size=(ROWS, 3, COLUMNS))
    density[2] = 0.0
    turn = np.exp(2j * np.pi * np.arange(COLUMNS) / COLUMNS)
    across = -0.3 * (density * (normal[:, 0] + 1j * normal[:, 1]) * turn).sum()
    along = -0.3 * (density * normal[:, 2]).sum()
    assert force_on_pellet(density, normal, 0.3) == pytest.approx((across.real, across.imag, along), rel=1e-12)


@pytest.mark.parametrize("direction", ["axial", "hoop"])
def test_walls_beyond_the_energy_are_refused(direction: str) -> None:
    """Either stretch alone can make the exponent of Eq. (4) too large; just below it the wall is taken."""
    wall = wall_constants(ROWS - 1, 1.0, passive=COUPLED)
    p = wall.passive
    most = 1.0 + np.sqrt(LARGEST_EXPONENT / (p.c4 if direction == "axial" else p.c5))
    for factor, taken in ((0.98, True), (1.02, False)):
        stretch, hoop = (factor * most, 1.0) if direction == "axial" else (1.0, factor * most)
        zeta = stretch * np.linspace(0.0, 1.0, ROWS)
        places = uniform(np.full(ROWS, hoop * wall.radius), zeta, COLUMNS)
        known, edges = at_rest(places, wall), new_edges(ROWS, COLUMNS)
        assert measure_edges(padded(places), wall, edges)
        loaded = load_edges(edges, known.stretch_history, known.hoop_history, known.slope, known.drive, wall)
        assert loaded is taken
