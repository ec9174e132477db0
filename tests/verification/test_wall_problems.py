"""The wall: what M1-M4 and M8 leave, decaying modes of the rod, Eqs. (1)-(5), (32), (35)."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from peristalsis.wall.membrane import PARTS, TOTAL_LONGITUDINAL, corner_tension
from verification.exact.orders import assert_order
from verification.exact.runs import IDLE, march, moved, started
from verification.exact.wall import (
    COUPLED,
    assembled,
    axial_invariants,
    wall_constants,
)
from verification.wall import clamped
from verification.waves import LINEAR_ROD, rod_amplitudes

Floats = NDArray[np.float64]


def test_published_tensions_have_no_second_integral() -> None:
    """Eq. (35): as printed, the tensions are not those of an energy, and the spread does not shrink."""
    spreads = []
    for elements in (200, 400):
        rho, zeta, wall = clamped(elements, True)
        spreads.append(float(np.ptp(axial_invariants(rho, zeta, 10.0, wall)[1])))
    assert spreads[1] > 0.5 * spreads[0] > 1e-3


def test_clamped_tube_converges_to_second_order() -> None:
    """Radius a twentieth of the way in, against the finest grid: linear elements are second order."""
    finest = clamped(3200, False)[0]
    sizes, errors = [], []
    for elements in (100, 200, 400, 800):
        rho, _, wall = clamped(elements, False)
        stride = 3200 // elements
        sizes.append(wall.element_size)
        errors.append(float(np.abs(rho - finest[::stride]).max()))
    assert_order(sizes, errors, 2.0, tolerance=0.15)
    assert errors[-1] <= 1e-4


@pytest.mark.parametrize(("scheme", "order"), [("bdf2", 2.0), ("euler", 1.0)])
def test_recovery_of_the_stretched_rod(scheme: str, order: float) -> None:
    """M8: without inertia every mode relaxes as exp(-K t/k), by the whole coupled step; both schemes."""
    levels = [8e-3, 4e-3, 2e-3, 1e-3]
    errors = [
        abs(rod_amplitudes(dt, 0.8, {"step.scheme": scheme})[-1] - 0.05 * np.exp(-0.8 * 40.0 / 33.3)) for dt in levels
    ]
    assert_order(levels, errors, order)
    assert errors[-1] <= (1e-6 if scheme == "bdf2" else 5e-5)


def test_clamped_ends_stay_where_they_are() -> None:
    """Both ends are clamped: not one bit may change while the wall moves between them."""
    taken = march(0.4, {"grid.n_z": 200, "grid.n_z_wall": 100})
    first, last = taken.states[0].wall.position, taken.last.wall.position
    assert np.abs(last - first).max() > 0.05, "the wall must have moved"
    assert np.array_equal(last[[0, -1]], first[[0, -1]])


def test_compressed_wall_needs_its_floor() -> None:
    """Eq. (15): squeezed by a tenth along z, the exact wall has negative tension; with the floor it has hardly any."""
    for blend, slope, lowest, highest in ((0.0, 0.0, -30.0, -1.0), (0.05, 1e-3, -0.05, 0.0)):
        wall = wall_constants(20, slack_blend=blend, slack_slope=slope, passive=COUPLED, viscosity=50.0)
        parts = np.empty(PARTS)
        corner_tension(0.9, 1.0, -0.1, 0.0, 0.0, 0.0, wall, parts)
        assert lowest <= parts[TOTAL_LONGITUDINAL] <= highest


def test_ring_at_rest_does_not_pull() -> None:
    """The undeformed tube without pressure is an equilibrium of every convention, to the last bit."""
    for published in (False, True):
        residual, _ = assembled(np.full(21, 0.795), np.linspace(0.0, 10.0, 21), wall_constants(20, published=published))
        assert np.abs(residual).max() <= 1e-13


def test_rates_enter_the_tension_once() -> None:
    """k times the stretch rate, per layer: a hoop that widens at 1/s pulls k more, whatever the step."""
    wall = wall_constants(4, 1.0)
    rho, zeta = np.full(5, 0.795), np.linspace(0.0, 1.0, 5)
    slow, _ = assembled(rho, zeta, wall)
    for slope in (1.0, 500.0):
        fast, _ = assembled(rho, zeta, wall, slope, (np.ones(4), np.full(5, 1.0 - 1.0 / slope)))
        assert (fast - slow)[2] == pytest.approx(33.3 * wall.element_size / wall.radius, rel=1e-9)


def test_moved_keeps_the_rest() -> None:
    """The helper that starts the modes changes the wall's place and nothing else."""
    _, state = started(LINEAR_ROD, IDLE)
    other = moved(state, state.wall.position + 1.0)
    assert replace(other, wall=state.wall) == state
