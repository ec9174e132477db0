"""The robustness bench itself: its plan is the same every time, and its rules see what they are meant to see."""

from __future__ import annotations

import os
import signal
import sys
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import pytest

from peristalsis import configuration
from peristalsis.inputs.parameters import shipped

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from robustness import halving, log, plan, pool, report, rules
from robustness.__main__ import main
from robustness.execution import carry_out, second_opinion

TINY = {"grid.n_z": "50", "grid.n_z_wall": "60", "run.duration": "10 ms"}


def case(index: int = 0, **changes: str) -> plan.Case:
    """A case of a few steps; keys with a dot are written with two underscores."""
    return plan.Case(
        index, "wall", "baseline", "tight", {key.replace("__", "."): text for key, text in changes.items()}, TINY
    )


def finished(**more: Any) -> dict[str, Any]:
    """A row in order."""
    summary = {"wave_speed_cm_s": {"longitudinal": 4.2, "circular": None}, "power_residual": 1e-6, "transit_s": 2.0}
    row: dict[str, Any] = {
        "index": 0, "group": "wall", "variant": "", "key": "k", "scenario": "baseline", "reading": "tight",
        "changes": {}, "outcome": "finished", "stage": "run", "words": "", "status": "in_transit", "summary": summary,
        "remarks": [], "events": {}, "event_words": [], "simulated_s": 4.0, "not_finite": [], "length_cm": 10.0,
        "bulge_cm": 0.1, "bulge_end": "oral", "oral_pole_cm": 0.3, "oral_centre_cm": 1.2, "anal_pole_cm": 9.0,
        "last_cm": 8.0, "cpu_per_s": 1.0,
    }  # fmt: skip
    return row | more


def refused(words: str, **more: Any) -> dict[str, Any]:
    row = {key: value for key, value in finished().items() if key not in ("summary", "status")}
    return (
        row | {"outcome": "refused", "stage": "start", "words": words, "other_ways": {"grids x 0.5": "refused"}} | more
    )


# --- plan -------------------------------------------------------------------------------------------


def test_a_case_depends_on_its_number_alone() -> None:
    """The first cases are the same however many follow, and another seed gives others."""
    many = plan.cases(120)
    assert plan.cases(40) == many[:40]
    assert [one.index for one in many] == list(range(120))
    assert plan.cases(120, only=("wall",)) == [one for one in many if one.group == "wall"]
    assert plan.cases(40, seed=1)[0].key() != many[0].key()
    assert len({one.key() for one in many}) == len(many)


def test_the_plan_is_what_it_was() -> None:
    """A changed range or order makes another plan: the last table is then of other cases, and is made anew."""
    first = plan.cases(1)[0]
    assert first.group == "pellet"
    assert set(first.changes) == set(plan.ranges()["groups"]["pellet"]["vary"])


def test_every_group_has_its_turn() -> None:
    """In the everyday plan each group of full share comes at least twice, and every group is in the large one."""
    quick = [one.group for one in plan.cases(plan.QUICK_COUNT, quick=True)]
    whole = [name for name, table in plan.ranges()["groups"].items() if table.get("share", 1.0) == 1.0]
    assert all(quick.count(name) >= 2 for name in whole)
    assert {one.group for one in plan.cases()} == set(plan.groups())


def test_values_stay_within_their_ranges() -> None:
    """Absolute, relative and whole numbers and choices of a hundred cases."""
    for one in plan.cases(100):
        vary = plan.ranges()["groups"][one.group].get("vary", {})
        for key, about in vary.items():
            text = one.changes[key]
            if "choices" in about:
                assert text in about["choices"]
                continue
            low, high = about.get("low"), about.get("high")
            if "times" in about:
                base = float(shipped(one.reading)[key].value)  # type: ignore[arg-type]
                low, high = (base * factor for factor in about["times"])
            assert low * (1 - 1e-4) - 1e-12 <= float(text.split()[0]) <= high * (1 + 1e-4)


def test_every_range_has_its_reason() -> None:
    for table in plan.ranges()["groups"].values():
        assert table["what"]
        assert all(about["why"] for about in table.get("vary", {}).values())


