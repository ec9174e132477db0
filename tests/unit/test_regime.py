"""The search for a reading: its space, the edge that it finds, and the same table each time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from peristalsis import scenarios
from peristalsis.cli.paper_command import PaperOrder, paper, search_order
from peristalsis.cli.streams import Screen
from peristalsis.errors import ConfigurationError, WriteError
from peristalsis.inputs.config import Configuration
from peristalsis.inputs.parameters import shipped
from peristalsis.many.rows import Row
from peristalsis.scoring import runs, sources
from peristalsis.scoring.regime import ALWAYS, NEVER, OFF, SCORED, SCREENED_OUT, Search, merit, ranked, table
from peristalsis.scoring.report import write_table
from peristalsis.scoring.runs import Bench
from peristalsis.scoring.source import Table

SOURCE = sources.get("paper")
assert SOURCE.space is not None
SPACE = SOURCE.space
EDGE = 0.55
"""Force at which the made-up pellet stops riding, times its radius over 0.9 cm."""


def made_up(configuration: Configuration) -> dict[str, Any]:
    """A run without a model: rides above an edge that lies higher for a larger pellet, and is caught again below it."""
    edge = EDGE * configuration.pellet.radius / 0.9
    rides = configuration.circular.active >= edge
    transit = (2.4 if rides else 3.6) * (configuration.pellet.viscous_friction / 230.0) ** 0.1
    return {
        "status": "expelled",
        "error": None,
        "transit_s": transit,
        "travel_cm": 8.0,
        "mean_velocity_cm_s": 8.0 / transit,
        "wave_speed_cm_s": {"longitudinal": 3.5, "circular": 3.5},
        "stops": 0,
        "irregularity": 0.2,
        "reversals": 0,
    }


@pytest.fixture
def search(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Search:
    def sweep(configurations: Mapping[str, Configuration], *_: Any) -> dict[str, Row]:
        return {name: Row(made_up(one)) for name, one in configurations.items()}

    monkeypatch.setattr(runs, "sweep", sweep)
    edge = replace(SPACE.edge, halvings=5)
    asked = replace(SPACE.objective, claims=(1, 4, 22), screening=("baseline", "eta_x2", "pellet_x1.05"))
    space = replace(SPACE, samples=4, screened=2, parents=1, children=2, rounds=1, edge=edge, objective=asked)
    return Search(Bench(SOURCE, tmp_path), space)


def test_no_printed_number_moves() -> None:
    keys = {key for one in SPACE.free for key in one.keys} | set(SPACE.edge.keys)
    tags = {key: shipped("tight")[key].tag for key in keys}
    assert "printed" not in tags.values(), tags


def test_every_claim_is_asked_or_held_out_and_none_is_both() -> None:
    asked, out = set(SPACE.objective.claims), set(SPACE.objective.held_out)
    assert asked | out == {claim.number for claim in SOURCE.claims}
    assert not asked & out
    assert set(SPACE.objective.screening) <= set(SOURCE.runs)


def test_points_lie_in_their_ranges_and_come_again_from_the_seed() -> None:
    drawn = SPACE.drawn()
    assert len(drawn) == SPACE.samples
    assert drawn == SPACE.drawn() != replace(SPACE, seed=SPACE.seed + 1).drawn()
    for values in (*drawn, *SPACE.around(drawn[0], 0)):
        for one in SPACE.free:
            assert one.low <= values[one.name] <= one.high
        for choice in SPACE.choices:
            assert values[choice.name] in choice.values
    assert all(values["gate"] == drawn[0]["gate"] for values in SPACE.around(drawn[0], 0))


def test_a_point_is_a_configuration() -> None:
    values = {**SPACE.drawn()[0], "layer_ratio": 1.25, "conductivity": 1.07, "pellet_radius": 0.85}
    base = scenarios.configuration(reading="tight").flat()
    found = scenarios.configuration(reading="tight", changes=SPACE.changes(values, 0.4, base))
    assert (found.circular.active, found.longitudinal.active) == (0.4, 0.5)
    assert found.pellet.radius == 0.85
    assert found.circular.conductivity_scale == pytest.approx(1.07 * base["circular.conductivity_scale"], rel=1e-12)


def test_the_edge_is_bracketed_and_the_force_lies_beyond_it(search: Search) -> None:
    for one in search.carry_out():
        edge = EDGE * float(one.values["pellet_radius"]) / 0.9
        assert one.low < edge <= one.high
        assert one.high / one.low <= (1.0 / 0.25) ** (0.5**search.space.edge.halvings) * 1.0001
        assert one.force == pytest.approx(one.high * (1.0 + float(one.values["beyond"])), rel=1e-5)


def test_only_the_best_are_run_on_everything_and_then_moved(search: Search) -> None:
    found = search.carry_out()
    assert [one.status for one in found].count(SCORED) == 4  # two of the four, and both that were moved
    assert {one.parent for one in found if one.parent} == {ranked(SOURCE.claims, search.space, found[:4])[0].name}
    assert {one.status for one in found[:4]} == {SCORED, SCREENED_OUT}


def test_the_same_search_gives_the_same_table(search: Search) -> None:
    first, second = (table(SOURCE.claims, search.space, search.carry_out()).csv() for _ in range(2))
    assert first == second
    assert len(first.splitlines()) == 1 + 4 + 2


def test_more_rounds_go_on_from_the_best_of_all_and_repeat_what_was_there(search: Search) -> None:
    once = search.carry_out()
    more = replace(search, space=replace(search.space, rounds=3)).carry_out()
    assert more[: len(once)] == once
    assert len({one.name for one in more}) == len(more) == len(once) + 2 * 2
    for place, count in ((len(once), 2), (len(once) + 2, 2)):
        best = ranked(SOURCE.claims, search.space, more[:place])[0].name
        assert {one.parent for one in more[place : place + count]} == {best}


def test_later_rounds_keep_nearer_to_their_parents() -> None:
    parent = SPACE.drawn()[0]
    space = replace(SPACE, children=64, narrowing=0.5)

    def spread(round_: int) -> float:
        beyond = space.free[0]
        return float(np.std([beyond.share(float(one[beyond.name])) for one in space.around(parent, 0, round_)]))

    assert spread(2) == pytest.approx(space.spread / 4.0, rel=0.3)
    assert space.around(parent, 0, 1) != space.around(parent, 0, 2)


@pytest.mark.parametrize(("edge", "status"), [(2.0, NEVER), (0.1, ALWAYS)])
def test_a_point_without_an_edge_in_range_is_a_row_that_says_why(
    search: Search, monkeypatch: pytest.MonkeyPatch, edge: float, status: str
) -> None:
    monkeypatch.setitem(globals(), "EDGE", edge)
    assert {one.status for one in search.carry_out()} == {status}


def test_a_norm_that_takes_another_time_is_dropped_before_the_screening(search: Search) -> None:
    asked = replace(search.space.objective, transit=(1.0, 2.0))
    slower = replace(search, space=replace(search.space, objective=asked))
    found = slower.carry_out()
    assert {one.status for one in found} == {OFF}
    assert all(set(one.measured) == {"baseline"} for one in found)


def test_merit_counts_claims_then_parts_then_the_transit(search: Search) -> None:
    best = ranked(SOURCE.claims, search.space, search.carry_out())[0]
    holds, parts, distance = merit(SOURCE.claims, search.space, best)
    assert parts >= holds > 0
    assert distance == 0.0
    late = replace(best, measured={**best.measured, "baseline": {**best.measured["baseline"], "transit_s": 2.5}})
    assert merit(SOURCE.claims, search.space, late)[2] == pytest.approx(-0.1)


def test_a_table_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    """Two hours of runs do not end in a traceback: the runs are kept, and the folder can be another."""
    blocked = tmp_path / "file"
    blocked.write_text("here already")
    found = Table("candidates", "Points", "", ("point",), (("s000",),))
    with pytest.raises(WriteError, match="could not write the report into"):
        write_table(found, blocked)
    assert write_table(found, tmp_path / "new").read_text() == "point\ns000\n"


def test_claims_that_were_held_out_are_measured_once_the_search_is_over(search: Search) -> None:
    found = search.carry_out()
    known = search.with_held_out(found)
    assert [one.name for one in known] == [one.name for one in found if one.status == SCORED]
    needed = {run for claim in SOURCE.claims if claim.number in SPACE.objective.held_out for run in claim.runs()}
    best = {one.name for one in ranked(SOURCE.claims, search.space, found)[: search.space.screened]}
    assert best < {one.name for one in known}
    assert not any(needed <= set(one.measured) for one in found)
    for one in known:
        assert needed - set(one.measured) == (set() if one.name in best else set(SOURCE.sensitivities))
    assert [one.status for one in found] == [one.status for one in search.carry_out()]


@pytest.mark.parametrize("held_out", [False, True])
def test_the_command_writes_points_front_and_near_misses(
    search: Search, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, held_out: bool
) -> None:
    monkeypatch.setattr(sources, "get", lambda name: replace(SOURCE, space=search.space, sets=SOURCE.sets[-1:]))
    order = PaperOrder(None, "tight", 1, tmp_path / "found", coarse=False, held_out=held_out)
    assert search_order(order, Screen(json=False)) == 0
    lines = {file.stem: file.read_text().splitlines() for file in (tmp_path / "found").glob("*.csv")}
    assert set(lines) == {"candidates", "front", "exclusive", "nearest"}
    numbers = {int(line.split(",")[0]) for line in lines["nearest"][1:]}
    assert numbers == ({claim.number for claim in SOURCE.claims} if held_out else set(search.space.objective.claims))
    assert ("edge" in "".join(lines["front"])) == held_out


def test_held_out_claims_belong_to_a_search() -> None:
    with pytest.raises(ConfigurationError, match="add --search"):
        paper(held_out=True)
