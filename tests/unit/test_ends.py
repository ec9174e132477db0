"""The two ends of the segment: leaving orally, ends that hold the pellet, and wall that bulges over its rings."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.errors import ConfigurationError
from peristalsis.model.ends import bulges, passages
from peristalsis.model.friction import end_reaction, rests_on_end, sliding_speed
from peristalsis.model.state import State
from peristalsis.results.findings import remarks_of_summary
from peristalsis.running.observers import StopConditions
from peristalsis.running.simulation import Simulation
from peristalsis.scenarios import configuration

COARSE = {"grid.n_z": 200, "grid.n_z_wall": 100, "output.interval": "50 ms"}
ORALLY = {
    "pellet.start_gap": "0 cm",
    "pacemaker.place": "2 cm",
    "pellet.dry_friction": "0 mN",
    "reflex.enabled": False,
}
"""A wave that begins on the anal side of the pellet drives it out orally."""
CLOSED = {"wall.oral_end": "closed", "wall.anal_end": "closed"}


@pytest.fixture(scope="module")
def leaving() -> ps.Result:
    return ps.run("baseline", {**COARSE, **ORALLY, "run.duration": "2 s"})


@pytest.fixture(scope="module")
def held() -> ps.Result:
    return ps.run("baseline", {**COARSE, **ORALLY, **CLOSED, "run.duration": "0.6 s"})


def times(result: ps.Result, kind: str) -> list[float]:
    return [float(t) for t in result.arrays["event_time"][result.arrays["event_kind"] == kind]]


def test_pellet_that_leaves_orally_is_said_to(leaving: ps.Result) -> None:
    """It ends the run with a status of its own, an event, a time, and a remark."""
    summary = leaving.summary
    assert leaving.status == "expelled_orally"
    assert summary["transit_s"] is None
    assert times(leaving, "expelled_orally") == [summary["oral_exit_s"]]
    assert times(leaving, "oral_end")[0] < summary["oral_exit_s"]
    assert summary["simulated_s"] == pytest.approx(summary["oral_exit_s"], abs=0.005)
    assert summary["mean_velocity_cm_s"] == pytest.approx(summary["travel_cm"] / summary["oral_exit_s"])
    assert summary["travel_cm"] == pytest.approx(-summary["start_cm"], abs=1e-9), "the centre stood at the end then"
    assert summary["beyond_oral_end_cm"] == pytest.approx(
        leaving.configuration.pellet.radius - leaving.arrays["pellet_position"].min()
    )
    assert any("beyond the oral end" in remark for remark in leaving.remarks)


def test_figures_show_the_oral_end(leaving: ps.Result) -> None:
    """The axis has room for the pole outside, and the title says how the run ended."""
    for name in ("track", "diameter_map"):
        figure = getattr(leaving.plot, name)()
        low, high = sorted(figure.axes[0].get_ylim())
        assert low < -8.0
        assert high > 100.0
        assert "expelled orally" in figure.get_suptitle()
        assert any("clamped oral end" in text.get_text() for text in figure.axes[0].texts)


def test_closed_end_holds_the_pellet(held: ps.Result) -> None:
    """The pole stands exactly at the end, at rest, and the end bears what friction leaves of the wall's push."""
    place, force = held.arrays["pellet_position"], held.arrays["axial_force"]
    assert place.min() == held.configuration.pellet.radius
    resting = (place == place.min()) & (held.arrays["pellet_velocity"] == 0.0) & (force < 0.0)
    assert resting.sum() > 50
    assert held.arrays["end_reaction"][resting] == pytest.approx(-force[resting], rel=1e-12), "no dry friction"
    assert held.summary["max_end_reaction_mN"] > 50.0
    assert held.arrays["dry_force"] == pytest.approx(0.0, abs=1e-9), "the end is no friction"
    assert len(times(held, "end_reached")) == 1
    assert held.status == "in_transit"
    assert held.summary["beyond_oral_end_cm"] == 0.0