def test_keys_of_the_ranges_are_parameters() -> None:
    """Every group's first cases are read, or refused for what they ask (never for a name or a unit)."""
    for name in plan.groups():
        one = next(one for one in plan.cases(60) if one.group == name)
        configuration(one.scenario, reading=one.reading, changes=one.all_changes())


# --- rules ------------------------------------------------------------------------------------------


def test_a_good_row_has_no_complaint() -> None:
    assert rules.complaints(finished()) == []
    assert rules.kind_of(finished()) == "finished"


@pytest.mark.parametrize(
    ("speed", "words"),
    [(-1.15e19, "insane"), (-0.5, "insane"), (20.5, "insane"), (0.0, "insane"), (19.9, ""), (None, "")],
)
def test_wave_speeds_that_cannot_be(speed: float | None, words: str) -> None:
    summary = {**finished()["summary"], "wave_speed_cm_s": {"longitudinal": speed, "circular": 4.0}}
    found = rules.complaints(finished(summary=summary))
    assert bool(found) == bool(words)
    assert all(text.startswith(words) for text in found)


def test_a_retrograde_wave_may_have_a_negative_speed() -> None:
    summary = {**finished()["summary"], "wave_speed_cm_s": {"longitudinal": -4.0}}
    assert rules.complaints(finished(summary=summary))
    assert rules.complaints(finished(summary={**summary, "waves": {"direction": "retrograde"}})) == []
    assert rules.complaints(finished(summary={**summary, "waves_retrograde": {"longitudinal": 1}})) == []
    assert rules.complaints(finished(summary={**summary, "waves_retrograde": {"longitudinal": 0}}))
    beside = {**finished()["summary"], "wave_speed_cells": {"longitudinal": 500}, "wave_speed_residual_s": 0.0}
    assert rules.complaints(finished(summary=beside)) == []


def test_numbers_beyond_measure_are_seen_wherever_they_stand() -> None:
    summary = {**finished()["summary"], "waves": [{"speed": float("nan")}, {"speed": 2e6}]}
    assert len(rules.complaints(finished(summary=summary))) == 2
    assert rules.complaints(finished(not_finite=["radius"])) == ["not finite: radius"]


def test_a_force_beyond_measure_must_be_named_in_a_remark() -> None:
    summary = {**finished()["summary"], "max_normal_force_mN": 5e6}
    assert rules.complaints(finished(summary=summary)) == ["insane: max_normal_force_mN = 5e+06"]
    said = ["max_normal_force_mN = 5e+06: beyond what any tissue bears; use a smaller pellet.radius"]
    assert rules.complaints(finished(summary=summary, remarks=said)) == []


def test_energy_needs_a_remark() -> None:
    summary = {**finished()["summary"], "power_residual": 2e-3}
    assert rules.complaints(finished(summary=summary))
    said = ["the balance of work is off by 2e-3: lower step.wall"]
    assert rules.complaints(finished(summary=summary, remarks=said)) == []
    summary = {**finished()["summary"], "momentum_residual": 2e-3}
    assert rules.complaints(finished(summary=summary)) == ["momentum 0.002 without a remark"]


def test_exits_at_the_clamps_must_be_told() -> None:
    """A pole beyond either end in a run that says it goes on; an event or a status of its own ends the silence."""
    out = {"oral_pole_cm": -0.5, "oral_centre_cm": 0.4}
    assert "pole" in rules.complaints(finished(**out))[0]
    assert "centre" in rules.complaints(finished(**(out | {"oral_centre_cm": -0.1})))[0]
    assert rules.complaints(finished(**out, events={"oral_end": 1})) == []
    assert rules.complaints(finished(**out, status="expelled_orally")) == []
    assert rules.complaints(finished(anal_pole_cm=10.2, status="arrested"))
    assert rules.complaints(finished(anal_pole_cm=10.2, status="expelled")) == []


def test_bulges_must_be_told() -> None:
    assert rules.complaints(finished(bulge_cm=1.5))
    assert rules.complaints(finished(bulge_cm=1.5, remarks=["the tube bulges over its oral ring"])) == []


