"""Sweeps: what is kept is not run again, equal experiments are one, failures are results."""

from pathlib import Path

import numpy as np
import pytest

from peristalsis import scenarios
from peristalsis.many import engine
from peristalsis.many import sweep as module
from peristalsis.many.kept import Store
from peristalsis.many.rows import Row, key_of
from peristalsis.many.sensitivity import shares, total_shares
from peristalsis.many.sweep import Measured, sweep
from peristalsis.many.threshold import Point, Threshold
from peristalsis.running.pool import Done

BASE = scenarios.configuration("resting")


def variants(*durations: str) -> dict:
    return {f"run {one}": BASE.with_changes({"run.duration": one}) for one in durations}


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Replaces the run by one that notes its duration; those of 3 s break off."""
    made: list[float] = []

    def run_one(configuration, measure) -> Row:
        made.append(configuration.run.duration)
        if configuration.run.duration == 3.0:
            return Row({"status": "diverged", "error": "at three"})
        return Row({"status": "finished", "duration": configuration.run.duration}, {"a": np.arange(3.0)})

    monkeypatch.setattr(module, "run_one", run_one)
    return made


def test_a_second_sweep_runs_only_what_is_missing(tmp_path: Path, counted: list[float]) -> None:
    sweep(variants("1 s", "2 s"), tmp_path, None)
    steps = []
    found = sweep(variants("1 s", "2 s", "4 s"), tmp_path, None, progress=steps.append)
    assert counted == [1.0, 2.0, 4.0]
    assert [step.kept for step in steps] == [True, True, False]
    assert [step.done for step in steps] == [1, 2, 3]
    assert found["run 2 s"].summary["duration"] == 2.0
    assert found["run 1 s"].arrays["a"] == pytest.approx(np.arange(3.0))


def test_failures_are_results_and_are_kept(tmp_path: Path, counted: list[float]) -> None:
    for _ in range(2):
        found = sweep(variants("3 s"), tmp_path, None)
        assert found["run 3 s"].status == "diverged"
        assert found["run 3 s"].summary["error"] == "at three"
    assert counted == [3.0]


def test_equal_experiments_of_two_names_are_run_once(tmp_path: Path, counted: list[float]) -> None:
    other = BASE.with_changes({"scenario": "another"})
    keeping = Measured(Store(tmp_path), None)
    assert keeping.key(other) == keeping.key(BASE)
    found = sweep({"one": BASE, "two": other}, tmp_path, None)
    assert len(counted) == 1
    assert set(found) == {"one", "two"}


def test_a_changed_number_is_another_experiment() -> None:
    assert key_of(BASE.with_changes({"lumen.pressure": "0.2 kPa"})) != key_of(BASE)


def test_an_interrupted_run_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "run_one", lambda configuration, measure: Row({"status": "interrupted"}))
    with pytest.raises(KeyboardInterrupt):
        sweep(variants("1 s"), tmp_path, None)
    assert Store(tmp_path).load(key_of(variants("1 s")["run 1 s"])) is None


def test_what_was_kept_before_an_interruption_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def run_one(configuration, measure) -> Row:
        return Row({"status": "interrupted" if configuration.run.duration == 2.0 else "finished"})

    monkeypatch.setattr(module, "run_one", run_one)
    with pytest.raises(KeyboardInterrupt):
        sweep(variants("1 s", "2 s", "4 s"), tmp_path, None)
    assert len(list(tmp_path.glob("*.npz"))) == 1


def test_a_broken_file_counts_as_missing(tmp_path: Path, counted: list[float]) -> None:
    sweep(variants("1 s"), tmp_path, None)
    next(tmp_path.glob("*.npz")).write_bytes(b"not an archive")
    sweep(variants("1 s"), tmp_path, None)
    assert counted == [1.0, 1.0]


def test_shares_of_a_table_with_one_factor() -> None:
    rows = np.repeat(np.array([1.0, 2.0, 4.0])[:, None], 4, axis=1)
    assert total_shares(rows) == pytest.approx((1.0, 0.0))
    assert total_shares(rows.T) == pytest.approx((0.0, 1.0))
    assert total_shares(np.ones((3, 3))) == (0.0, 0.0)


def test_interaction_counts_for_both_factors() -> None:
    product = np.outer([-1.0, 1.0], [-1.0, 1.0])
    assert total_shares(product) == pytest.approx((1.0, 1.0))


def test_bands_hold_the_whole_and_open_where_one_level_decides() -> None:
    table = np.zeros((4, 4))
    table[0] = 1.0
    table[:, 3] += 0.2
    found = shares(table)
    assert found.first_band[0] <= found.first <= found.first_band[1]
    assert found.first_band[0] == pytest.approx(0.0)
    assert found.second < found.first


def test_processes_find_the_kernels_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiled once before several processes are started, not for one; all are then carried out by as many."""
    seen: list[object] = []

    def carried_out(missing, work, workers: int):  # type: ignore[no-untyped-def]
        seen.append(workers)
        yield from (Done(key, Row({"status": "finished"})) for key in missing)

    monkeypatch.setattr(engine, "warm_up", lambda surface, explicit, parts: seen.append((surface, explicit, parts)))
    monkeypatch.setattr(engine, "carry_out", carried_out)
    assert set(sweep(variants("1 s", "2 s"), tmp_path, None, workers=2)) == {"run 1 s", "run 2 s"}
    shipped = (False, False, {})
    assert seen == [shipped, shipped, 2]
    sweep(variants("1 s", "2 s", "4 s"), tmp_path, None, workers=2)
    assert seen == [shipped, shipped, 2, 2], "one run is not worth it"


def test_regions_of_a_threshold_leave_out_what_was_not_judged() -> None:
    points = (Point(1.0, False), Point(1.5, None), Point(2.0, False), Point(3.0, True))
    assert Threshold(2.0, 3.0, points, ()).regions() == ((1.0, 2.0, False), (3.0, 3.0, True))
