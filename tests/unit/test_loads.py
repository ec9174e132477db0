"""Friction in proportion to pressing and falling with speed, loads on a string, a held pellet: Eqs. (123)-(125)."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import peristalsis as ps
from peristalsis.errors import ConfigurationError
from peristalsis.inputs.build import build
from peristalsis.pellet.body import pellet_of
from peristalsis.pellet.constants import Resistance
from peristalsis.pellet.friction import FrictionLaw, falling_velocity, pressed_part, sliding_velocity
from peristalsis.pellet.load import pull_of_load
from peristalsis.pellet.shapes.sphere import ShapeConstants

SMALL: dict[str, Any] = {"grid.n_z": 200, "grid.n_z_wall": 150, "step.wall": "100 ms", "step.conduction": "20 ms"}


def run(changes: dict[str, object]) -> ps.Result:
    return ps.Simulation(ps.configuration("guinea_pig", changes={**SMALL, **changes})).run()


# --- a coefficient that falls with speed ------------------------------------------------------------


@given(st.floats(-500, 500), st.floats(1.0, 500), st.floats(0.0, 200), st.floats(0.0, 0.999), st.floats(0.01, 10))
def test_the_sliding_pellet_is_in_balance(
    force: float, viscous: float, dry: float, fast_share: float, fall_speed: float
) -> None:
    """eta v + D (s + (1 - s)/(1 + v/v0)) = F at the speed that is found, and its slope is that of the curve."""
    speed, slope = falling_velocity(force, viscous, dry, fast_share, fall_speed, True)
    if speed == 0.0:
        assert slope == 0.0
        assert abs(force) <= dry * (1.0 + 1e-12)
        return
    size = abs(speed)
    friction = viscous * size + dry * (fast_share + (1.0 - fast_share) / (1.0 + size / fall_speed))
    assert math.copysign(friction, speed) == pytest.approx(force, rel=1e-9, abs=1e-9)
    steep = viscous - dry * (1.0 - fast_share) / fall_speed / (1.0 + size / fall_speed) ** 2
    assert slope * steep == pytest.approx(1.0, rel=1e-5) or abs(steep) < 1e-3 * viscous


def test_between_two_speeds_history_decides() -> None:
    """Where friction falls with speed, a resting pellet stays up to the dry friction, a sliding one to the fold."""
    law = (10.0, 50.0, 0.2, 0.1)
    assert falling_velocity(45.0, *law, False) == (0.0, 0.0)
    assert falling_velocity(45.0, *law, True)[0] > 1.0
    assert falling_velocity(10.0, *law, True) == (0.0, 0.0)
    assert falling_velocity(50.001, *law, False)[0] > 1.0


@given(st.floats(-500, 500), st.floats(1.0, 500), st.floats(0.0, 200), st.booleans())
def test_without_a_fall_it_is_the_printed_law(force: float, viscous: float, dry: float, sliding: bool) -> None:
    assert falling_velocity(force, viscous, dry, 1.0, 0.1, sliding) == sliding_velocity(force, viscous, dry)


# --- friction in proportion to pressing -------------------------------------------------------------


def test_part_of_friction_that_is_pressed() -> None:
    """At eta = 40, c N = 60 and no dry friction three fifths of it are; with dry friction alone, its own share."""
    law = FrictionLaw(viscous_coefficient=0.6)
    assert pressed_part(0.0, law, 100.0, 50.0, 0.0, 40.0) == pytest.approx(0.6)
    both = FrictionLaw(coefficient=0.1, viscous_coefficient=0.6)
    assert pressed_part(10.0, both, 100.0, 15.0, 20.0, 40.0) == pytest.approx(0.5)
    assert pressed_part(10.0, both, 100.0, 40.0, 20.0, 40.0) == pytest.approx((0.5 * 20.0 + 0.6 * 20.0) / 40.0)


def test_velocity_is_what_is_left_of_the_force_over_the_friction() -> None:
    """With N as the wall presses when a step begins: (eta + c N) v + F_d + mu N = F, step by step."""
    simulation = ps.Simulation(ps.configuration("guinea_pig", changes={**SMALL, "run.duration": "20 s"}))
    simulation.advance("12 s")
    pellet, wall = simulation.configuration.pellet, simulation.configuration.wall
    for _ in range(20):
        before = simulation.state.wall
        node = 2.0 * math.pi * wall.radius * wall.length / SMALL["grid.n_z_wall"]
        pressing = node * float((before.contact[:, 0] * before.position[:, 0, 0] / pellet.radius).sum())
        simulation.advance("100 ms")
        now = simulation.state.pellet
        assert now.velocity > 0.05
        viscous = pellet.viscous_friction + pellet.viscous_friction_coefficient * pressing
        dry = pellet.dry_friction + pellet.friction_coefficient * pressing
        assert viscous * now.velocity + dry == pytest.approx(now.axial_force, rel=1e-5)


# --- loads ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("place", "expected"), [(0.5, (0.0, 0.0)), (1.0, (0.0, 0.0)), (1.2, (10.0, 50.0)), (3.0, (20.0, 0.0))]
)
def test_string_is_slack_then_stretches_then_lifts(place: float, expected: tuple[float, float]) -> None:
    pellet = pellet_of(ShapeConstants(0.4), resistance=Resistance(20.0, 50.0, 1.0))
    assert pull_of_load(place, pellet) == pytest.approx(expected)


def test_a_weight_holds_back_and_a_heavy_one_stalls() -> None:
    """At rest on the string the pull is the wall's force less what friction holds."""
    ends = {}
    for weight in (0, 40, 400):
        load = {"pellet.load": "weight", "pellet.load_weight": f"{weight} mN"} if weight else {}
        result = run({"run.duration": "30 s", **load})
        ends[weight] = result.arrays["pellet_position"][-1]
    assert ends[0] > ends[40] + 0.5 > ends[400] + 1.0
    spring = run({"run.duration": "30 s", "pellet.load": "spring", "pellet.load_stiffness": "200 mN/cm"})
    arrays = spring.arrays
    stretched = arrays["pellet_position"][-1] - arrays["pellet_position"][0]
    held = abs(arrays["dry_force"][-1]) + abs(arrays["viscous_force"][-1])
    assert abs(200.0 * stretched - arrays["axial_force"][-1]) <= held + 1e-6
    assert spring.summary["power_residual"] < 5e-3, "the work done on the spring is part of the balance"


