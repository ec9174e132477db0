"""One scorer for any source: a second one is a file of the user's, and the engine knows none by name."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis import plugins
from peristalsis.cli.paper_command import PaperOrder, carry_out_order
from peristalsis.cli.streams import Screen
from peristalsis.errors import ConfigurationError
from peristalsis.inputs.config import Configuration
from peristalsis.many.kept import Store
from peristalsis.many.rows import Row, key_of
from peristalsis.many.sweep import Measured
from peristalsis.scoring import sources
from peristalsis.scoring.outcome import Condition
from peristalsis.scoring.runs import Bench, carry_out
from peristalsis.scoring.source import Source

FILE = Path(__file__).parents[1] / "fixtures" / "two_claims.py"


@pytest.fixture
def source(monkeypatch: pytest.MonkeyPatch) -> Iterator[Source]:
    """The two claims, registered; runs are made up: half the friction is half the time, and the pull is 300 mN."""

    def made(configurations: Mapping[str, Configuration], folder: Any, measure: Any, *_: Any) -> dict[str, Row]:
        assert measure.__name__ == "with_pull"
        return {name: row(one) for name, one in configurations.items()}

    def row(configuration: Configuration) -> Row:
        transit = configuration.pellet.viscous_friction / 100.0
        numbers = {"status": "expelled", "transit_s": transit, "travel_cm": 8.0, "pull_mN": 300.0}
        course = np.linspace(0.0, 8.0, 5)
        return Row(numbers, {"time_step": course, "pellet_position": course, "z": course})

    monkeypatch.setattr("peristalsis.scoring.runs.sweep", made)
    ps.register(FILE)
    yield sources.get("two_claims")
    sources.forget_all()
    plugins.forget_all()


def test_a_second_source_is_scored_and_reported_by_the_same_engine(
    source: Source, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first claim holds, the second does not; tables, figure and page are its own."""
    order = PaperOrder(None, "all", 1, tmp_path, coarse=False, source="two_claims")
    assert carry_out_order(order, Screen(json=True)) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["verdicts"] == {"soft": {"B1": "holds", "B2": "does not hold"}}
    with (tmp_path / "claims.csv").open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    assert head == ["claim", "statement", "place", "use", "soft"]
    assert [(row[0], row[-1]) for row in rows] == [("B1", "holds"), ("B2", "does not hold")]
    with (tmp_path / "sets.csv").open(newline="", encoding="utf-8") as file:
        assert list(csv.reader(file))[1:] == [["soft", "tight", "circular.active", "0.5"]]
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    for words in ("Two claims, scored", "Two claims &amp; no more", "dry: pull_mN 300 mN", "Fig. 1: Tracks", "largest"):
        assert words in page
    assert "The muscle is too strong." in (tmp_path / "explanations.csv").read_text(encoding="utf-8")
    assert not (tmp_path / "misprints.csv").exists()
    assert "Al Qatrawi" not in page.replace("al_qatrawi", "").split("Calibrated numbers")[0]


def test_a_parameter_set_lies_under_the_experiments(source: Source, tmp_path: Path) -> None:
    ((condition, searched),) = source.conditions(["soft"], coarse=True)
    assert (condition.title, searched) == ("soft", True)
    oiled = source.runs["oiled"].configuration(condition.reading, condition.variant)
    assert (oiled.circular.active, oiled.pellet.viscous_friction, oiled.grid.n_z) == (0.5, 115.0, 400)
    found = carry_out(Bench(source, tmp_path), condition, ["dry"], searches=True)
    assert set(found.measured) == {"dry"}


def test_sources_are_found_by_name(source: Source) -> None:
    assert sources.names() == ("bench", "paper", "two_claims")
    assert sources.get("paper").name == "paper"
    with pytest.raises(ConfigurationError, match="did you mean paper"):
        sources.get("papper")
    with pytest.raises(ConfigurationError, match="the name is taken"):
        sources.register(replace(source, name="paper"))
    with pytest.raises(ConfigurationError, match="claim B1 asks for the run 'oiled'"):
        sources.register(replace(source, name="third", runs={"dry": source.runs["dry"]}))


def test_claims_of_every_source_have_their_runs() -> None:
    for name in sources.names():
        one = sources.get(name)
        known = {*one.runs, *one.searches, *one.sensitivities}
        assert {run for claim in one.claims for run in claim.runs()} <= known
        assert all(run in one.runs for picture in one.pictures for run in picture.runs)
        assert len({claim.number for claim in one.claims}) == len(one.claims)


def test_kept_runs_are_keyed_by_the_experiment_alone(tmp_path: Path) -> None:
    """Neither the source nor its parameter set's name is part of a key, so that runs kept by the paper stay usable."""
    configuration = sources.get("paper").runs["fig3a"].configuration("tight")
    condition = Condition("tight", name="whatever")
    assert sources.get("paper").runs["fig3a"].configuration(condition.reading) == configuration
    kept = Measured(Store(tmp_path), lambda *_: ({}, {}))
    assert kept.key(configuration) == key_of(configuration.with_changes({"scenario": "baseline"}))
