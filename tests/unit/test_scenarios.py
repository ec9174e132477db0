"""Scenarios: all are found, all are valid under every reading, and the layers apply in order."""

from pathlib import Path

import pytest

from peristalsis import scenarios
from peristalsis.errors import ConfigurationError, ScenarioNotFound
from peristalsis.inputs.config import Configuration
from peristalsis.inputs.parameters import PREPARATIONS, READINGS

FOLDER = Path(scenarios.__file__).parent


def test_every_file_is_a_scenario_of_its_own_name() -> None:
    files = {path.stem for path in FOLDER.glob("*.py")} - {"__init__"}
    assert set(scenarios.names()) == files
    assert scenarios.names()[0] == "baseline"
    for name in scenarios.names():
        scenario = scenarios.get(name)
        assert scenario.name == name
        assert scenario.title
        assert scenario.description
        assert scenario.expected


REFUSED = {
    ("fig7c", "stretched"): "cannot hold this pellet",
    ("pacemaker_cell", "edge"): "it follows the pulses of the pacemaker",
}
"""Scenarios that have no meaning under a reading, and what they are refused with."""


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("name", scenarios.names())
def test_every_scenario_is_valid_and_round_trips(name: str, reading: str) -> None:
    if (name, reading) in REFUSED:
        with pytest.raises(ConfigurationError, match=REFUSED[name, reading]):
            scenarios.configuration(name, reading=reading)
        return
    config = scenarios.configuration(name, reading=reading)
    assert (config.scenario, config.reading) == (name, reading)
    assert Configuration.from_toml(config.to_toml()) == config


@pytest.mark.parametrize("reading", READINGS)
def test_a_reading_leaves_what_a_scenario_is_about(reading: str) -> None:
    """Fig. 7 B is a wider tube: a reading's own radius must not put the baseline in its place."""
    assert scenarios.configuration("fig7b", reading=reading).wall.radius == 0.9


NORMS = {"fig3a", "fig4a", "fig6a", "fig6c", "fig7a"} | {
    f"fig5_{channel}_norm" for channel in ("slow_calcium", "fast_calcium", "calcium_potassium")
}
"""Curves of the paper that are its baseline under another name."""


def test_norms_are_the_baseline() -> None:
    for name in NORMS:
        assert scenarios.configuration(name).flat() | {"scenario": "baseline"} == Configuration().flat()


@pytest.mark.parametrize("name", sorted(set(scenarios.names()) - {"baseline", "resting"} - NORMS))
def test_every_change_of_a_scenario_changes_something(name: str) -> None:
    """A change that equals the shipped value would silently stop being one when the default moves.

    A preparation states every number of its gut, also one that is the paper's.
    """
    shipped = Configuration().flat()
    ours = scenarios.configuration(name).flat()
    changed = {key for key, value in ours.items() if value != shipped.get(key)} - {"scenario"}
    scenario = scenarios.get(name)
    stated = set(PREPARATIONS[scenario.preparation].parameters) if scenario.preparation else set()
    assert changed >= set(scenario.changes) - stated - {"pacemaker.period"}
    assert changed


def test_the_baseline_is_the_default() -> None:
    assert scenarios.configuration("baseline") == Configuration() == scenarios.configuration()


def test_segmentation_is_circular_only_and_stands() -> None:
    config = scenarios.configuration("segmentation")
    assert config.longitudinal.active == 0.0
    assert config.circular.active == 1.0
    assert not config.circular.conduction
    assert config.rings.enabled
    assert (config.pacemaker.kind, config.trigger.rule, config.reflex.enabled) == ("none", "none", False)


def test_unknown_names_are_answered_with_the_nearest() -> None:
    with pytest.raises(ScenarioNotFound, match="did you mean pendular"):
        scenarios.get("pendulum")


def test_layers_apply_in_order(tmp_path: Path) -> None:
    file = tmp_path / "run.toml"
    file.write_text(
        'reading = "printed"\n[pellet]\nradius = "0.8 cm"\ndry_friction = "10 mN"\n[pacemaker]\nkind = "pulse"\n'
    )
    from_file = scenarios.configuration("periodic", file=file)
    assert from_file.scenario == "periodic"
    assert from_file.pacemaker.kind == "pulse"  # the file is over the scenario
    assert (from_file.pellet.radius, from_file.wall.c10) == (0.8, 0.00794)  # and over its own reading
    read = scenarios.configuration("periodic", file=file, reading="stretched")
    assert (read.pellet.radius, read.pellet.dry_friction) == (1.5, 10.0)
    changed = scenarios.configuration("periodic", file=file, reading="stretched", changes={"pellet.radius": "1.4 cm"})
    assert changed.pellet.radius == 1.4


def test_a_dumped_configuration_brings_its_own_scenario(tmp_path: Path) -> None:
    file = tmp_path / "run.toml"
    config = scenarios.configuration("pendular", changes={"wall.length": "12 cm"})
    file.write_text(config.to_toml())
    assert scenarios.configuration(file=file) == config
    with pytest.raises(ConfigurationError, match="the file is of scenario 'pendular'"):
        scenarios.configuration("baseline", file=file)


@pytest.mark.parametrize(
    "text", ["scenario = 3", "scenario = ['a']", "scenario = 'nothing'", "reading = 1", "pellet = 3"]
)
def test_bad_files_are_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "run.toml"
    file.write_text(text)
    with pytest.raises(ConfigurationError):
        scenarios.configuration(file=file)


def test_what_a_scenario_set_is_told_from_what_the_user_set() -> None:
    config = scenarios.configuration("pendular", changes={"pellet.dry_friction": "2 mN"})
    tags = {entry.key: entry.tag for entry in config.items(scenarios.unchanged(config))}
    assert tags["circular.active"] == "set by scenario"
    assert tags["pellet.dry_friction"] == "set by user"
    assert tags["pellet.viscous_friction"] == "printed"
