"""A sweep: what is measured of many runs is kept, as soon as each is finished, and the runs themselves are not.

What is kept is what `measure` makes of a run: numbers, and a few arrays. A run that is refused or breaks off is a row
too, with its reason. A changed equation is never answered with an old run.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InterruptedRun, PeristalsisError, WriteError, shown
from ..inputs.config import Configuration
from ..running.pool import Failure, Workers
from ..storing import disk
from .engine import Progress, rows_of
from .rows import CODE, Point, Row, key_of

if TYPE_CHECKING:
    from ..results.result import Result
    from ..running.simulation import Simulation

Measure = Callable[["Simulation", "Result"], tuple[dict[str, Any], dict[str, NDArray[Any]]]]
"""Numbers and arrays to keep of a finished run; a function of a module, so that processes find it."""


class Store:
    """A folder of kept runs, safe for any number of processes at once.

    A file appears whole or not at all. One that cannot be read, or does not agree with its hash, counts as missing.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)

    def load(self, key: str) -> Row | None:
        """The kept run, or None."""
        try:
            with np.load(self.folder / f"{key}.npz", allow_pickle=False) as stored:
                text = str(stored["numbers"])
                arrays = {name: stored[name] for name in stored.files if name not in ("numbers", "sha256")}
                if str(stored["sha256"]) != _digest(key, text, arrays):
                    return None
                return Row(json.loads(text), arrays)
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
            return None

    def save(self, key: str, row: Row) -> None:
        """Keep a run. Raises WriteError."""
        image = io.BytesIO()
        arrays: dict[str, Any] = dict(row.arrays)
        text = json.dumps(dict(row.summary), allow_nan=False)
        sha256 = np.array(_digest(key, text, arrays))
        np.savez_compressed(image, numbers=np.array(text), sha256=sha256, **arrays)
        try:
            disk.DISK.make_folder(self.folder)
            disk.replace_file(self.folder / f"{key}.npz", image.getvalue(), mark=f"{os.getpid()}-")
        except OSError as error:
            raise WriteError(
                f"could not keep a run in {shown(str(self.folder))}: {error.strerror or error}; free some space or "
                "choose another folder with --out"
            ) from None


def _digest(key: str, text: str, arrays: Mapping[str, NDArray[Any]]) -> str:
    """Hash of all that is kept of a run, its key included: a file under another name is not that run."""
    found = hashlib.sha256(f"{key}\n{text}\n".encode())
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name])
        found.update(f"{name} {values.dtype.str} {values.shape}\n".encode("ascii"))
        found.update(values.tobytes())
    return found.hexdigest()


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
