"""The folder of kept runs: how one is kept and found again, what is in it, and how it is cleaned."""

from __future__ import annotations

import hashlib
import io
import json
import os
import time
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigurationError, WriteError, could_not, shown
from ..storing import disk
from .rows import CODE, Row

CURRENT, STALE, DAMAGED, UNFINISHED = "of this version", "stale", "damaged", "unfinished"
CHOICES = ("stale", "damaged", "all")
OLD = 3600.0
"""Seconds after which a file that is not finished is taken for left behind: none takes as long to write."""


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
            raise could_not(f"keep a run in {shown(str(self.folder))}", error) from None


def _digest(key: str, text: str, arrays: Mapping[str, NDArray[Any]]) -> str:
    """Hash of all that is kept of a run, its key included: a file under another name is not that run."""
    found = hashlib.sha256(f"{key}\n{text}\n".encode())
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name])
        found.update(f"{name} {values.dtype.str} {values.shape}\n".encode("ascii"))
        found.update(values.tobytes())
    return found.hexdigest()


@dataclass(frozen=True)
class Count:
    """How many files, and their bytes."""

    number: int = 0
    bytes: int = 0


def count(folder: Path) -> dict[str, Count]:
    """What is in a folder, by kind: of this version of the code, stale (of another one), damaged, unfinished.

    Raises ConfigurationError where there is no folder.
    """
    found = dict.fromkeys((CURRENT, STALE, DAMAGED, UNFINISHED), Count())
    for kind, _, size in _files(folder):
        found[kind] = Count(found[kind].number + 1, found[kind].bytes + size)
    return found


def clean_up(folder: Path, what: str) -> dict[str, Count]:
    """Remove stale runs, damaged ones, or all, with what was left unfinished an hour ago; what was removed, by kind.

    A study under way makes again what it still needs. Raises ConfigurationError where there is no folder, WriteError.
    """
    wanted = {"stale": (STALE, UNFINISHED), "damaged": (DAMAGED, UNFINISHED)}.get(what, (CURRENT, STALE, DAMAGED))
    removed = dict.fromkeys((*wanted, UNFINISHED), Count())
    for kind, file, size in _files(folder):
        if kind not in removed or (kind == UNFINISHED and time.time() - file.stat().st_mtime < OLD):
            continue
        try:
            disk.DISK.remove(file)
        except OSError as error:
            raise WriteError(f"could not remove {shown(str(file))}: {error.strerror or error}") from None
        removed[kind] = Count(removed[kind].number + 1, removed[kind].bytes + size)
    return removed


def _files(folder: Path) -> list[tuple[str, Path, int]]:
    """Kind, path and bytes of every file of the folder that is a kept run or was to be one."""
    if not folder.is_dir():
        raise ConfigurationError(f"{shown(str(folder))} is no folder of kept runs; give the one that a study wrote")
    store = Store(folder)
    found: list[tuple[str, Path, int]] = []
    for entry in sorted(os.scandir(folder), key=lambda one: one.name):
        if not entry.is_file(follow_symlinks=False) or not entry.name.endswith(".npz"):
            continue
        if entry.name.startswith(disk.UNFINISHED):
            kind = UNFINISHED
        else:
            row = store.load(entry.name.removesuffix(".npz"))
            kind = DAMAGED if row is None else CURRENT if row.summary.get("code") == CODE else STALE
        found.append((kind, Path(entry.path), entry.stat().st_size))
    return found