def test_a_load_by_protocol_is_the_load_from_then_on() -> None:
    """A weight of 0 until 10 s moves like none, and then holds back."""
    loaded = {"pellet.load": "weight", "pellet.load_weight": "0 mN"}
    changing = run(
        {**loaded, "run.duration": "20 s", "protocols": ["pellet.load_weight: step 0 mN at 0 s, 80 mN at 10 s"]}
    )
    free = run({"run.duration": "20 s"})
    time = free.arrays["time_step"]
    before = time <= 10.0
    assert np.array_equal(changing.arrays["pellet_position"][before], free.arrays["pellet_position"][before])
    assert changing.arrays["pellet_position"][-1] < free.arrays["pellet_position"][-1] - 0.2


def test_the_pull_of_a_load_by_protocol_is_its_value_at_the_step() -> None:
    """F_z less what friction takes is the weight of the protocol at the beginning of each step."""
    line = "pellet.load_weight: ramp 0 mN at 8 s, 30 mN at 14 s"
    result = run({"pellet.load": "weight", "run.duration": "18 s", "protocols": [line]})
    arrays = result.arrays
    time = arrays["time_step"]
    asked = np.interp(time - 0.1, (8.0, 14.0), (0.0, 30.0))
    pull = arrays["axial_force"] + arrays["dry_force"] + arrays["viscous_force"]
    sliding = (arrays["pellet_velocity"] > 0.05) & (time > 4.0)
    assert sliding.sum() > 50
    assert asked[sliding].max() > 29.0
    assert np.abs(pull - asked)[sliding].max() < 1e-6