GOOD_SENTENCE = (
    "the tube cannot hold this pellet: no equilibrium beyond a radius of 1.2 cm on the way to pellet.radius = 1.5 cm; "
    "use a smaller pellet or a wider tube"
)


@pytest.mark.parametrize(
    ("words", "lacks"),
    [
        (GOOD_SENTENCE, []),
        ("step.wall = 2 ms is too long. Lower step.wall, or raise grid.n_z_wall", []),
        ("something went wrong; lower the pressure", ["names no parameter"]),
        ("lumen.pressure = 3 kPa cannot be", ["names no remedy"]),
        ("unforeseen ValueError at lumen.pressure; please report it", ["names no remedy", "is no sentence for a user"]),
        ("no equilibrium beyond -inf kPa on the way to lumen.pressure; lower it", ["holds a number that is none"]),
    ],
)
def test_form_of_refusals(words: str, lacks: list[str]) -> None:
    assert rules.form_of_sentence(words) == lacks


def test_classes_of_refusals() -> None:
    """Rightly if no other way gets through and the sentence is one; wrongly if any does."""
    assert rules.kind_of(refused(GOOD_SENTENCE)) == "refused_rightly"
    assert rules.kind_of(refused("no")) == "badly_said"
    assert rules.kind_of(refused(GOOD_SENTENCE, other_ways={"grids x 2": "finished"})) == "refused_wrongly"
    broken = {"outcome": "diverged", "stage": "run"}
    assert rules.kind_of(refused(GOOD_SENTENCE, **broken)) == "ended_rightly"
    assert rules.kind_of(refused(GOOD_SENTENCE, **broken, other_ways={"steps x 0.5": "finished"})) == "broken_off"
    vain = refused("potential left its range; lower step.conduction", **broken, other_ways={"steps x 0.5": "diverged"})
    assert rules.complaints(vain) == ["badly_said", "advises step.conduction, tried in vain"]
    assert rules.complaints(vain | {"words": "left its range; lower step.conduction or trigger.intensity"}) == []
    assert rules.complaints(refused("", outcome="traceback")) == ["traceback"]
    assert rules.complaints(refused("", outcome="too_slow")) == ["too_slow"]


# --- carrying out -----------------------------------------------------------------------------------


def test_rows_of_runs() -> None:
    """A run of a few steps, one that the configuration refuses, and one that uses up its time."""
    row = carry_out(case())
    assert (row["outcome"], row["status"], row["stage"]) == ("finished", "in_transit", "run")
    assert rules.complaints(row) == []
    assert row["simulated_s"] == pytest.approx(0.01)
    assert row["oral_pole_cm"] == pytest.approx(0.3)
    assert log.flat(row)["class"] == "finished"
    bad = carry_out(case(pellet__radius="9 cm"))
    assert (bad["outcome"], bad["stage"]) == ("refused", "configuration")
    assert second_opinion(case(pellet__radius="9 cm"), bad, 10.0) == {}
    assert carry_out(case(), limit=-1.0)["outcome"] == "too_slow"


def test_what_is_unforeseen_is_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robustness.execution.Simulation", lambda *_, **__: 1 / 0)
    row = carry_out(case())
    assert row["outcome"] == "traceback"
    assert "ZeroDivisionError" in row["words"]
    assert rules.complaints(row) == ["traceback"]


