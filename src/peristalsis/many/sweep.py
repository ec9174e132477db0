"""A sweep: what is measured of many runs is kept, as soon as each is finished, and the runs themselves are not.

What is kept is what `measure` makes of a run: numbers, and a few arrays. A run that is refused or breaks off is a row
too, with its reason. A changed equation is never answered with an old run.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InterruptedRun, PeristalsisError, WriteError, shown
from ..inputs.config import Configuration
from ..running.pool import Failure
from ..storing import disk
from .engine import Progress, rows_of
from .rows import Point, Row, key_of

if TYPE_CHECKING:
    from ..results.result import Result
    from ..running.simulation import Simulation

Measure = Callable[["Simulation", "Result"], tuple[dict[str, Any], dict[str, NDArray[Any]]]]
"""Numbers and arrays to keep of a finished run; a function of a module, so that processes find it."""


class Store:
    """A folder of kept runs. A file appears whole or not at all; one that cannot be read counts as missing."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)

    def load(self, key: str) -> Row | None:
        """The kept run, or None."""
        try:
            with np.load(self.folder / f"{key}.npz", allow_pickle=False) as stored:
                numbers = json.loads(str(stored["numbers"]))
                return Row(numbers, {name: stored[name] for name in stored.files if name != "numbers"})
        except (OSError, ValueError, KeyError, EOFError):
            return None

    def save(self, key: str, row: Row) -> None:
        """Keep a run. Raises WriteError."""
        image = io.BytesIO()
        arrays: dict[str, Any] = dict(row.arrays)
        np.savez_compressed(image, numbers=np.array(json.dumps(dict(row.summary), allow_nan=False)), **arrays)
        try:
            disk.DISK.make_folder(self.folder)
            disk.replace_file(self.folder / f"{key}.npz", image.getvalue(), mark=f"{os.getpid()}-")
        except OSError as error:
            raise WriteError(
                f"could not keep a run in {shown(str(self.folder))}: {error.strerror or error}; free some space or "
                "choose another folder with --out"
            ) from None


def run_one(configuration: Configuration, measure: Measure) -> Row:
    """One run, measured; whatever stops it becomes its row."""
    from ..running.simulation import Simulation

    try:
        simulation = Simulation(configuration)
        result = simulation.run()
        numbers, arrays = measure(simulation, result)
    except PeristalsisError as error:
        return Row({"status": error.status, "error": str(error)})
    return Row({"status": result.status, "error": result.error, **numbers}, arrays)


def sweep(
    configurations: Mapping[str, Configuration],
    folder: str | os.PathLike[str],
    measure: Measure,
    workers: int = 1,
    progress: Progress | None = None,
) -> dict[str, Row]:
    """Run what is not yet kept in `folder` and return the row of every name.

    configurations: name to configuration; equal ones are run once. workers: processes; 1 runs in this one. progress:
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

    def key(self, configuration: Configuration) -> str:
        """Of the experiment, whatever its scenario is called: that is no part of what is measured."""
        return key_of(configuration.with_changes({"scenario": "baseline"}))

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
        """Keep a row. Raises KeyboardInterrupt for that of an interrupted run, and WriteError."""
        row = Row({"status": "failed", "error": made.error}) if isinstance(made, Failure) else made
        if row.status == InterruptedRun.status:
            raise KeyboardInterrupt
        self.store.save(key, row)
        return row


def _run(configuration: Configuration, measure: Measure) -> Row:
    return run_one(configuration, measure)