def test_balances_close_at_a_closed_end(held: ps.Result) -> None:
    """An end at rest does no work, and takes no part in the momentum of the wall."""
    assert held.summary["power_residual"] < 1e-3
    assert held.summary["momentum_residual"] < 1e-8


def test_dry_friction_bears_its_part() -> None:
    """With F_d the end bears |F_z| - F_d, and nothing while friction alone holds the pellet."""
    result = ps.run("baseline", {**COARSE, **ORALLY, **CLOSED, "pellet.dry_friction": "20 mN", "run.duration": "0.4 s"})
    force, reaction = result.arrays["axial_force"], result.arrays["end_reaction"]
    resting = (result.arrays["pellet_position"] == result.configuration.pellet.radius) & (force <= 0.0)
    assert resting.sum() > 20
    assert reaction[resting] == pytest.approx(np.maximum(-force[resting] - 20.0, 0.0), abs=1e-9)


def test_closed_anal_end_holds_what_would_be_expelled() -> None:
    short = {**COARSE, "wall.length": "3 cm", "output.probes": ["1 cm"], "run.duration": "1 s"}
    result = ps.run("baseline", {**short, "wall.anal_end": "closed"})
    assert result.status != "expelled"
    assert result.arrays["pellet_position"].max() == 3.0 - result.configuration.pellet.radius
    assert result.arrays["end_reaction"].min() < -50.0, "it pushes orally"
    assert times(result, "end_reached")


def test_ends_that_nothing_reaches_change_no_bit() -> None:
    plain, closed = (ps.run("baseline", {**COARSE, **ends, "run.duration": "0.3 s"}) for ends in ({}, CLOSED))
    assert closed.fingerprint == plain.fingerprint


@pytest.mark.parametrize(
    "changes",
    [{"solver.integrator": "explicit", "grid.n_z": 100, "grid.n_z_wall": 30, "wall.surface_density": "26140 mg/cm^2"}],
)
def test_explicit_scheme_holds_it_too(changes: dict[str, Any]) -> None:
    start = {**COARSE, **ORALLY, **CLOSED, "pellet.start_gap": "0 cm", "run.duration": "0.2 s"}
    result = ps.run("baseline", {**start, **changes})
    assert result.error is None
    assert result.arrays["pellet_position"].min() == result.configuration.pellet.radius
    assert result.arrays["end_reaction"].max() > 0.0


def test_closed_end_with_friction_on_the_wall_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"wall\.oral_end = closed: .* friction at rest only"):
        ps.run("baseline", {**COARSE, "wall.oral_end": "closed", "pellet.friction_frame": "wall"})


@pytest.fixture(scope="module")
def start() -> Simulation:
    return Simulation(configuration("baseline", changes={**COARSE, **CLOSED, "run.duration": "10 ms"}))


def at(state: State, place: float, force: float = 0.0, velocity: float = 0.0) -> State:
    return replace(state, pellet=replace(state.pellet, position=place, axial_force=force, velocity=velocity))


def test_reaction_acts_inward_only(start: Simulation) -> None:
    """Both ends bear a push that is directed outward, less dry friction, and never pull."""
    model, radius, dry = start.model, start.model.pellet.radius, start.model.pellet.dry
    for place, sign in ((radius, 1.0), (model.grid.length - radius, -1.0)):
        pressed = at(start.state, place, -sign * 100.0).pellet
        assert end_reaction(model, pressed) == pytest.approx(sign * (100.0 - dry), rel=1e-12)
        assert sliding_speed(model, pressed) == 0.0
        assert end_reaction(model, at(start.state, place, -sign * 0.5 * dry).pellet) == 0.0
        assert end_reaction(model, at(start.state, place, sign * 100.0).pellet) == 0.0
    assert not rests_on_end(model, at(start.state, 5.0, 100.0).pellet)
    assert end_reaction(model, at(start.state, 5.0, 100.0).pellet) == 0.0


