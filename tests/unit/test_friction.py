"""The law of friction, Eqs. (13) and (27)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import peristalsis as ps
from peristalsis.model.friction import friction_ahead, sliding_speed
from peristalsis.pellet.friction import CONSTANT, FrictionLaw, dry_friction, sliding_velocity
from verification.exact.runs import March, march

forces = st.floats(-5000, 5000)
frictions = st.floats(0, 3000)
viscosities = st.floats(1.0, 5000)


@given(forces, viscosities, frictions)
def test_sticks_exactly_or_slides_at_the_excess(force: float, viscous: float, dry: float) -> None:
    """F1: 0.0, not a small number, while |F| <= F_d; else sgn(F)(|F| - F_d)/eta."""
    velocity, slope = sliding_velocity(force, viscous, dry)
    if abs(force) <= dry:
        assert (velocity, slope) == (0.0, 0.0)
    else:
        exact = (abs(force) - dry) / viscous * (1.0 if force > 0 else -1.0)
        assert velocity == pytest.approx(exact, rel=1e-14)
        assert slope == 1.0 / viscous
        assert viscous * velocity + dry * (1.0 if velocity > 0 else -1.0) == pytest.approx(force, rel=1e-12)


@given(forces, viscosities, frictions)
def test_friction_is_the_same_both_ways_and_takes_energy(force: float, viscous: float, dry: float) -> None:
    velocity = sliding_velocity(force, viscous, dry)[0]
    assert sliding_velocity(-force, viscous, dry)[0] == -velocity
    assert force * velocity >= 0.0


@given(forces, viscosities)
def test_limits(force: float, viscous: float) -> None:
    """F9: without dry friction v = F/eta; friction without bound holds the pellet for ever."""
    assert sliding_velocity(force, viscous, 0.0)[0] == pytest.approx(force / viscous, rel=1e-14)
    assert abs(sliding_velocity(force, 1e12, 0.0)[0]) <= 5e-9
    assert sliding_velocity(force, viscous, 1e9)[0] == 0.0


@given(frictions, st.floats(0, 1e5), st.booleans())
def test_default_law_is_the_printed_one(dry: float, pressing: float, stuck: bool) -> None:
    """Eq. (13) to the last bit, whatever the wall presses."""
    assert dry_friction(dry, CONSTANT, pressing, stuck) == dry


def test_static_and_pressing_friction_add_up() -> None:
    """Eqs. (50), (51): the factor holds the resting pellet only, and multiplies the sum."""
    law = FrictionLaw(static_factor=1.5, coefficient=0.1)
    assert dry_friction(20.0, law, 300.0, stuck=False) == pytest.approx(50.0)
    assert dry_friction(20.0, law, 300.0, stuck=True) == pytest.approx(75.0)


COARSE = {"grid.n_z": 400, "grid.n_z_wall": 200}


def breakaway(taken: March) -> int:
    """The first step at whose end the pellet slides."""
    return next(k for k, state in enumerate(taken.states) if k and state.pellet.velocity != 0.0)


def test_static_friction_holds_longer_and_then_lets_go() -> None:
    """Eq. (50) in the coupled run: held up to f F_d, and from the next step on against F_d alone."""
    usual = march(0.6, COARSE, {"pellet.dry_friction": "100 mN"})
    static = march(0.6, COARSE, {"pellet.dry_friction": "100 mN", "pellet.static_friction_factor": 1.6})
    first = breakaway(static)
    assert breakaway(usual) < first
    before, after, later = static.states[first - 1 : first + 2]
    assert before.pellet.axial_force <= 160.0 < after.pellet.axial_force
    assert (before.pellet.dry, after.pellet.dry, later.pellet.dry) == (160.0, 160.0, 100.0)
    assert all(s.pellet.position == static.states[0].pellet.position for s in static.states[:first])


@pytest.mark.parametrize("frame", ["rest", "wall"])
def test_pressing_friction_is_that_of_the_start_of_the_step(frame: str) -> None:
    """Eq. (51): F_z = eta v + (F_d + mu N) sgn v, with N from the state before, summed here by hand."""
    taken = march(0.6, COARSE, {"pellet.friction_coefficient": 0.05, "pellet.friction_frame": frame})
    model = taken.model
    area = 2.0 * np.pi * model.wall.radius * model.wall.element_size
    slid = 0
    for before, after in zip(taken.states[1:-1], taken.states[2:], strict=True):
        rho, zeta = before.wall.position[:, 0, 0], before.wall.position[:, 0, 2] - before.pellet.position
        pressing = area * float((before.wall.contact[:, 0] * rho / np.sqrt(rho**2 + zeta**2)).sum())
        speed = sliding_speed(model, after.pellet)
        if speed != 0.0:
            slid += 1
            friction = 230.0 * speed + (20.0 + 0.05 * pressing) * np.sign(speed)
            assert friction == pytest.approx(after.pellet.axial_force, rel=1e-9)
        else:
            assert abs(after.pellet.axial_force) <= (20.0 + 0.05 * pressing) * (1.0 + 1e-12)
    assert slid > 20
    _, weight = friction_ahead(model, taken.last.wall, taken.last.pellet)
    assert weight.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("frame", ["rest", "wall"])
def test_friction_along_the_meridian_keeps_the_balance_of_work(frame: str) -> None:
    """The reaction works across the axis too, Eq. (51): without that term 8 % of all work is missing."""
    changes = {"pellet.friction_coefficient": 0.1, "pellet.friction_frame": frame, "run.duration": "0.8 s"}
    result = ps.run("baseline", COARSE | changes)
    assert result.arrays["pellet_velocity"].max() > 0.5
    assert result.summary["power_residual"] <= 1e-3
