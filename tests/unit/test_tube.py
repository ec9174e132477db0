"""Volume of the lumen and pressure force, Eqs. (17) and (18)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis.geometry.tube import lumen_volume
from peristalsis.wall.assembly import VOLUME_R, VOLUME_Z, WALL_ROWS, volume_gradient
from verification.exact.runs import wave_catches_pellet
from verification.exact.wall import discrete_volume


def test_cylinder_and_cone_are_exact() -> None:
    z = np.linspace(0.0, 3.0, 8)
    assert lumen_volume(np.full(8, 0.8), z) == pytest.approx(np.pi * 0.64 * 3.0, rel=1e-14)
    assert lumen_volume(0.2 * z, z) == pytest.approx(np.pi * 0.36, rel=1e-14)


@given(st.integers(0, 2**32 - 1))
def test_pressure_force_is_the_gradient_of_the_volume(seed: int) -> None:
    """By complex steps, so that pressure does work exactly -p dV whatever the shape."""
    n = 9
    rng = np.random.default_rng(seed)
    x = np.empty(2 * n)
    x[0::2], x[1::2] = rng.uniform(0.4, 1.2, n), np.linspace(0.0, 1.0, n) + 0.03 * rng.normal(size=n)
    radius, work = 0.795, np.zeros((WALL_ROWS, n))
    volume_gradient(x[0::2].copy(), x[1::2].copy(), radius, 1, n - 2, work)
    gradient = work[VOLUME_R : VOLUME_Z + 1].T.ravel()
    exact = np.empty(2 * n)
    for k in range(2 * n):
        moved = x.astype(complex)
        moved[k] += 1e-30j
        exact[k] = discrete_volume(moved).imag / 1e-30
    exact /= 2.0 * np.pi * radius
    assert np.abs(gradient - exact)[2:-2].max() <= 1e-12 * np.abs(exact).max(), "at the nodes that are free to move"


def test_lumen_is_adiabatic_throughout_a_run() -> None:
    """M11: p V^1.4 keeps its value after every step, V being the lumen less the pellet."""
    run = wave_catches_pellet()
    lumen = run.model.lumen
    products, volumes = [], []
    for state in run.states:
        position = state.wall.position[:, 0]
        volume = lumen_volume(position[:, 0].copy(), position[:, 2].copy()) - run.model.pellet.volume
        volumes.append(volume)
        products.append(state.pressure * volume**lumen.exponent)
    assert np.ptp(volumes) > 0.1, "the volume must have changed"
    assert np.ptp(products) <= 1e-9 * products[0]
    assert volumes[0] == pytest.approx(lumen.reference_volume, rel=1e-14)
