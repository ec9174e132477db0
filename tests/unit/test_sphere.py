"""Gap, normal and curvature of the sphere, Eq. (12)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis.pellet.sphere import gap_and_normal, volume


@given(st.floats(0.05, 2.0), st.floats(-2.0, 2.0))
def test_normal_is_the_gradient_of_the_gap_and_curvature_its_turning(rho: float, axial: float) -> None:
    """Central differences; the normal has length one."""
    _, nr, nz, curvature = gap_and_normal(rho, axial, 0.9)
    d = 1e-6
    assert nr == pytest.approx(
        (gap_and_normal(rho + d, axial, 0.9)[0] - gap_and_normal(rho - d, axial, 0.9)[0]) / (2 * d), abs=1e-6
    )
    assert nz == pytest.approx(
        (gap_and_normal(rho, axial + d, 0.9)[0] - gap_and_normal(rho, axial - d, 0.9)[0]) / (2 * d), abs=1e-6
    )
    assert np.hypot(nr, nz) == pytest.approx(1.0, rel=1e-14)
    along = gap_and_normal(rho + d * nz, axial - d * nr, 0.9)
    assert np.hypot(along[1] - nr, along[2] - nz) / d == pytest.approx(curvature, rel=1e-3)


def test_poles_equator_and_volume() -> None:
    assert gap_and_normal(0.9, 0.0, 0.9)[0] == 0.0
    assert gap_and_normal(0.5, 0.0, 0.9)[0] == pytest.approx(-0.4), "negative inside"
    assert volume(0.9) == pytest.approx(4.0 / 3.0 * np.pi * 0.729)