def test_times_of_passage_are_linear_within_the_step(start: Simulation) -> None:
    model = replace(start.model, pellet=start.model.pellet._replace(lowest=-math.inf, highest=math.inf))
    radius, length, dt = model.pellet.radius, model.grid.length, model.dt_wall
    state = replace(start.state, step=7)

    def pair(a: float, b: float) -> tuple[State, State]:
        return at(state, a), at(state, b)

    anal = passages(model, *pair(length - radius - 0.01, length - radius + 0.03))
    assert anal.anal == pytest.approx((7 + 0.25) * dt)
    assert anal.oral_pole is None
    assert anal.oral is None
    assert passages(model, *pair(radius + 0.03, radius - 0.01)).oral_pole == pytest.approx((7 + 0.75) * dt)
    assert passages(model, *pair(0.01, -0.01)).oral == pytest.approx(7.5 * dt)
    assert passages(model, *pair(radius, radius)) == (None, None, None), "a pellet that starts at the end stays inside"
    assert passages(model, *pair(radius, radius - 0.01)).oral_pole == pytest.approx(7 * dt)
    assert passages(model, *pair(-0.01, 0.01)) == (None, None, None), "coming back is no leaving"


def test_stop_position_is_reached_from_either_side(start: Simulation) -> None:
    stop = StopConditions(2.0, False)
    report: Any = None
    assert stop.see(start.model, at(start.state, 1.9), at(start.state, 2.0), report) == "the pellet has reached 2 cm"
    assert stop.see(start.model, at(start.state, 2.1), at(start.state, 1.9), report) == "the pellet has reached 2 cm"
    assert stop.see(start.model, at(start.state, 2.1), at(start.state, 2.2), report) is None


def test_wall_that_bulges_over_its_rings_is_named_before_the_run() -> None:
    """At 20 kPa the inflated tube stands out by eight millimetres over both rings."""
    run = Simulation(configuration("baseline", changes={**COARSE, "lumen.pressure": "20 kPa", "run.duration": "10 ms"}))
    (remark,) = [text for text in run.remarks if "bulges" in text]
    assert "lumen.pressure = 20 kPa" in remark
    summary = run.run().summary
    assert summary["bulge_cm"]["oral"] == pytest.approx(summary["bulge_cm"]["anal"], rel=0.05)
    assert summary["bulge_cm"]["oral"] == pytest.approx(0.8, rel=0.1)
    assert summary["max_diameter_cm"] > 2.2


def test_bulges_are_measured_over_both_ends() -> None:
    axial = np.array([[[0.0], [1.0], [2.0]], [[0.0], [-0.3], [2.0]], [[0.0], [2.5], [2.0]]])
    oral, anal = bulges(axial, 2.0)
    assert oral.tolist() == [0.0, 0.3, 0.0]
    assert anal.tolist() == [0.0, 0.0, 0.5]


def test_bulge_that_grows_in_the_run_is_a_remark(held: ps.Result) -> None:
    assert not any("bulges" in remark for remark in held.remarks)
    axial = held.arrays["axial_position"].copy()
    axial[-1, 1] = -0.7
    arrays = {**held.arrays, "axial_position": axial}
    (remark,) = remarks_of_summary(held.configuration, held.summary, arrays)
    assert "bulges 0.7 cm over its clamped oral ring" in remark


def test_balances_that_do_not_close_are_remarks(held: ps.Result) -> None:
    summary = {**held.summary, "power_residual": 0.02, "momentum_residual": 0.5}
    power, momentum = remarks_of_summary(held.configuration, summary, held.arrays)
    assert "power_residual = 0.02" in power
    assert "momentum_residual = 0.5" in momentum
    summary = {**held.summary, "power_residual": None, "momentum_residual": None}
    assert remarks_of_summary(held.configuration, summary, held.arrays) == []


def test_forces_that_no_gut_bears_are_a_remark(held: ps.Result) -> None:
    summary = {**held.summary, "max_normal_force_mN": 2e6}
    found = remarks_of_summary(held.configuration, summary, held.arrays)
    assert any("max_normal_force_mN = 2e+06" in remark and "pellet.radius" in remark for remark in found)
