"""The conduction operator and the passive cable against exact answers, Eqs. (30) and (31)."""

import numpy as np
import pytest
from verification.problems.cable import (
    PassiveCable,
    apply_operator,
    discrete_symbol,
    hodgkin_rushton,
    sealed_cable,
)
from verification.problems.orders import assert_order

from peristalsis.numerics.stabilised import stability_limit
from peristalsis.tissue.conduction import largest_eigenvalue

LENGTH = 10.0


@pytest.mark.parametrize("mode", [1, 2, 7, 31, 62])
def test_cosines_are_exact_eigenvectors_of_the_sealed_cable(mode: int) -> None:
    """E1: mirror images at the ends leave every cosine an eigenvector, with the symbol of the infinite line."""
    n = 64
    h = LENGTH / n
    k = mode * np.pi / LENGTH
    cosine = np.cos(k * (np.arange(n) + 0.5) * h)
    rate = apply_operator(cosine, 0.0873, h)
    exact = 0.0873 * discrete_symbol(k, h)
    assert np.abs(rate - exact * cosine).max() <= 1e-12 * abs(exact)


def test_operator_is_fourth_order_in_space() -> None:
    """E1: against the continuous operator; a second-order stencil would need four times the cells."""
    sizes, errors = [], []
    k = 3.0 * np.pi / LENGTH
    for n in (32, 64, 128, 256):
        h = LENGTH / n
        z = (np.arange(n) + 0.5) * h
        rate = apply_operator(np.cos(k * z), 1.0, h)
        sizes.append(h)
        errors.append(float(np.abs(rate + k * k * np.cos(k * z)).max()))
    assert_order(sizes, errors, 4.0)
    assert errors[-1] <= 1e-7 * k * k


def test_operator_is_fourth_order_where_the_stretch_varies() -> None:
    """Manufactured: D = 1 + 0.3 cos(2 pi z/L) at the faces, V = cos(pi z/L)."""
    sizes, errors = [], []
    k = np.pi / LENGTH
    for n in (32, 64, 128, 256):
        h = LENGTH / n
        z, faces = (np.arange(n) + 0.5) * h, np.arange(1, n) * h
        rate = apply_operator(np.cos(k * z), 1.0 + 0.3 * np.cos(2.0 * k * faces), h)
        spread, slope = 1.0 + 0.3 * np.cos(2.0 * k * z), -0.6 * k * np.sin(2.0 * k * z)
        exact = -k * np.sin(k * z) * slope - k * k * np.cos(k * z) * spread
        sizes.append(h)
        errors.append(float(np.abs(rate - exact).max()))
    assert_order(sizes, errors, 4.0)


def test_conduction_neither_makes_nor_loses_charge() -> None:
    """E8: the sum over the cells telescopes whatever the potential and the stretch."""
    rng = np.random.default_rng(1)
    potential, diffusivity = rng.normal(size=500), rng.uniform(0.3, 2.0, 499)
    rate = apply_operator(potential, diffusivity, 0.02)
    assert abs(rate.sum()) <= 1e-13 * np.abs(rate).sum()


def test_conduction_conserves_charge_over_many_steps() -> None:
    """E8 in time: without a leak the mean stays, to rounding, over 2000 steps."""
    cable = PassiveCable(10.0, 200)
    cable.potential = 50.0 * np.exp(-((cable.z - 2.0) ** 2))
    before = cable.potential.sum()
    cable.advance(0.3 * cable.h**2, 2000, leak=0.0)
    assert abs(cable.potential.sum() - before) <= 1e-13 * np.sqrt(2000) * before
    assert cable.potential.max() < 45.0, "it must have spread, or nothing was tested"


def test_operator_only_levels_out() -> None:
    """A potential that varies loses its square whatever the stretch: no cell can be charged by its likes."""
    rng = np.random.default_rng(2)
    for _ in range(50):
        potential, diffusivity = rng.normal(size=80), rng.uniform(0.3, 2.0, 79)
        assert potential @ apply_operator(potential, diffusivity, 0.1) < 0.0


def test_steady_sealed_cable_with_injected_current() -> None:
    """E2: unit flux into the first cell of a sealed cable; order 2, that of the source spread over a cell."""
    sizes, errors = [], []
    for per_length in (6, 12, 24, 48):
        cable = PassiveCable(2.0, 2 * per_length)
        assert cable.advance(0.02, 700, injected=1.0) == -1
        exact = sealed_cable(cable.z, 2.0)
        away = cable.z > 0.5
        sizes.append(cable.h)
        errors.append(float(np.abs(cable.potential / exact - 1.0)[away].max()))
    assert_order(sizes, errors, 2.0)
    assert errors[-1] <= 1e-4


def test_step_response_of_the_half_line() -> None:
    """E3, Hodgkin and Rushton: a constant flux switched on, watched at 1 space constant after 0.5 and 1 tau."""
    cable = PassiveCable(10.0, 500)
    dt = 0.3 * cable.h**2
    cell = int(1.0 / cable.h)
    for end in (0.5, 1.0):
        steps = round(0.5 / dt)
        cable.advance(0.5 / steps, steps, injected=1.0)
        near, far = (hodgkin_rushton(cable.z[k], end) for k in (cell, 3 * cell))
        assert abs(cable.potential[cell] - near) <= 1e-4
        assert abs(cable.potential[3 * cell] - far) <= 1e-4
        assert near > 0.01, "the answer must be large against the tolerance"


@pytest.mark.parametrize("stages", [2, 3, 7])
def test_conduction_step_is_second_order_in_time(stages: int) -> None:
    """E1 in time, Eq. (31): one decaying mode against exp(-(D k^2 + g) t) with the discrete symbol."""
    sizes, errors = [], []
    for steps in (64, 128, 256, 512):
        cable = PassiveCable(10.0, 50)
        k = 5.0 * np.pi / 10.0
        mode = np.cos(k * cable.z)
        cable.potential = 40.0 * mode
        cable.advance(0.5 / steps, steps, stages=stages)
        exact = 40.0 * mode * np.exp(0.5 * (discrete_symbol(k, cable.h) - 1.0))
        sizes.append(0.5 / steps)
        errors.append(float(np.abs(cable.potential - exact).max()))
    assert_order(sizes, errors, 2.0)
    assert errors[-1] <= 1e-4


@pytest.mark.parametrize("stages", [2, 4, 8])
def test_explicit_limit_from_both_sides(stages: int) -> None:
    """E9: stable at 0.99 of the limit of so many stages, blown up and noticed at 1.05 of it."""

    def after(factor: float) -> tuple[int, float]:
        cable = PassiveCable(4.0, 200)
        cable.potential = 1e-3 * (-1.0) ** np.arange(200)
        limit = stability_limit(stages) / (largest_eigenvalue(1.0, cable.h) + 1.0)
        verdict = cable.advance(factor * limit, 2000, stages=stages)
        return verdict, float(np.abs(cable.potential).max())

    verdict, amplitude = after(0.99)
    assert verdict == -1
    assert amplitude < 1e-3
    verdict, amplitude = after(1.05)
    assert verdict >= 0, "a step beyond the limit must be reported, not returned as a result"


def test_largest_eigenvalue_is_a_tight_bound() -> None:
    """The step limit uses 49/36 of the three-point value: nothing above it, and hardly anything below."""
    n, h = 60, 0.05
    matrix = np.array([apply_operator(unit, 0.0873, h) for unit in np.eye(n)]).T
    fastest = -np.linalg.eigvals(matrix).real.min()
    bound = largest_eigenvalue(0.0873, h)
    assert 0.995 * bound <= fastest <= bound * (1.0 + 1e-12)
