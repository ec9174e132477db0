"""The runs of the paper under every reading: the experiment's own numbers apply over those of the reading."""

import pytest

from peristalsis.errors import ConfigurationError
from peristalsis.inputs.parameters import READINGS
from peristalsis.scoring.experiment import Experiment
from peristalsis.scoring.paper.runs import RUNS, phase_name
from peristalsis.scoring.paper.searches import SEARCHES, SENSITIVITIES

REFUSED = {("fig7c", "stretched")}


@pytest.mark.parametrize("reading", READINGS)
def test_every_run_is_valid_or_refused_with_a_sentence(reading: str) -> None:
    for name, run in RUNS.items():
        if (name, reading) in REFUSED:
            with pytest.raises(ConfigurationError, match="the tube cannot hold this pellet"):
                run.configuration(reading)
            continue
        configuration = run.configuration(reading)
        assert (configuration.reading, configuration.scenario) == (reading, run.scenario)


@pytest.mark.parametrize("reading", READINGS)
def test_the_radius_of_a_scenario_stands_over_the_reading(reading: str) -> None:
    configuration = RUNS["fig7b"].configuration(reading)
    assert configuration.wall.radius == 0.9
    assert configuration.pellet.radius == RUNS["baseline"].configuration(reading).pellet.radius


@pytest.mark.parametrize("reading", READINGS)
def test_factors_and_ratios_are_those_of_the_reading(reading: str) -> None:
    base = RUNS["baseline"].configuration(reading)
    assert RUNS["pellet_x1.1"].configuration(reading).pellet.radius == pytest.approx(1.1 * base.pellet.radius)
    assert RUNS["ratio_1.02"].configuration(reading).pellet.radius == pytest.approx(1.02 * base.wall.radius)
    assert RUNS["eta_x4"].configuration(reading).pellet.viscous_friction == 4.0 * base.pellet.viscous_friction
    doubled = RUNS["slow_calcium_x2"].configuration(reading)
    assert doubled.longitudinal.slow_calcium == doubled.circular.slow_calcium == 2.0 * base.circular.slow_calcium


def test_friction_is_the_papers_in_the_units_that_are_read() -> None:
    pairs = [(230, 20), (230, 2), (200, 20), (90, 450), (230, 450), (1200, 20), (230, 800)]
    found = [RUNS[f"fig3{letter}"].configuration("tight").pellet for letter in "abcdefg"]
    assert [(one.viscous_friction, one.dry_friction) for one in found] == pairs


def test_a_variant_lies_under_the_experiment() -> None:
    variant = {"pellet.friction_frame": "wall", "pacemaker.kind": "periodic"}
    assert RUNS["fig6b"].configuration("tight", variant).pacemaker.kind == "none"
    assert RUNS["fig6a"].configuration("tight", variant).pacemaker.kind == "periodic"
    assert RUNS["fig6a"].configuration("tight", variant).pellet.friction_frame == "wall"


def test_phases_start_the_layers_alone() -> None:
    configuration = RUNS[phase_name(-0.5)].configuration("tight")
    assert (configuration.trigger.rule, configuration.trigger.delay) == ("pacemaker", -0.5)
    assert not configuration.reflex.enabled


def test_a_key_changed_twice_is_refused() -> None:
    with pytest.raises(ValueError, match="keep one"):
        Experiment("x", changes={"wall.length": "12 cm"}, factors={"wall.length": 2.0}).configuration("tight")


@pytest.mark.parametrize("name", SEARCHES)
def test_searches_vary_what_they_say(name: str) -> None:
    search = SEARCHES[name]
    values = search.values
    assert list(values) == sorted(values)
    low, high = (search.run(value).configuration("tight") for value in (values[0], values[-1]))
    assert low.digest() != high.digest()


def test_a_pellet_that_stops_on_its_way_sticks() -> None:
    sticks, arrest = SEARCHES["dry_friction_of_stick_slip"], SEARCHES["dry_friction_of_arrest"]
    assert sticks.holds({"transit_s": 3.0, "stops": 1})
    assert not sticks.holds({"transit_s": 3.0, "stops": 0})
    assert sticks.holds({"transit_s": None, "stops": 0})
    assert not arrest.holds({"transit_s": 3.0, "stops": 1})
    assert arrest.holds({"transit_s": None})


def test_sensitivities_hold_the_normal_friction_and_the_papers_ends() -> None:
    equal, ranges = SENSITIVITIES["equal_percentages"], SENSITIVITIES["paper_ranges"]
    assert (equal.first.values[2], equal.second.values[2]) == (230.0, 20.0)
    viscous, dry = ranges.first.values, ranges.second.values
    assert (viscous[0], viscous[-1], dry[0], dry[-1]) == (90.0, 1200.0, 2.0, 800.0)
