"""Carries out many runs: what is kept is not run again, equal ones are run once, the rest in any number of processes.

A `Keeping` decides how a run is kept: as a whole result in a folder (`batch`), or as what is measured of it
(`sweep`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

from ..inputs.config import Configuration
from ..running.pool import Engine, Failure, Workers, carry_out
from ..running.warm_up import warm_up
from .rows import Point, Row, Step

Progress = Callable[[Step], None]


class Keeping(Protocol):
    """Where the rows of runs are kept, and how a missing one is made."""

    def key(self, configuration: Configuration) -> str:
        """The same for runs of which one does for the other."""

    def find(self, key: str, point: Point) -> Row | None:
        """The row that is kept, or None if the run is missing."""

    def task(self, key: str, configuration: Configuration) -> Any:
        """What `work` needs to make it, in whatever process."""

    def work(self) -> Callable[[Any], Any]:
        """What is done to each task; a function of a module, so that processes find it."""

    def take(self, key: str, point: Point, task: Any, made: Any | Failure) -> Row:
        """Keep what was made, or why nothing was, and give its row. Raises what is to end the rest."""


def rows_of(
    points: Sequence[Point], keeping: Keeping, workers: Workers = 1, progress: Progress | None = None
) -> tuple[Row, ...]:
    """The row of every point, in their order; those that are missing are made by these workers.

    workers: processes (1: this one), the address of a Dask scheduler, or an engine that is open. progress: told of
    every row as it is there. The rows do not depend on the workers. Raises what `keeping` raises.
    """
    rows: dict[int, Row] = {}

    def found(place: int, row: Row, kept: bool) -> None:
        rows[place] = replace(row, point=points[place])
        if progress is not None:
            progress(Step(rows[place], len(rows), len(points), kept))

    same: dict[str, list[int]] = {}
    configurations: dict[str, Configuration] = {}
    for place, point in enumerate(points):
        if point.configuration is None:
            found(place, Row({"status": "refused", "error": point.refusal}), kept=False)
        else:
            key = keeping.key(point.configuration)
            configurations.setdefault(key, point.configuration)
            same.setdefault(key, []).append(place)
    missing: dict[str, Any] = {}
    for key, places in same.items():
        row = keeping.find(key, points[places[0]])
        if row is None:
            missing[key] = keeping.task(key, configurations[key])
            continue
        for place in places:
            found(place, row, kept=True)
    first = {key: points[places[0]] for key, places in same.items()}
    for key, row in _made(missing, configurations, first, keeping, workers):
        for place in same[key]:
            found(place, row, kept=False)
    return tuple(rows[place] for place in range(len(points)))


def _made(
    missing: Mapping[str, Any],
    configurations: Mapping[str, Configuration],
    first: Mapping[str, Point],
    keeping: Keeping,
    workers: Workers,
) -> Iterator[tuple[str, Row]]:
    """Key and row of every missing run, in the order in which they are finished."""
    if _in_processes(workers) and len(missing) > 1:
        for key in missing:  # compiled once here, not once in every process
            one = configurations[key]
            warm_up(one.grid.n_theta > 1, one.solver.integrator == "explicit", one.parts_chosen())
    for done in carry_out(missing, keeping.work(), workers):
        yield done.key, keeping.take(done.key, first[done.key], missing[done.key], done.value)


def _in_processes(workers: Workers) -> bool:
    """Whether several processes of this machine work, which then find the kernels compiled."""
    count = workers.width if isinstance(workers, Engine) else workers
    return isinstance(count, int) and count > 1
