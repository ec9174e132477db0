"""The one engine behind batches and sweeps: what is kept is not made again, equal runs are made once, order is kept."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from peristalsis import scenarios
from peristalsis.inputs.config import Configuration
from peristalsis.many.batch import WholeResults
from peristalsis.many.engine import rows_of
from peristalsis.many.kept import Store
from peristalsis.many.rows import Point, Row, Step, key_of
from peristalsis.many.sweep import Measured
from peristalsis.many.table import table
from peristalsis.running.pool import Failure

BASE = scenarios.configuration("resting")


def after(seconds: float) -> Configuration:
    return BASE.with_changes({"run.duration": f"{seconds!r} s"})


def duration(configuration: Configuration) -> float:
    """The work: a number of the run, or an error at three seconds."""
    if configuration.run.duration == 3.0:
        raise RuntimeError("at three")
    return configuration.run.duration


@dataclass
class InMemory:
    """A keeping without a disk."""

    rows: dict[str, Row] = field(default_factory=dict)
    made: list[float | Failure] = field(default_factory=list)

    def key(self, configuration: Configuration) -> str:
        return key_of(configuration)

    def find(self, key: str, point: Point) -> Row | None:
        return self.rows.get(key)

    def task(self, key: str, configuration: Configuration) -> Configuration:
        return configuration

    def work(self) -> Callable[[Configuration], float]:
        return duration

    def take(self, key: str, point: Point, task: Configuration, made: float | Failure) -> Row:
        self.made.append(made)
        failed = isinstance(made, Failure)
        self.rows[key] = Row({"status": "failed", "error": made.error} if failed else {"status": "x", "seconds": made})
        return self.rows[key]


def test_rows_are_those_of_the_points_in_their_order() -> None:
    keeping, steps = InMemory(), list[Step]()
    keeping.rows[key_of(after(2.0))] = Row({"status": "kept"})
    points = [
        Point("new", configuration=after(1.0)),
        Point("kept", configuration=after(2.0)),
        Point("refused", refusal="the tube is too narrow"),
        Point("equal", configuration=after(1.0)),
        Point("failing", configuration=after(3.0)),
    ]
    rows = rows_of(points, keeping, progress=steps.append)
    assert [row.point.name for row in rows] == ["new", "kept", "refused", "equal", "failing"]
    assert [row.status for row in rows] == ["x", "kept", "refused", "x", "failed"]
    assert rows[2].summary["error"] == "the tube is too narrow"
    assert "at three" in rows[4].summary["error"]
    assert len(keeping.made) == 2
    assert {step.row.point.name: step.kept for step in steps} == {
        "refused": False, "kept": True, "new": False, "equal": False, "failing": False,
    }  # fmt: skip
    assert [(step.done, step.count) for step in steps] == [(done, 5) for done in range(1, 6)]
    assert rows_of(points, keeping) == rows
    assert len(keeping.made) == 2


def test_one_key_and_one_table_for_both_ways_of_keeping(tmp_path: Path) -> None:
    """A sweep leaves out only the scenario's name, which is no part of what is measured."""
    whole, measured = WholeResults(tmp_path), Measured(Store(tmp_path), lambda *_: ({}, {}))
    named = BASE.with_changes({"scenario": "another"})
    plain = BASE.with_changes({"scenario": "baseline"})
    assert whole.key(plain) == measured.key(plain) == measured.key(named) == key_of(plain)
    assert whole.key(named) != whole.key(plain)
    text = table((), (Row({"status": "finished", "seconds": 2.0}, point=Point("one")),), tmp_path).decode()
    assert text.splitlines() == ["name,status,seconds,remarks,fingerprint,folder", "one,finished,2.0,,,"]
