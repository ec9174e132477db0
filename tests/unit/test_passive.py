"""The passive law against complex steps of the energy, Eqs. (3) and (4)."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis.wall.passive import PassiveConstants, passive_tension, strain_energy
from verification.exact.wall import COUPLED, TIGHT, complex_step, energy, gradient

stretches = st.floats(0.5, 2.0)


@pytest.mark.parametrize("constants", [TIGHT, COUPLED], ids=["tight", "coupled"])
@given(longitudinal=stretches, circumferential=stretches)
def test_tensions_are_derivatives_of_the_energy(
    constants: PassiveConstants, longitudinal: float, circumferential: float
) -> None:
    """M3: gradient and Hessian by complex steps to 1e-10 over [0.5, 2]^2; the energy itself to 1e-13."""
    a, b = longitudinal, circumferential
    assert strain_energy(a, b, constants) == pytest.approx(energy(a, b, constants), rel=1e-13)
    wl, wc, wll, wlc, wcc = passive_tension(a, b, constants)
    scale = 1.0 + abs(wl) + abs(wc)
    assert wl == pytest.approx(complex_step(lambda x: energy(x, b, constants), a), rel=1e-10, abs=1e-10 * scale)
    assert wc == pytest.approx(complex_step(lambda x: energy(a, x, constants), b), rel=1e-10, abs=1e-10 * scale)
    for found, index, along in ((wll, 0, 0), (wlc, 0, 1), (wlc, 1, 0), (wcc, 1, 1)):
        wanted = complex_step(
            lambda x, k=index, first=along == 0: gradient(x if first else a, b if first else x, constants)[k],
            a if along == 0 else b,
        )
        assert found == pytest.approx(wanted, rel=1e-10, abs=1e-10 * scale)


def test_undeformed_wall_has_no_tension() -> None:
    assert passive_tension(1.0, 1.0, COUPLED)[:2] == (0.0, 0.0)


def test_half_covers_the_bracket_alone() -> None:
    """Eq. (4): at small strain the stiffness is c1 + 2 c4 c10, and c3 stands before the plain product of strains."""
    _, _, wll, wlc, wcc = passive_tension(1.0, 1.0, TIGHT)
    assert wll == pytest.approx(10.4 + 2.0 * 3.79 * 10.0, rel=1e-14)
    assert wlc == pytest.approx(2.59, rel=1e-14)
    assert wcc == pytest.approx(10.4 + 2.0 * 12.7 * 10.0, rel=1e-14)
