"""Batches: every run in a folder of its own, in any number of processes, taken up again wherever it was cut short."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

from . import disk, tables
from .checkpoint import EVERY
from .config import FIELDS, Configuration
from .environment import code_version
from .errors import (
    ConfigurationError,
    DamagedResult,
    DivergenceError,
    InterruptedRun,
    PeristalsisError,
    WriteError,
    shown,
)
from .locks import PATIENCE, Claim
from .paths import located
from .plan import Plan, Point, as_text, read_plan
from .result import CLOCK, json_ready, read_summary
from .runner import KeptRun
from .store import CONFIGURATION_FILE, SUMMARY_FILE, Workspace, quarantine, recover, verify
from .studies.pool import Failure, carry_out, refuse_while_starting
from .units import QuantityError
from .units import read as read_quantity
from .warm_up import warm_up

TABLE, RUNS = "table.csv", "runs"
WITHOUT_RESULT = ("refused", "failed", DivergenceError.status)
"""How points end that have no result, or none to be used."""
MOST_TABLE = 1_000_000_000
"""Bytes of an older table that is looked at before it is replaced."""
RISKY = ("=", "+", "-", "@", "\t", "\r")
"""A text that begins with one of these would be taken for a formula by a spreadsheet."""


@dataclass(frozen=True)
class Row:
    """What became of one point: folder of its run (none if it was refused), summary, fingerprint, remarks."""

    point: Point
    folder: Path | None
    summary: Mapping[str, Any]
    fingerprint: str = ""
    remarks: tuple[str, ...] = ()

    @property
    def status(self) -> str:
        """As of a run; `refused` if the configuration was, `failed` if its process died each time."""
        return str(self.summary["status"])


@dataclass(frozen=True)
class Step:
    """One point of a batch that has its row: how many are done of how many, and whether it was there before."""

    row: Row
    done: int
    count: int
    kept: bool


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
    workers: int = 1,
    every: float = EVERY,
    progress: Callable[[Step], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> Batch:
    """Carry out the runs of a plan (or of a batch file) that are missing in OUT/runs, and write OUT/table.csv.

    workers: processes; the results do not depend on how many. every: seconds on the clock between checkpoints. A run
    that fails is a row with its reason. What can end otherwise another time is run again by the next call, and `say`
    is told: a point whose process died, and one that is damaged, which is moved aside. Raises ConfigurationError for a
    bad file, WriteError when results cannot be stored or another process works in OUT, and InterruptedRun when
    stopped: what was finished stays, and a second call goes on.
    """
    refuse_while_starting()
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
    workers: int,
    every: float,
    progress: Callable[[Step], None] | None,
    say: Callable[[str], None] | None,
) -> Batch:
    code = code_version()
    same: dict[Path, list[Point]] = {}
    rows: dict[int, Row] = {}

    def found(row: Row, kept: bool) -> None:
        rows[id(row.point)] = row
        if progress is not None:
            progress(Step(row, len(rows), len(planned.points), kept))

    for point in planned.points:
        if point.configuration is None:
            found(Row(point, None, {"status": "refused", "error": point.refusal}), kept=False)
        else:
            same.setdefault(target / RUNS / point.folder(code), []).append(point)
    missing: dict[str, _Task] = {}
    for folder, points in same.items():
        row = _stored(points[0], folder, say)
        if row is None or _again(row, say):
            configuration = points[0].configuration
            assert configuration is not None
            missing[str(folder)] = _Task(configuration, folder, every)
        else:
            for point in points:
                found(replace(row, point=point), kept=True)
    for name in _carried_out(missing, workers):
        points = same[Path(name)]
        row = _stored(points[0], Path(name), say)
        if row is None:
            raise WriteError(f"{shown(name)} was written and cannot be read again; see whether the disk is in order")
        for point in points:
            found(replace(row, point=point), kept=False)
    ordered = tuple(rows[id(point)] for point in planned.points)
    table = target / TABLE
    try:
        disk.DISK.make_folder(target)
        _keep_other(table, {_name_of(row.folder, target) for row in ordered}, say)
        disk.replace_file(table, _table(planned.keys, ordered, target))
    except OSError as error:
        raise WriteError(f"could not write {shown(str(table))}: {error.strerror or error}; free some space") from None
    return Batch(ordered, table)


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


def _name_of(folder: Path | None, target: Path) -> str:
    return "" if folder is None else folder.relative_to(target).as_posix()


def _stored(point: Point, folder: Path, say: Callable[[str], None] | None) -> Row | None:
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
    return Row(point, folder, summary, str(found.about.get("fingerprint", "")), said)


def _again(row: Row, say: Callable[[str], None] | None) -> bool:
    """Whether a point is to be run again: its process had died, which need not happen a second time."""
    if row.status != PeristalsisError.status:
        return False
    if say is not None:
        say(f"{row.point.name} in {shown(str(row.folder))} had failed ({row.summary.get('error')}): it is tried again")
    return True


def _carried_out(missing: Mapping[str, _Task], workers: int) -> Iterator[str]:
    """Run what is missing; the name of every folder that is there, in the order in which they are finished."""
    if workers > 1 and len(missing) > 1:
        warm_up()  # compiled once here, not once in every process
    for done in carry_out(missing, run_one, workers):
        if isinstance(done.value, Failure):
            _record(missing[done.key], PeristalsisError.status, done.value.error)
        elif done.value == InterruptedRun.status:
            raise InterruptedRun("interrupted; what was finished is kept, and the same call goes on")
        yield done.key


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


def _table(keys: tuple[str, ...], rows: tuple[Row, ...], target: Path) -> bytes:
    """All rows as CSV: what was set, how it ended, every number of the summary; the same whatever the workers."""
    flat = [_flat({name: value for name, value in row.summary.items() if name not in CLOCK}) for row in rows]
    numbers = list(dict.fromkeys(name for one in flat for name in one if name not in ("scenario", "reading")))
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    units = {key: FIELDS[key].unit if key in FIELDS else "" for key in keys}
    writer.writerow(["name", *keys, *numbers, "remarks", "fingerprint", "folder"])
    for row, one in zip(rows, flat, strict=True):
        folder = _name_of(row.folder, target)
        given = {key: as_text(row.point.values[key]) if key in row.point.values else "" for key in units}
        values = [_guarded(text, units[key]) for key, text in given.items()]
        said = " | ".join(row.remarks)
        cells = [row.point.name, *(_cell(one.get(name)) for name in numbers), said, row.fingerprint, folder]
        name, *rest = map(_guarded, cells)
        writer.writerow([name, *values, *rest])
    return text.getvalue().encode("utf-8")


def _flat(summary: Mapping[str, Any]) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in summary.items():
        if isinstance(value, Mapping):
            flat |= {f"{name}_{inner}": one for inner, one in value.items()}
        else:
            flat[name] = value
    return flat


def _cell(value: object) -> str:
    return "" if value is None else value if isinstance(value, str) else repr(value)


def _guarded(cell: str, unit: str = "") -> str:
    """A cell that no spreadsheet takes for a formula; numbers stay as they are, those with a unit in their column."""
    return f"'{cell}" if cell.startswith(RISKY) and not _is_number(cell, unit) else cell


def _is_number(cell: str, unit: str) -> bool:
    try:
        float(cell)
    except ValueError:
        try:
            return bool(unit) and math.isfinite(read_quantity(cell, unit))
        except QuantityError:
            return False
    return True
