"""The bench as a source: preparation, measures on courses with a known answer, its own rule, claims that fail."""

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.inputs.parameters import PARAMETERS, PREPARATIONS
from peristalsis.plots import data
from peristalsis.results.measures import speed_between
from peristalsis.scoring.bench.claims import CLAIMS
from peristalsis.scoring.bench.measure import order_of_events
from peristalsis.scoring.bench.rules import HalvesTogether, half_at
from peristalsis.scoring.bench.source import SOURCE
from peristalsis.scoring.experiment import Experiment
from peristalsis.scoring.outcome import Outcome
from peristalsis.scoring.score import score


@pytest.mark.parametrize("name", PREPARATIONS)
def test_every_number_of_a_preparation_says_where_it_is_from(name: str) -> None:
    for key, about in PREPARATIONS[name].parameters.items():
        assert about.source, key
        assert about.unit == PARAMETERS[key].unit, key
        assert about.tag != "calibrated" or (about.low is not None and about.high is not None), key


@pytest.mark.parametrize("name", ["guinea_pig", "rabbit_progressive_wave"])
def test_a_scenario_shows_tag_and_source_of_its_preparation(name: str) -> None:
    configuration = ps.configuration(name)
    given = ps.scenarios.given_by(name)
    entries = {entry.key: entry for entry in configuration.items(configuration, given)}
    for key, about in given.items():
        assert (entries[key].tag, entries[key].source) == (about.tag, about.source)
    changed = configuration.with_changes({"wall.radius": "0.5 cm"})
    radius = next(entry for entry in changed.items(configuration, given) if entry.key == "wall.radius")
    assert radius.tag == "set by user"


def test_the_parameter_set_is_the_scenario() -> None:
    """What is scored is what `peristalsis run guinea_pig` runs."""
    (one,) = SOURCE.sets
    scored = Experiment("control").configuration(one.reading, one.changes)
    assert scored.with_changes({"scenario": "guinea_pig"}).flat() == ps.configuration("guinea_pig").flat()


@pytest.mark.parametrize("name", SOURCE.variants)
def test_every_variant_is_accepted(name: str) -> None:
    condition, _ = SOURCE.conditions(["guinea_pig"], [name])[-1]
    scored = Experiment("control").configuration(condition.reading, condition.variant)
    assert scored != Experiment("control").configuration("tight", SOURCE.sets[0].changes)


def test_speed_between_two_places() -> None:
    time = np.linspace(0.0, 40.0, 401)
    assert speed_between(time, 0.2 * time, 2.5, 5.5) == pytest.approx(0.2, rel=1e-9)
    assert speed_between(time, np.minimum(0.2 * time, 4.5), 2.5, 5.5) == pytest.approx(2.0 / 27.5, rel=1e-6)
    assert speed_between(time, 0.01 * time, 2.5, 5.5) == pytest.approx(0.01)
    assert speed_between(time, -0.01 * time, 2.5, 5.5) == 0.0


@pytest.mark.parametrize(("relaxes", "dilates"), [(2, 3), (8, 3), (2, 8)])
def test_order_of_events(relaxes: int, dilates: int) -> None:
    """Muscle contracts in frame 5: what happens in frame 2 or 3 comes first, what happens in frame 8 does not."""
    z, frames = np.linspace(0.0, 8.0, 81), 10
    since = np.arange(frames)[:, None, None]
    arrays = {
        "z": z,
        "z_cell": 0.5 * (z[1:] + z[:-1]),
        "active_tension_circumferential": np.where(since >= 5, 10.0, 0.0) * np.ones((1, 81, 1)),
        "radius": np.where(since >= dilates, 0.4, 0.35) * np.ones((1, 81, 1)),
        "potential_circular": np.where(since >= relaxes, -64.0, -62.6) * np.ones((1, 80, 1)),
    }
    assert order_of_events(arrays, (2.5, 5.5)) == (float(relaxes < 5), float(dilates < 5))
    quiet = arrays | {"active_tension_circumferential": np.zeros((frames, 81, 1))}
    assert order_of_events(quiet, (2.5, 5.5)) == (None, None)


def test_runs_of_a_claim_are_those_that_its_rules_read() -> None:
    needed = SOURCE.runs_of((2,))
    assert set(needed) == {"control", *(f"diameter_{ratio}" for ratio in ("1", "1.06", "1.1", "1.2", "1.26"))}
    assert SOURCE.runs_of(()) == ()