@pytest.mark.parametrize("key", ["pellet.load_weight", "pellet.load_stiffness"])
def test_a_load_by_protocol_without_a_string_is_refused(key: str) -> None:
    unit = "mN" if key.endswith("weight") else "mN/cm"
    with pytest.raises(ConfigurationError, match=r"pellet\.load = none does not read it; set pellet\.load = weight"):
        ps.configuration("guinea_pig", changes={"protocols": [f"{key}: step 1 {unit} at 0 s"]})


def test_warming_by_protocol_acts_from_its_step_on() -> None:
    """Force is Q_F^(T/10) of what it was, and the cells run Q_k^(T/10) times as fast, from the first step at 3 s on."""
    line = "tissue.warming: step 0 K at 0 s, -10 K at 3 s"
    simulation = ps.Simulation(ps.configuration("guinea_pig", changes={**SMALL, "protocols": [line]}))
    tissue = simulation.configuration.tissue
    simulation.advance("3 s")
    warm = simulation.model.circular
    simulation.advance("100 ms")
    cold = simulation.model.circular
    assert cold.force_factor / warm.force_factor == pytest.approx(1.0 / tissue.q10_force)
    assert cold.constants.kinetics_rate / warm.constants.kinetics_rate == pytest.approx(1.0 / tissue.q10_kinetics)


def test_a_held_pellet_stays_and_is_pushed() -> None:
    result = run({"pellet.held": True, "pellet.start_gap": "3 cm", "run.duration": "15 s"})
    arrays = result.arrays
    assert np.ptp(arrays["pellet_position"]) < 1e-12
    assert arrays["axial_force"].max() > 20.0
    balance = arrays["axial_force"] + arrays["end_reaction"] + arrays["dry_force"] + arrays["viscous_force"]
    assert np.abs(balance).max() < 1e-9


@pytest.mark.parametrize(
    "changes",
    [
        {"pellet.load": "weight", "grid.n_theta": 8},
        {"pellet.viscous_friction_coefficient": "0.1 s/cm", "grid.n_theta": 8},
        {"pellet.fast_friction_share": 0.5, "solver.integrator": "explicit"},
    ],
)
def test_where_a_law_is_not_there_it_is_refused(changes: dict[str, object]) -> None:
    with pytest.raises(ConfigurationError, match="one column, stepped implicitly"):
        ps.configuration("baseline", changes=changes)


# --- slack and temperature --------------------------------------------------------------------------


def test_slack_shortens_the_tube_between_its_ends() -> None:
    simulation = ps.Simulation(ps.configuration("guinea_pig", changes={**SMALL, "wall.slack_length": "1 cm"}))
    place = simulation.state.wall.position[:, 0, 2]
    assert (place[0], place[-1]) == (0.0, 7.0)
    assert simulation.model.grid.length == 8.0
    result = run({"wall.slack_length": "1 cm"})
    assert result.status == "expelled"
    arrays = result.arrays
    end = np.interp(result.summary["transit_s"], arrays["time_step"], arrays["pellet_position"])
    assert end == pytest.approx(7.0 - 0.4, abs=1e-3)


def test_too_much_slack_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"wall\.slack_length"):
        ps.configuration("baseline", changes={"wall.slack_length": "5 cm"})


def test_warming_scales_kinetics_and_force_by_its_q10() -> None:
    def model(changes: dict[str, object]):  # type: ignore[no-untyped-def]
        return build(ps.configuration("baseline", changes=changes))

    cold = model({"tissue.warming": "-10 K", "tissue.q10_kinetics": 2.5, "tissue.q10_force": 1.25})
    assert cold.longitudinal.constants.kinetics_rate == pytest.approx(0.125 / 2.5)
    assert cold.circular.force_factor == pytest.approx(0.8)
    assert model({"tissue.q10_kinetics": 9.0}).longitudinal.constants.kinetics_rate == 0.125
