"""A sweep: what is measured of many runs is kept, as soon as each is finished, and the runs themselves are not.

What is kept is what `measure` makes of a run: numbers, and a few arrays. A run that is refused or breaks off is a row
too, with its reason. A changed equation is never answered with an old run.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from ..errors import InterruptedRun, PeristalsisError
from ..inputs.config import Configuration
from ..running.pool import Failure, Workers
from .engine import Progress, rows_of
from .kept import Store
from .rows import CODE, Point, Row, key_of

if TYPE_CHECKING:
    from ..results.result import Result
    from ..running.simulation import Simulation

Measure = Callable[["Simulation", "Result"], tuple[dict[str, Any], dict[str, NDArray[Any]]]]
"""Numbers and arrays to keep of a finished run; a function of a module, so that processes find it."""


def run_one(configuration: Configuration, measure: Measure) -> Row:
    """One run, measured; whatever stops it becomes its row."""
    from ..running.simulation import Simulation

    try:
        simulation = Simulation(configuration)
        result = simulation.run()
        numbers, arrays = measure(simulation, result)
    except PeristalsisError as error:
        return Row({"status": error.status, "error": str(error), "code": CODE})
    return Row({"status": result.status, "error": result.error, **numbers}, arrays)


def sweep(
    configurations: Mapping[str, Configuration],
    folder: str | os.PathLike[str],
    measure: Measure,
    workers: Workers = 1,
    progress: Progress | None = None,
) -> dict[str, Row]:
    """Run what is not yet kept in `folder` and return the row of every name.

    configurations: name to configuration; equal ones are run once. workers: as for `rows_of`. progress:
    told of every row. An interrupted run is not kept. Raises WriteError if a row cannot be kept.
    """
    points = [Point(name, configuration=configuration) for name, configuration in configurations.items()]
    rows = rows_of(points, Measured(Store(folder), measure), workers, progress)
    return {row.point.name: row for row in rows}


@dataclass(frozen=True)
class Measured:
    """Runs kept as what is measured of them (a `Keeping`)."""

    store: Store
    measure: Measure
    kind: str = ""
    """Tells measures apart that keep what they measure in one folder."""

    def key(self, configuration: Configuration) -> str:
        """Of the experiment, whatever its scenario is called: that is no part of what is measured."""
        key = key_of(configuration.with_changes({"scenario": "baseline"}))
        return f"{key}-{self.kind}" if self.kind else key

    def find(self, key: str, point: Point) -> Row | None:
        """The kept row, or None."""
        return self.store.load(key)

    def task(self, key: str, configuration: Configuration) -> Configuration:
        """The run."""
        return configuration

    def work(self) -> Callable[[Configuration], Row]:
        """One run, measured."""
        return partial(_run, measure=self.measure)

    def take(self, key: str, point: Point, task: Configuration, made: Row | Failure) -> Row:
        """Keep a row, but not one of a lost worker. Raises KeyboardInterrupt for an interrupted run, and WriteError."""
        if isinstance(made, Failure):  # which need not happen a second time
            return Row({"status": PeristalsisError.status, "error": made.error})
        row = made
        if row.status == InterruptedRun.status:
            raise KeyboardInterrupt
        self.store.save(key, row)
        return row


def _run(configuration: Configuration, measure: Measure) -> Row:
    return run_one(configuration, measure)
