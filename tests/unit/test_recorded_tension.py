"""The tension that is recorded: at each corner of each element, from its own stretch, rates and drives."""

import numpy as np
import pytest

from peristalsis.wall.membrane import PARTS, corner_tension, wall_tension
from verification.exact.wall import COUPLED, wall_constants

N = 7


def test_every_corner_has_its_own_tension() -> None:
    """No two nodes, elements or drives are alike, so that a wrong neighbour shows."""
    rng = np.random.default_rng(5)
    wall = wall_constants(N - 1, 1.0, passive=COUPLED)
    rho = 0.9 + 0.05 * rng.normal(size=N)
    zeta = np.linspace(0.0, 1.2, N) + 0.02 * rng.normal(size=N)
    axial_rate, hoop_rate = rng.normal(size=N - 1), rng.normal(size=N)
    drives = 40.0 * rng.random((2, 2 * (N - 1)))
    found = np.empty((N - 1, 2, PARTS))
    wall_tension(rho, zeta, axial_rate, hoop_rate, drives[0], drives[1], wall, found)
    lengths = np.hypot(np.diff(rho), np.diff(zeta)) / wall.element_size
    expected = np.empty(PARTS)
    for e in range(N - 1):
        for corner in range(2):
            hoop, k = rho[e + corner] / wall.radius, 2 * e + corner
            rates = axial_rate[e], hoop_rate[e + corner]
            corner_tension(lengths[e], hoop, *rates, drives[0, k], drives[1, k], wall, expected)
            assert found[e, corner] == pytest.approx(expected, rel=1e-12)
