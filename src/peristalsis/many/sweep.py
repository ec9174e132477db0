"""Many runs in parallel processes, each kept on disk as soon as it is finished, so that a sweep can be taken up again.

A run is kept under the digest of its configuration, the version of the package and that of its equations' sources, so
that a changed equation is never answered with an old run. What is kept is what `measure`
makes of it: numbers, and a few arrays. A run that is refused or breaks off is a result too, with its reason.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import disk
from .._version import __version__
from ..config import Configuration
from ..errors import PeristalsisError, WriteError, shown
from ..numerics.sources import source_digest
from ..warm_up import warm_up
from .pool import Failure, carry_out

if TYPE_CHECKING:
    from ..result import Result
    from ..simulation import Simulation

Arrays = Mapping[str, NDArray[Any]]
Measure = Callable[["Simulation", "Result"], tuple[dict[str, Any], dict[str, NDArray[Any]]]]
"""Numbers and arrays to keep of a finished run; a function of a module, so that processes find it."""


@dataclass(frozen=True)
class Record:
    """What is kept of a run: `numbers` (with `status`, and `error` where there is one) and `arrays`."""

    numbers: Mapping[str, Any]
    arrays: Arrays = field(default_factory=dict)

    @property
    def status(self) -> str:
        """How the run ended; `refused` if its configuration was."""
        return str(self.numbers["status"])


@dataclass(frozen=True, slots=True)
class Step:
    """One finished run of a sweep: its name, how many are done of how many, and whether it was kept from before."""

    name: str
    record: Record
    done: int
    count: int
    kept: bool


SOURCES = source_digest()
"""Of the equations that this process has loaded, not of what may have changed on disk since."""


def key_of(configuration: Configuration) -> str:
    """The key under which a run is kept: equal experiments have one key, whatever their scenarios are called."""
    return f"{configuration.with_changes({'scenario': 'baseline'}).digest()[:24]}-{__version__}-{SOURCES[:8]}"


class Store:
    """A folder of kept runs. A file appears whole or not at all; one that cannot be read counts as missing."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)

    def load(self, key: str) -> Record | None:
        """The kept run, or None."""
        try:
            with np.load(self.folder / f"{key}.npz", allow_pickle=False) as stored:
                numbers = json.loads(str(stored["numbers"]))
                return Record(numbers, {name: stored[name] for name in stored.files if name != "numbers"})
        except (OSError, ValueError, KeyError, EOFError):
            return None

    def save(self, key: str, record: Record) -> None:
        """Keep a run. Raises WriteError."""
        image = io.BytesIO()
        arrays: dict[str, Any] = dict(record.arrays)
        np.savez_compressed(image, numbers=np.array(json.dumps(dict(record.numbers), allow_nan=False)), **arrays)
        try:
            disk.DISK.make_folder(self.folder)
            disk.replace_file(self.folder / f"{key}.npz", image.getvalue(), mark=f"{os.getpid()}-")
        except OSError as error:
            raise WriteError(
                f"could not keep a run in {shown(str(self.folder))}: {error.strerror or error}; free some space or "
                "choose another folder with --out"
            ) from None


def run_one(configuration: Configuration, measure: Measure) -> Record:
    """One run, measured; whatever stops it becomes its record."""
    from ..simulation import Simulation

    try:
        simulation = Simulation(configuration)
        result = simulation.run()
        numbers, arrays = measure(simulation, result)
    except PeristalsisError as error:
        return Record({"status": error.status, "error": str(error)})
    return Record({"status": result.status, "error": result.error, **numbers}, arrays)


def sweep(
    configurations: Mapping[str, Configuration],
    folder: str | os.PathLike[str],
    measure: Measure,
    workers: int = 1,
    progress: Callable[[Step], None] | None = None,
) -> dict[str, Record]:
    """Run what is not yet kept in `folder` and return the record of every name.

    configurations: name to configuration; equal ones are run once. workers: processes; 1 runs in this one. progress:
    called after every run. An interrupted run is not kept. Raises WriteError if a run cannot be kept.
    """
    store = Store(folder)
    names: dict[str, list[str]] = {}
    for name, configuration in configurations.items():
        names.setdefault(key_of(configuration), []).append(name)
    found: dict[str, Record] = {}

    def finished(key: str, record: Record, kept: bool) -> None:
        for name in names[key]:
            found[name] = record
            if progress is not None:
                progress(Step(name, record, len(found), len(configurations), kept))

    missing = {}
    for key, same in names.items():
        record = store.load(key)
        if record is None:
            missing[key] = configurations[same[0]]
        else:
            finished(key, record, kept=True)
    for key, record in _computed(missing, measure, workers):
        if record.status != "interrupted":
            store.save(key, record)
        finished(key, record, kept=False)
        if record.status == "interrupted":
            raise KeyboardInterrupt
    return found


def _computed(missing: Mapping[str, Configuration], measure: Measure, workers: int) -> Iterator[tuple[str, Record]]:
    """Key and record of every missing run, in the order in which they finish; one that died is a failure."""
    if workers > 1 and len(missing) > 1:
        warm_up()  # compiled once here, not once in every process
    for done in carry_out(missing, partial(_run, measure=measure), workers):
        value = done.value
        yield done.key, Record({"status": "failed", "error": value.error}) if isinstance(value, Failure) else value


def _run(configuration: Configuration, measure: Measure) -> Record:
    return run_one(configuration, measure)
