"""The coupled run: what X1-X6 leave: wrong signs, sticking, and switches that really switch."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from peristalsis.model.balance import Work
from verification.coupled import balance, unbalanced
from verification.exact.runs import march, wave_catches_pellet


@pytest.mark.parametrize("term", [f for f in Work._fields if f != "kinetic"])
def test_power_balance_notices_a_wrong_sign(term: str) -> None:
    """X1 can fail: any one term with its sign turned leaves ten times the residual."""
    works, exchanged = balance(wave_catches_pellet())
    right = unbalanced(works, exchanged)
    wrong = unbalanced([w._replace(**{term: -getattr(w, term)}) for w in works], exchanged)
    assert wrong > 10.0 * right


def test_pellet_sticks_exactly() -> None:
    """F1 in the coupled run: velocity 0.0 and a place that keeps every bit while |F_z| <= F_d, then it slides."""
    taken = march(0.6, {"pellet.dry_friction": "150 mN"})
    stuck = 0
    for before, after in zip(taken.states[1:-1], taken.states[2:], strict=True):
        if abs(before.pellet.axial_force) <= 150.0 and abs(after.pellet.axial_force) <= 150.0:
            stuck += 1
            assert after.pellet.velocity == 0.0
            assert after.pellet.position == before.pellet.position
    assert stuck > 50
    assert taken.last.pellet.position > taken.states[0].pellet.position + 0.05, "it must break away"


def test_stuck_pellet_follows_the_wall_in_the_moving_frame() -> None:
    """Eq. (27): with friction against the wall, sticking means moving with it, and then it moves at any F_d."""
    rest = march(0.4, {"pellet.dry_friction": "1e5 mN"})
    wall = march(0.4, {"pellet.dry_friction": "1e5 mN", "pellet.friction_frame": "wall"})
    assert rest.last.pellet.position == rest.states[0].pellet.position
    assert abs(wall.last.pellet.position - wall.states[0].pellet.position) > 1e-3


SWITCHES: dict[str, tuple[dict[str, Any], str]] = {
    "pacemaker": ({"pacemaker.kind": "none"}, "longitudinal"),
    "pacemaker cell": ({"pacemaker.kind": "cell"}, "longitudinal"),
    "trigger": ({"trigger.rule": "none"}, "circular"),
    "trigger by total tension": ({"trigger.rule": "total"}, "circular"),
    "trigger by pacemaker": ({"trigger.rule": "pacemaker"}, "circular"),
    "trigger by delay": ({"trigger.rule": "delay"}, "circular"),
    "reflex": ({"reflex.enabled": False}, "circular"),
    "longitudinal conduction": ({"longitudinal.conduction": False}, "longitudinal"),
    "circular conduction": ({"circular.conduction": False}, "circular"),
    "longitudinal force": ({"longitudinal.active": 0.0}, "wall"),
    "circular force": ({"circular.active": 0.0}, "wall"),
    "rings": ({"rings.enabled": True}, "circular"),
    "friction frame": ({"pellet.friction_frame": "wall"}, "wall"),
    "tension": ({"wall.tension": "consistent"}, "wall"),
    "inertia": ({"wall.inertia": True, "wall.surface_density": "26140 mg/cm^2"}, "wall"),
    "scheme": ({"step.scheme": "euler"}, "wall"),
    "slow calcium": ({"longitudinal.slow_calcium": "0.005 mS/cm^2"}, "longitudinal"),
    "pressure": ({"lumen.pressure": "0.15 kPa"}, "wall"),
}

COARSE = {"grid.n_z": 200, "grid.n_z_wall": 100}


@pytest.mark.parametrize("name", SWITCHES)
def test_switches_switch(name: str) -> None:
    """Each changes what it is about within 0.4 s, by far more than rounding."""
    changes, about = SWITCHES[name]
    usual, other = march(0.4, COARSE).last, march(0.4, COARSE, changes).last
    if about == "wall":
        assert np.abs(usual.wall.position - other.wall.position).max() > 1e-4
    else:
        assert np.abs(getattr(usual, about).potential - getattr(other, about).potential).max() > 1.0


def test_strongly_coupled_pacemaker_cell_is_stable() -> None:
    """Eq. (24): the stronger the link the closer cell and muscle; nothing may oscillate with the step."""
    taken = march(0.1, COARSE, {"pacemaker.kind": "cell", "pacemaker.cell_coupling": "1 mS/cm^2"})
    difference = taken.last.pacemaker.potential[0, 0] - taken.last.longitudinal.potential[0, 0]
    assert abs(difference) < 5.0


def test_force_factor_does_not_silence_the_trigger() -> None:
    """Eq. (25): the rule reads the tension before the factor, so a layer without force still starts the other."""
    usual, weak = march(0.4, COARSE).last, march(0.4, COARSE, {"longitudinal.active": 0.0}).last
    started = np.isfinite(usual.circular.first_activation)
    assert started.sum() > 5
    # Without longitudinal shortening lambda_l stays near one, and the maximum comes within a few steps of the same.
    both = started & np.isfinite(weak.circular.first_activation)
    assert both.sum() > 0.5 * started.sum()


def test_states_are_whole() -> None:
    """No field of any state is nan or infinite, activation times and refractory starts apart."""
    for state in wave_catches_pellet().states[::50]:
        for part in (state.wall, state.pellet, replace(state.longitudinal, first_activation=0, last_activation=0)):
            assert all(np.all(np.isfinite(getattr(part, f.name))) for f in fields(part))
