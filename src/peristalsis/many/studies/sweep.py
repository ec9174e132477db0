"""`ps.sweep`: a study carried out, or taken up again, and its table written."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from os import PathLike
from pathlib import Path
from typing import Any

from ...errors import WriteError, shown
from ...paths import located
from ...running.pool import Workers
from ...storing import disk
from ...storing.locks import Claim
from ..rows import CODE, Step
from .runs import Runs, kept_beside
from .study import Study, located_study
from .table import Table, parquet_library

RECORD = "study.json"
MOST_RECORD = 64 * 1024 * 1024
"""Bytes of an older record that is looked at."""


def sweep(
    study: Study | str | PathLike[str],
    out: str | PathLike[str],
    *,
    workers: Workers = 1,
    kept: str | PathLike[str] | None = None,
    parquet: bool = False,
    reading: str | None = None,
    progress: Callable[[Step], None] | None = None,
    say: Callable[[str], None] | None = None,
) -> Table:
    """Carry out a study (or that of a file) and write OUT/table.csv; only runs that are not kept are made.

    workers: processes, or the address of a Dask scheduler; the table does not depend on them. kept: folder of kept
    runs, shared with other studies; `kept` beside OUT unless given. parquet: write the table as Parquet too. reading:
    instead of that of the file. say: told what differs from the study that OUT held. Runs that are refused, diverge or
    lose their worker are rows with their reason; the last are tried again by the next call. Raises ConfigurationError
    for a bad study, WriteError, and KeyboardInterrupt when stopped: what was finished is kept.
    """
    read = located_study(study, reading=reading)
    target = located(out)
    if parquet:
        parquet_library()  # missing: said before anything is run
    with in_folder(target):
        differences(read, target, say)
        runs = Runs(kept_beside(target) if kept is None else located(kept), workers, progress)
        points = read.points()
        table = Table(read, runs.rows(points), runs.hashes(points), target)
        table.write(target, parquet)
    return table


class in_folder:
    """The name of a folder of results, taken while this lasts. Raises WriteError where another process works in it."""

    def __init__(self, target: Path) -> None:
        if target.is_symlink() or (target.exists() and not target.is_dir()):
            raise WriteError(f"{shown(str(target))} is not a folder; choose another one with --out")
        self._claim = Claim(target)

    def __enter__(self) -> None:
        return None

    def __exit__(self, *_: object) -> None:
        self._claim.release()


def differences(study: Study, target: Path, say: Callable[[str], None] | None = None) -> list[str]:
    """What of a study differs from the one that a folder held, in words; the new one is recorded there.

    Raises WriteError.
    """
    new = described(study)
    try:
        old = json.loads(disk.read_regular(target / RECORD, MOST_RECORD))
        found = list(_differing(old, new)) if isinstance(old, dict) else []
    except FileNotFoundError:
        found = []
    except (OSError, ValueError):
        found = [f"{RECORD} cannot be read and is written anew"]
    try:
        disk.DISK.make_folder(target)
        disk.replace_file(target / RECORD, (json.dumps(new, indent=2) + "\n").encode("utf-8"))
    except OSError as error:
        raise WriteError(f"could not write {shown(str(target / RECORD))}: {error.strerror or error}") from None
    if say is not None:
        for line in found:
            say(f"the study has changed: {line}")
    return found


def described(study: Study) -> dict[str, Any]:
    """A study as plain data."""
    plain = {
        "base": {key: str(value) for key, value in study.base.items()},
        "parameters": {one.name: {k: v for k, v in asdict(one).items() if k != "name"} for one in study.variables},
        "design": asdict(study.design),
        "outputs": dict.fromkeys(study.outputs, True),
        "more": dict(study.more),
        "code": {"version": CODE},
    }
    found: dict[str, Any] = json.loads(json.dumps(plain, default=str))
    return found


def _differing(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    found: list[str] = []
    for part, now in new.items():
        before = old.get(part)
        before = before if isinstance(before, Mapping) else {}
        for key in dict.fromkeys([*before, *now]):
            if key not in now:
                found.append(f"{part}: {key} is gone")
            elif key not in before:
                found.append(f"{part}: {key} is new")
            elif before[key] != now[key]:
                changed = f" ({before[key]} before, {now[key]} now)" if not isinstance(now[key], dict | list) else ""
                found.append(f"{part}: {key} is another{changed}")
    return found