def test_another_way_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A start that is refused on one grid is asked for on others until one gets through."""
    asked = []

    def run(one: plan.Case, limit: float, tell: object) -> dict[str, Any]:
        asked.append((one.variant, one.all_changes()["grid.n_z"], one.all_changes()["run.duration"]))
        return {"outcome": "finished" if one.variant == "tolerance x 100" else "refused"}

    monkeypatch.setattr("robustness.execution.carry_out", run)
    found = second_opinion(case(), {"outcome": "refused", "stage": "start"}, 10.0)
    assert found == {"grids x 0.5": "refused", "tolerance x 100": "finished"}
    assert asked == [("grids x 0.5", "25", "5 ms"), ("tolerance x 100", "50", "5 ms")]


def serve(pipe: Connection, limit: float, opinions: bool) -> None:
    """In place of runs: the second case kills its process, the fourth says nothing any more."""
    pipe.send(("ready", None))
    while True:
        try:
            one = pipe.recv()
        except EOFError:
            return
        pipe.send(("at", 0.5))
        if one.index == 1:
            os.kill(os.getpid(), signal.SIGKILL)
        if one.index == 3:
            signal.pause()
        pipe.send(("row", {"index": one.index, "outcome": "finished"}))
        pipe.send(("done", {}))


def test_processes_that_die_or_hang_are_rows() -> None:
    """The other cases are not touched."""
    found = {row["index"]: row for row in pool.rows([case(k) for k in range(4)], 1, 0.25, serve=serve)}
    assert [found[k]["outcome"] for k in range(4)] == ["finished", "traceback", "finished", "too_slow"]
    assert "exit code -9" in found[1]["words"]
    assert found[3]["simulated_s"] == 0.5


# --- log, table, page -------------------------------------------------------------------------------


def test_rows_survive_a_bench_that_is_stopped(tmp_path: Path) -> None:
    """A line cut off in the middle is one missing row; rows of other code are not taken."""
    file = tmp_path / "rows.jsonl"
    log.append(finished(key="a"), "one", file)
    with file.open("a") as half:
        half.write('{"key": "b", "outc')
    log.append(finished(key="c"), "one", file)
    log.append(finished(key="d"), "two", file)
    assert set(log.kept("one", file)) == {"a", "c"}
    assert set(log.kept(None, file)) == {"a", "c", "d"}


def test_changes_since_the_last_table(tmp_path: Path) -> None:
    """Equal rows and last bits are no change; another class, measure or none is."""
    file = tmp_path / "last.csv"
    rows = [finished(index=k, key=str(k)) for k in range(4)]
    log.write_last(rows, file)
    last = log.read_last(file)
    assert log.changes(rows, last) == []
    rows[1] = rows[1] | {"bulge_cm": 0.2}
    rows[2] = rows[2] | {"summary": {**rows[2]["summary"], "transit_s": 2.0 * (1 + 1e-9)}}
    rows[3] = rows[3] | {"summary": {**rows[3]["summary"], "transit_s": None}, "status": "arrested"}
    found = log.changes(rows, last)
    assert [index for index, _, _ in found] == [1, 3]
    assert found[0][2] == ["bulge_cm: 0.1 → 0.2"]
    assert found[1][2] == ["status: in_transit → arrested", "transit_s: 2.0 → none"]


def test_the_page_says_how_to_reproduce_a_bad_row() -> None:
    row = finished(bulge_cm=2.0, changes={"wall.c1": "3 mN/cm", "regions": '[{name = "a"}]'}, index=7)
    text = report.page([row, finished(index=8)], 2, None)
    assert "silent bulge of 2 cm over the oral ring" in text
    assert "peristalsis run baseline --reading tight --set 'wall.c1=3 mN/cm'" in text
    assert "--out out/robust-7" in text
    assert "### 8" not in text


def test_a_case_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--show", "3"]) == 0
    said = capsys.readouterr().out
    assert "peristalsis run" in said
    assert "[wall]" in said
    assert main(["--groups", "walls"]) == 2


def test_differences_of_halving() -> None:
    """Of transits; of last places; at least what is too much where only one was expelled."""
    row, slower = finished(), finished(summary={**finished()["summary"], "transit_s": 2.1})
    assert halving.difference(row, slower) == pytest.approx(0.05)
    stays = {**finished()["summary"], "transit_s": None}
    assert halving.difference(finished(summary=stays), finished(summary=stays, last_cm=8.5)) == pytest.approx(0.05)
    found = halving.difference(row, finished(summary=stays))
    assert found is not None
    assert found > halving.WANTED
    assert halving.difference(row, finished(outcome="diverged")) is None
    finer = halving.finer(case())
    assert [one.all_changes().get("grid.n_z") for one in finer] == ["100", "50"]
    assert finer[1].all_changes()["step.wall"] == "2.5 ms"
