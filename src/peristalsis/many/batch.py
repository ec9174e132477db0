"""A batch: every run in a folder of its own, in any number of processes, taken up again wherever it was cut short."""

from __future__ import annotations

import csv
import hashlib
import io
import json
from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from ..errors import (
    ConfigurationError,
    DamagedResult,
    DivergenceError,
    InterruptedRun,
    PeristalsisError,
    WriteError,
    could_not,
    shown,
)
from ..inputs import tables
from ..inputs.config import Configuration
from ..paths import located
from ..results.result import json_ready, read_summary
from ..running.pool import Failure, Workers
from ..running.runner import KeptRun
from ..storing import disk
from ..storing.checkpoint import EVERY
from ..storing.environment import code_version
from ..storing.locks import PATIENCE, Claim
from ..storing.store import CONFIGURATION_FILE, SUMMARY_FILE, Workspace, quarantine, recover, verify
from .engine import rows_of
from .plan import Plan, read_plan
from .rows import Point, Row, Step, key_of
from .table import name_of, table

TABLE, RUNS = "table.csv", "runs"
WITHOUT_RESULT = ("refused", "failed", DivergenceError.status)
"""How points end that have no result, or none to be used."""
MOST_TABLE = 1_000_000_000
"""Bytes of an older table that is looked at before it is replaced."""


@dataclass(frozen=True)
class Batch:
    """All rows, in the order of the plan, and the file that holds them."""

    rows: tuple[Row, ...]
    table: Path

    @property
    def status(self) -> str:
        """`finished` if every point has its result, `failed` if none has, `partly_failed` otherwise."""
        without = sum(row.status in WITHOUT_RESULT for row in self.rows)
        return "finished" if without == 0 else "failed" if without == len(self.rows) else "partly_failed"


@dataclass(frozen=True)
class _Task:
    configuration: Configuration
    folder: Path
    every: float


