"""What a page may ask for, and what becomes of it: known names, numbers within bounds, the same run in Python."""

import ast
import json
import math

import pytest

from peristalsis import scenarios
from peristalsis.app import asked as asking
from peristalsis.app.controls import BY_NAME, CONTROLS, LAYERS, SWITCHES, applies
from peristalsis.errors import ConfigurationError


def test_nothing_asked_is_the_scenario() -> None:
    for name in asking.offered():
        assert asking.read({"scenario": name}).configuration().digest() == scenarios.configuration(name).digest()


def test_scenarios_of_one_column_are_offered() -> None:
    for name in scenarios.names():
        assert (name in asking.offered()) == (scenarios.configuration(name).grid.n_theta == 1)


def test_numbers_reach_their_parameters() -> None:
    """Independently stated: what each control means, in the unit of its parameter."""
    values = {
        "pellet_diameter": 1.9,
        "viscous_friction": 300.0,
        "dry_friction": 40.0,
        "tube_diameter": 1.4,
        "pressure": 0.5,
        "longitudinal_force": 80.0,
        "circular_force": 120.0,
        "fast_calcium": 50.0,
        "duration": 4.0,
    }
    found = asking.read({"values": values}).configuration()
    own = scenarios.configuration("baseline")
    assert found.pellet.radius == pytest.approx(0.95)
    assert (found.pellet.viscous_friction, found.pellet.dry_friction) == (300.0, 40.0)
    assert found.wall.radius == pytest.approx(0.7)
    assert found.lumen.pressure == pytest.approx(0.5)
    assert (found.longitudinal.active, found.circular.active) == pytest.approx((0.8, 1.2))
    for layer in LAYERS:
        assert getattr(found, layer).fast_calcium == pytest.approx(0.5 * getattr(own, layer).fast_calcium)
        assert getattr(found, layer).slow_calcium == getattr(own, layer).slow_calcium
    assert found.run.duration == 4.0


@pytest.mark.parametrize("control", CONTROLS, ids=lambda control: control.name)
def test_ends_of_every_slider_are_valid(control) -> None:  # type: ignore[no-untyped-def]
    """Whatever a slider gives, the parameters take; and what is shown of it is what was asked."""
    for value in (control.low, control.high):
        found = asking.read({"values": {control.name: value}})
        changed = found.configuration()
        if not control.share:
            assert control.shown(changed) == pytest.approx(value)


def test_channels_are_shares_of_what_the_scenario_has() -> None:
    own = scenarios.configuration("fig5_fast_calcium_decreased")
    found = asking.read({"scenario": own.scenario, "values": {"fast_calcium": 200}}).configuration()
    assert found.circular.fast_calcium == pytest.approx(2.0 * own.circular.fast_calcium)


def test_other_cells_have_no_such_channels() -> None:
    own = scenarios.configuration("slow_waves")
    assert not applies(BY_NAME["fast_calcium"], own)
    assert "fast_calcium" not in asking.defaults("slow_waves", None)["values"]
    with pytest.raises(ConfigurationError, match="no such channel"):
        asking.read({"scenario": "slow_waves", "values": {"fast_calcium": 50}})


def test_switches() -> None:
    off = asking.read({"switches": {one.name: False for one in SWITCHES}}).configuration()
    assert off.pacemaker.kind == "none"
    assert not off.reflex.enabled
    assert off.longitudinal.active == off.circular.active == 0.0
    on = asking.read({"scenario": "fig6_neither", "switches": {"pacemaker": True, "receptors": True}}).configuration()
    assert on.pacemaker.kind == "pulse"
    assert on.reflex.enabled
    periodic = asking.read({"scenario": "periodic", "switches": {"pacemaker": True}}).configuration()
    assert periodic.pacemaker.kind == "periodic", "what is on already stays as the scenario has it"


def test_a_layer_that_is_off_stays_off_whatever_its_force() -> None:
    off = asking.read({"values": {"circular_force": 150}, "switches": {"circular_layer": False}})
    assert off.configuration().circular.active == 0.0
    on = asking.read({"scenario": "pendular", "values": {"circular_force": 150}, "switches": {"circular_layer": True}})
    assert on.configuration().circular.active == pytest.approx(1.5)


@pytest.mark.parametrize(
    "content",
    [
        None,
        [],
        "baseline",
        {"scenario": "nothing"},
        {"scenario": "../../etc/passwd"},
        {"scenario": ["baseline"]},
        {"scenario": "taenia"},
        {"reading": "mine"},
        {"grid": "finest"},
        {"out": "/tmp/x"},
        {"values": {"run.duration": 5}},
        {"values": {"duration": 61}},
        {"values": {"duration": 0}},
        {"values": {"duration": math.nan}},
        {"values": {"duration": math.inf}},
        {"values": {"duration": "5 s"}},
        {"values": {"duration": True}},
        {"values": {"pressure": 10**400}},
        {"values": []},
        {"switches": {"pacemaker": 1}},
        {"switches": {"grid": True}},
        {"switches": {"__class__": True}},
    ],
    ids=repr,
)
def test_anything_else_is_refused(content: object) -> None:
    with pytest.raises(ConfigurationError) as refused:
        asking.read(content)
    assert len(str(refused.value)) < 300


def test_a_change_on_the_way() -> None:
    before = asking.read({"values": {"pressure": 0.2}})
    after, changes = asking.read_live({"values": {"fast_calcium": 50}, "switches": {"receptors": False}}, before)
    assert changes == {
        "longitudinal.fast_calcium": "2 mS/cm^2",
        "circular.fast_calcium": "2 mS/cm^2",
        "reflex.enabled": False,
    }
    assert after.configuration().lumen.pressure == 0.2
    assert asking.read_live({"values": {"pressure": 0.2}}, before)[1] == {}
    assert asking.read_live({"values": {"pressure": 0.1}}, before)[1] == {"lumen.pressure": "0.1 kPa"}, "and back again"


@pytest.mark.parametrize("change", [{"values": {"pellet_diameter": 2.0}}, {"switches": {"pacemaker": False}}], ids=repr)
def test_what_cannot_change_on_the_way_says_so(change: object) -> None:
    with pytest.raises(ConfigurationError, match="cannot change during a run"):
        asking.read_live(change, asking.read({}))


def test_the_lines_of_python_are_the_same_run() -> None:
    """Scenario, changes and reading in the text, read as Python, give the configuration of the page."""
    found = asking.read(
        {"scenario": "fig3f", "reading": "printed", "values": {"pressure": 0.3}, "switches": {"receptors": False}}
    )
    text = found.python()
    assert len(text.splitlines()) == 5
    tree = ast.parse(text)
    changes = ast.literal_eval(tree.body[1].value)  # type: ignore[attr-defined]
    call = tree.body[2].value  # type: ignore[attr-defined]
    assert ast.unparse(call) == "ps.run('fig3f', changes, reading='printed')"
    same = scenarios.configuration("fig3f", reading="printed", changes=changes)
    assert same.digest() == found.configuration().digest()


def test_what_the_page_is_given_is_plain() -> None:
    shown = asking.defaults("baseline", "printed")
    assert json.loads(json.dumps(shown, allow_nan=False)) == shown
    assert shown["reading"] == "printed"
