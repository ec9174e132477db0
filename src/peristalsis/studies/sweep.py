"""Many runs in parallel processes, each kept on disk as soon as it is finished, so that a sweep can be taken up again.

A run is kept under the digest of its configuration, the version of the package and that of its equations' sources, so
that a changed equation is never answered with an old run. What is kept is what `measure`
makes of it: numbers, and a few arrays. A run that is refused or breaks off is a result too, with its reason.
"""

from __future__ import annotations

import io
import json
import multiprocessing
import os
import uuid
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._version import __version__
from ..config import Configuration
from ..errors import PeristalsisError, WriteError, shown
from ..numerics.compiled import source_digest

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
        temporary = self.folder / f".tmp-{uuid.uuid4().hex}"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            temporary.write_bytes(image.getvalue())
            os.replace(temporary, self.folder / f"{key}.npz")
        except OSError as error:
            raise WriteError(
                f"could not keep a run in {shown(str(self.folder))}: {error.strerror or error}; free some space or "
                "choose another folder with --out"
            ) from None
        finally:
            temporary.unlink(missing_ok=True)


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


def _computed(missing: Mapping[str, Configuration], measure: Measure, workers: int) -> Any:
    """Key and record of every missing run, in the order in which they finish."""
    if workers <= 1 or len(missing) <= 1:
        for key, configuration in missing.items():
            yield key, run_one(configuration, measure)
        return
    # Fresh processes: a forked one would share the state of compiled code and threads.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(workers, len(missing)), mp_context=context) as pool:
        pending: dict[Future[Record], str] = {
            pool.submit(run_one, configuration, measure): key for key, configuration in missing.items()
        }
        try:
            while pending:
                done, _ = wait(pending, return_when=FIRST_COMPLETED)
                for future in done:
                    key = pending.pop(future)
                    yield key, _outcome(future)
        except BaseException:
            for future in pending:
                future.cancel()
            raise


def _outcome(future: Future[Record]) -> Record:
    """The record of a finished process; one that died, for want of memory for example, is a failure."""
    try:
        return future.result()
    except (KeyboardInterrupt, SystemExit):
        raise
    except Exception as error:
        return Record({"status": "failed", "error": f"{type(error).__name__}: {error}"})
