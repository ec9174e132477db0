"""Passes one after the other: what the first is, what the next begins from, what is refused."""

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.cli import main
from peristalsis.control.pulses import Pulse
from peristalsis.control.reflex import ReflexState
from peristalsis.errors import ConfigurationError
from peristalsis.many.passes import Passes
from peristalsis.model.insertion import emptied, inserted, set_back

SMALL: dict[str, Any] = {"grid.n_z": 120, "grid.n_z_wall": 90, "step.wall": "100 ms", "step.conduction": "20 ms"}
TAUT = {**SMALL, "wall.slack_length": "0 cm"}


@pytest.fixture(scope="module")
def series() -> Passes:
    return ps.passes("guinea_pig", SMALL, count=2, rest="2 s")


def test_the_first_pass_is_the_run(series: Passes) -> None:
    plain = ps.Simulation(ps.configuration("guinea_pig", changes=SMALL)).run()
    for name, values in plain.arrays.items():
        if not name.startswith("event"):
            first = series.passes[0].result.arrays[name]
            assert np.array_equal(values, first, equal_nan=values.dtype.kind == "f"), name


def test_the_next_enters_after_the_rest_on_tissue_that_is_still_contracted(series: Passes) -> None:
    first, second = series.passes
    assert first.result.status == "expelled"
    assert second.begins == pytest.approx(first.result.arrays["time_step"][-1] + 2.0, abs=1e-9)
    start = second.result.configuration.pellet.start_gap + second.result.configuration.pellet.radius
    assert second.result.arrays["pellet_position"][0] == pytest.approx(start)
    assert first.drive == 0.0
    assert second.drive > 1.0
    assert second.speed < 0.9 * first.speed
    before, after = (one.result.arrays["potential_circular"] for one in (first, second))
    assert after[0].max() > before[0].max() + 10.0
    assert any("pass 2 of a series" in remark for remark in second.result.remarks)


def test_cells_and_nerves_stand_still_while_a_pellet_is_put_in() -> None:
    """After a rest they are as they were as the pellet enters, and the wall lies around it as in equilibrium."""
    with_pellet = ps.Simulation(ps.configuration("guinea_pig", changes=TAUT))
    alone = ps.Simulation(ps.configuration("guinea_pig", changes={**TAUT, "pellet.enabled": False}))
    found = inserted(with_pellet.model, emptied(alone.state))
    assert found.state.circular.potential is alone.state.circular.potential
    assert found.state.pellet.position == with_pellet.state.pellet.position
    apart = found.state.wall.position[:, 0, 0] - with_pellet.state.wall.position[:, 0, 0]
    assert np.abs(apart).max() < 5e-3
    volumes = [one.lumen.reference_volume for one in (found.model, with_pellet.model)]
    assert volumes[0] == pytest.approx(volumes[1], rel=2e-3)


def test_the_clock_begins_anew_and_what_was_before_is_before_0() -> None:
    simulation = ps.Simulation(ps.configuration("guinea_pig", changes=SMALL))
    simulation.advance("4 s")
    state = simulation.state
    pulse = Pulse(3.5, 4.5, 0.0, 1.0, 2.0)
    reflex = ReflexState(state.reflex.fired, (pulse,), (), state.reflex.receptors)
    back = set_back(state.__class__(**{**vars(state), "reflex": reflex}), 4.0)
    assert back.step == 0
    assert state.reflex.receptors is not None
    assert back.reflex.receptors is not None
    discharged = np.isfinite(state.reflex.receptors.time)
    assert discharged.any()
    late = back.reflex.receptors.time[discharged] - state.reflex.receptors.time[discharged]
    assert np.allclose(late, -4.0)
    assert back.reflex.excitation == (pulse._replace(begin=-0.5, end=0.5),)
    assert back.reflex.fired == state.reflex.fired - 4.0 < 0.0
    assert back.circular.potential is state.circular.potential


def test_rows_are_written(series: Passes) -> None:
    rows = list(csv.DictReader(series.csv().splitlines()))
    assert [row["pass"] for row in rows] == ["1", "2"]
    assert float(rows[1]["transit_s"]) == series.passes[1].result.summary["transit_s"]
    assert math.isclose(float(rows[1]["begins_s"]), series.passes[1].begins, abs_tol=1e-8)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pellet.enabled": False}, "nothing to pass"),
        ({"pellet.held": True, "pellet.start_gap": "3 cm"}, "held pellet does not pass"),
    ],
)
def test_what_has_no_passes_is_refused(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        ps.passes("guinea_pig", {**SMALL, **changes})


@pytest.mark.parametrize(
    ("count", "rest", "words"), [(0, "1 s", "count = 0"), (2, "-1 s", "rest = -1 s"), (2, "1 cm", "rest")]
)
def test_bad_numbers_are_refused(count: int, rest: str, words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        ps.passes("guinea_pig", SMALL, count=count, rest=rest)


def test_the_command_writes_table_and_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["passes", "guinea_pig", "--count", "2", "--rest", "0 s", "--out", "o", "--json"]
    for key, value in SMALL.items():
        words += ["--set", f"{key}={value}"]
    assert main(words) == 0
    answer = json.loads(capsys.readouterr().out)
    assert [row["pass"] for row in answer["passes"]] == [1, 2]
    assert (tmp_path / "o" / "passes.csv").read_text(encoding="utf-8").count("\n") == 3
    assert (tmp_path / "o" / "passes.png").stat().st_size > 10_000


def test_passes_that_are_over_are_kept_when_the_next_is_interrupted(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str], series: Passes
) -> None:
    def stopped(*_: Any, progress: Any, **__: Any) -> Passes:
        progress(series.passes[0])
        raise KeyboardInterrupt

    monkeypatch.setattr("peristalsis.many.passes.passes", stopped)
    monkeypatch.chdir(tmp_path)
    assert main(["passes", "guinea_pig", "--out", "o"]) != 0
    assert "passes that are over stand in o/passes.csv" in capsys.readouterr().err
    assert (tmp_path / "o/passes.csv").read_text().splitlines() == series.csv().splitlines()[:2]