def test_tables_have_a_row_a_choice_and_say_what_broke_off() -> None:
    measured = {"control": {"status": "expelled", "middle_speed_mm_s": 2.3116}}
    measured |= {"diameter_1.2": {"status": "diverged", "middle_speed_mm_s": 0.5}}
    condition, _ = SOURCE.conditions(["guinea_pig"], ["taut"])[-1]
    table = SOURCE.tables[0]([Outcome(condition, {}, {}, measured)])
    ((title, *cells),) = table.rows
    assert title.startswith("guinea_pig, ends held")
    assert dict(zip(table.columns[1:], cells, strict=True)) == {
        **dict.fromkeys(("1", "1.06", "1.1", "1.26"), "–"),
        "1.14": "2.31",
        "1.2": "0.5 (diverged)",
    }


@pytest.mark.parametrize(("largest", "unit"), [(40.0, "mN"), (-499.0, "mN"), (1400.0, "N")])
def test_small_forces_are_shown_in_millinewtons(largest: float, unit: str, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = {"axial_force": np.array([0.0, largest]), "dry_force": np.array([1.0, np.nan])}
    monkeypatch.setattr(data, "values", lambda _, name: shown[name])
    assert data.force_unit(None, *shown) == unit  # type: ignore[arg-type]


def test_half_of_a_curve() -> None:
    """1/(1 + c) is a half at 1, wherever it is sampled; a value that keeps more than half has none."""
    fine = np.geomspace(0.01, 100.0, 81)
    assert half_at(fine, 1.0 / (1.0 + fine), 1.0) == pytest.approx(1.0, rel=1e-2)
    assert half_at((0.1, 1.0), (0.9, 0.8), 1.0) is None
    assert half_at((0.1, 1.0), (0.2, 0.1), 1.0) == 0.1


def test_halves_together() -> None:
    concentrations = (0.1, 1.0, 10.0)

    def found(shift: float) -> bool | None:
        values = {f"free_{c}": {"status": "expelled", "v": 1.0 / (1.0 + c)} for c in concentrations}
        values |= {f"held_{c}": {"status": "arrested", "f": 1.0 / (1.0 + c / shift)} for c in concentrations}
        values |= {"free": {"status": "expelled", "v": 1.0}, "held": {"status": "arrested", "f": 1.0}}
        free, held = (tuple(f"{name}_{c}" for c in concentrations) for name in ("free", "held"))
        return HalvesTogether(concentrations, ("free", "v", free), ("held", "f", held), 0.3, 3.0).judge(values).holds

    assert found(1.0) is True
    assert found(0.1) is False
    missing = HalvesTogether(concentrations, ("free", "v", ("x", "y", "z")), ("held", "f", ("a", "b", "c")), 0.3, 3.0)
    assert missing.judge({}).missing


def test_every_claim_can_fail_and_hold() -> None:
    """Made-up numbers that are as measured, and the same with one of them wrong."""
    good = {run: {"status": "expelled"} for claim in CLAIMS for run in claim.runs()}
    speeds = {"control": 2.0, "diameter_1": 0.2, "diameter_1.06": 1.0, "diameter_1.1": 1.6, "diameter_1.2": 2.2}
    speeds |= {"diameter_1.26": 1.9, "load_10": 1.8, "load_20": 1.5, "load_40": 1.0, "load_60": 0.4, "load_80": 0.05}
    speeds |= {"load_100": 0.0, "hexamethonium": 1.8, "tetrodotoxin": 0.0, "no_longitudinal_force": 1.5, "held": 0.0}
    forces = {"held": 60.0, "held_hexamethonium": 40.0}
    for run, numbers in good.items():
        share = 1.0 / (1.0 + float(run.rpartition("_")[2])) if "block" in run else 1.0
        numbers["middle_speed_mm_s"] = share * speeds.get(run, 2.0)
        numbers["isometric_force_mN"] = share * forces.get(run, 60.0)
        numbers |= {"relaxed_first": 1.0, "dilated_first": 1.0, "contact_kPa": 2.0, "peak_force_mN": 40.0}
    wrong = {
        1: ("control", "middle_speed_mm_s", 4.2),
        2: ("diameter_1.1", "middle_speed_mm_s", 2.3),
        3: ("load_100", "middle_speed_mm_s", 0.5),
        4: ("held_hexamethonium", "isometric_force_mN", 58.0),
        5: ("tetrodotoxin", "middle_speed_mm_s", 0.5),
        6: ("no_longitudinal_force", "middle_speed_mm_s", 0.5),
        7: ("load_20", "dilated_first", 0.5),
        8: ("block_30", "status", "failed"),
        10: ("control", "peak_force_mN", 1400.0),
    }
    for claim in CLAIMS:
        assert score(claim, good).verdict == "holds", claim.number
        run, metric, value = wrong[claim.number]
        worse = {**good, run: {**good[run], metric: value}}
        assert score(claim, worse).verdict != "holds", claim.number
