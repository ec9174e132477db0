"""Force on the pellet and smallest gap from given nodes, Eqs. (12), (13) and (28)."""

import numpy as np
import pytest

from peristalsis.pellet.contact import axial_force, smallest_gap
from peristalsis.pellet.shapes.sphere import ShapeConstants as Sphere


def band(n: int, centre: float, radius: float, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    zeta = np.linspace(low, high, n)
    return np.sqrt(radius**2 - (zeta - centre) ** 2), zeta


def test_uniform_pressure_on_a_band_pushes_as_archimedes_says() -> None:
    """C2: F_z = pi q (a2^2 - a1^2), a the distances of the edges from the axis; middle of many narrow strips."""
    q, n = 30.0, 4000
    low, high = 4.7, 5.5
    edges = np.linspace(low, high, n + 1)
    rho, zeta = band(n, 5.0, 0.9, 0.5 * (edges[0] + edges[1]), 0.5 * (edges[-1] + edges[-2]))
    area = 2.0 * np.pi * 0.9 * (high - low) / n  # of every strip, after Archimedes
    exact = np.pi * q * ((0.81 - 0.25) - (0.81 - 0.09))
    assert axial_force(rho, zeta, np.full(n, q), 5.0, Sphere(0.9), area) == pytest.approx(exact, rel=1e-6)


def test_contact_behind_the_centre_pushes_forward() -> None:
    """The sign: wall behind (oral) drives the pellet anally."""
    rho, zeta = np.array([0.8, 0.8, 0.8]), np.array([4.6, 4.7, 5.0])
    assert axial_force(rho, zeta, np.array([1.0, 0.0, 0.0]), 5.0, Sphere(0.9), 1.0) > 0.0
    assert axial_force(rho, zeta, np.array([0.0, 0.0, 1.0]), 5.0, Sphere(0.9), 1.0) == 0.0
    assert axial_force(rho, zeta, np.zeros(3), 5.0, Sphere(0.9), 1.0) == 0.0


def test_smallest_gap_leaves_out_the_clamped_ends() -> None:
    """End nodes cannot be pushed away, so they do not count."""
    rho, zeta = np.array([0.1, 1.0, 0.95, 0.1]), np.array([5.0, 4.9, 5.0, 5.0])
    assert smallest_gap(rho, zeta, 5.0, Sphere(0.9)) == pytest.approx(0.05)