def batch(
    plan: Plan | str | PathLike[str],
    out: str | PathLike[str],
    *,
    workers: Workers = 1,
    every: float = EVERY,
    progress: Callable[[Step], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> Batch:
    """Carry out the runs of a plan (or of a batch file) that are missing in OUT/runs, and write OUT/table.csv.

    workers: processes, or the address of a Dask scheduler whose workers see the same
    folder; the results do not depend on them. every: seconds on the clock between checkpoints. A run
    that fails is a row with its reason. What can end otherwise another time is run again by the next call, and `say`
    is told: a point whose process died, and one that is damaged, which is moved aside. Raises ConfigurationError for a
    bad file, WriteError when results cannot be stored or another process works in OUT, and InterruptedRun when
    stopped: what was finished stays, and a second call goes on.
    """
    planned = plan if isinstance(plan, Plan) else read_plan(Path(plan))
    target = located(out)
    if target.is_symlink() or (target.exists() and not target.is_dir()):
        raise WriteError(f"{shown(str(target))} is not a folder; choose another one with --out")
    claim = Claim(target)
    try:
        return _batch(planned, target, workers, every, progress, say)
    finally:
        claim.release()


def _batch(
    planned: Plan,
    target: Path,
    workers: Workers,
    every: float,
    progress: Callable[[Step], None] | None,
    say: Callable[[str], None] | None,
) -> Batch:
    rows = rows_of(planned.points, WholeResults(target, every, say), workers, progress)
    file = target / TABLE
    try:
        disk.DISK.make_folder(target)
        _keep_other(file, {name_of(row.folder, target) for row in rows}, say)
        disk.replace_file(file, table(planned.keys, rows, target))
    except OSError as error:
        raise could_not(f"write {shown(str(file))}", error) from None
    return Batch(rows, file)


@dataclass(frozen=True)
class WholeResults:
    """Runs kept as whole results, each in a folder of its own below TARGET/runs (a `Keeping`)."""

    target: Path
    every: float = EVERY
    say: Callable[[str], None] | None = None

    def key(self, configuration: Configuration) -> str:
        """Of the experiment with its scenario's name, which is part of a result."""
        return key_of(configuration)

    def find(self, key: str, point: Point) -> Row | None:
        """The row of a run that is finished and need not be run again."""
        row = _stored(self._folder(key), self.say)
        return None if row is None or _again(point, row, self.say) else row

    def task(self, key: str, configuration: Configuration) -> _Task:
        """The run and its folder."""
        return _Task(configuration, self._folder(key), self.every)

    def work(self) -> Callable[[_Task], str]:
        """One run to its folder."""
        return run_one

    def take(self, key: str, point: Point, task: _Task, made: str | Failure) -> Row:
        """The row of what was stored. Raises InterruptedRun where that is no finished run, and WriteError."""
        if isinstance(made, Failure):
            _record(task, PeristalsisError.status, made.error)
        elif made == InterruptedRun.status:
            raise InterruptedRun("interrupted; what was finished is kept, and the same call goes on")
        row = _stored(task.folder, self.say)
        if row is None:
            name = shown(str(task.folder))
            raise WriteError(f"{name} was written and cannot be read again; see whether the disk is in order")
        return row

    def _folder(self, key: str) -> Path:
        return self.target / RUNS / key


def _keep_other(table: Path, folders: set[str], say: Callable[[str], None] | None) -> None:
    """Give a table with runs that the new one does not have, such as that of another batch file, a name of its own."""
    try:
        content = disk.read_regular(table, MOST_TABLE)
    except FileNotFoundError:
        return
    rows = csv.DictReader(io.StringIO(content.decode("utf-8", errors="replace"), newline=""))
    if {row.get("folder") or "" for row in rows} <= folders | {""}:
        return
    apart = table.with_name(f"{table.stem}-{hashlib.sha256(content).hexdigest()[:8]}{table.suffix}")
    disk.DISK.rename(table, apart)
    if say is not None:
        say(f"{shown(str(table))} had runs that are not in this batch: it is kept as {shown(apart.name)}")


def _stored(folder: Path, say: Callable[[str], None] | None) -> Row | None:
    """The row of a run that is finished, None of one that is to be run; one that is damaged is moved aside first."""
    recover(folder)
    if not folder.exists():
        return None
    try:
        found = verify(folder)
        if found.status == InterruptedRun.status:
            return None
        summary = read_summary(folder, found)
    except ConfigurationError as error:
        try:
            aside = quarantine(folder)
        except OSError as problem:
            raise WriteError(f"could not move {shown(str(folder))} aside: {problem.strerror}") from None
        if say is not None:
            reason = error if isinstance(error, DamagedResult) else f"{shown(str(folder))} is no whole result"
            say(f"{reason}; it is in {shown(str(aside))} and is run again")
        return None
    remarks = found.about.get("remarks", ())
    said = tuple(map(str, remarks)) if isinstance(remarks, list | tuple) else ()
    return Row(summary, folder=folder, fingerprint=str(found.about.get("fingerprint", "")), remarks=said)


def _again(point: Point, row: Row, say: Callable[[str], None] | None) -> bool:
    """Whether a point is to be run again: its process had died, which need not happen a second time."""
    if row.status != PeristalsisError.status:
        return False
    if say is not None:
        say(f"{point.name} in {shown(str(row.folder))} had failed ({row.summary.get('error')}): it is tried again")
    return True


def run_one(task: _Task) -> str:
    """One run to its folder, from its checkpoint if there is one; its status. Raises WriteError."""
    with KeptRun(task.configuration, task.folder, resume=True, every=task.every, patience=PATIENCE) as kept:
        if kept.finished is not None:
            return kept.finished.status
        try:
            result = kept.begin().run()
        except DivergenceError as error:  # before its first step: there is no history
            _record(task, error.status, str(error))
            return error.status
        if result.status != InterruptedRun.status:  # what was interrupted goes on from its checkpoint
            kept.save(result)
        return result.status


def _record(task: _Task, status: str, error: str) -> None:
    """Store why a run has no numbers, as its result."""
    configuration = task.configuration
    summary = {
        "scenario": configuration.scenario,
        "reading": configuration.reading,
        "status": status,
        "error": " ".join(error.split()),
    }
    files = tables.files_of(configuration.naming_tables()) | {
        CONFIGURATION_FILE: configuration.to_toml().encode("utf-8"),
        SUMMARY_FILE: (json.dumps(json_ready(summary), indent=2) + "\n").encode("utf-8"),
    }
    about = {"configuration_sha256": configuration.digest(), "code": code_version()}
    workspace = Workspace(task.folder)
    try:
        workspace.publish(files, status, about)
    finally:
        workspace.close()
