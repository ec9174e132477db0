"""Stored runs: a folder is whole or it is not there, and what is read is checked against its hashes.

A run lives in a hidden folder beside its final one, `.tmp-NAME-<16 hexadecimal digits>`. Files are written there and
synchronised, then the manifest, then the folder is renamed and its parent synchronised. Whatever moment a process
dies at, there is the old result, or the new one, or a hidden folder from which `recover` or a resumed run goes on.
"""

from __future__ import annotations

import hashlib
import os
import re
import uuid
from collections.abc import Callable, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ..errors import ConfigurationError, DamagedResult, WriteError, could_not, shown
from . import disk, manifest
from .disk import fcntl
from .locks import PATIENCE, Claim
from .manifest import Entry, Manifest

RESULT_FILE, SUMMARY_FILE, CONFIGURATION_FILE = "result.nc", "summary.json", "config.toml"
LOCK_FILE = "lock"
CHECKPOINTS = ("checkpoint-a.bin", "checkpoint-b.bin")
LAST_STATE = "last-state.bin"
"""Where a finished run stood: a longer one goes on from it. It may be removed to save room."""
RECORDS = ("diverged", "failed")
"""How runs end that may have no numbers, only the record of why."""
LONGEST_NAME = 255 - len(".tmp--0123456789abcdef")
"""Bytes of the name of a result's folder: a hidden one beside it has a longer name."""


# --- reading --------------------------------------------------------------------------------------


def read_manifest(folder: Path) -> Manifest | None:
    """The manifest of a stored run, its files not yet looked at; None if there is none.

    Raises DamagedResult if it is there and is not whole.
    """
    try:
        return manifest.decode(disk.read_regular(folder / manifest.FILE, manifest.LARGEST))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:
        raise damaged(folder, f"{manifest.FILE}: {_reason(error)}") from None


def read_file(folder: Path, name: str, entry: Entry) -> bytes:
    """The content of a file of a stored run, if it agrees with its entry. Raises DamagedResult otherwise."""
    try:
        content = disk.read_regular(folder / name, entry.size)
    except OSError as error:
        raise damaged(folder, f"{name}: {_reason(error)}") from None
    if len(content) != entry.size:
        raise damaged(folder, f"{name} has {len(content)} bytes, and {manifest.FILE} says {entry.size}")
    if hashlib.sha256(content).hexdigest() != entry.sha256:
        raise damaged(folder, f"{name} was changed: its hash is not that of {manifest.FILE}")
    return content


def verify(folder: Path) -> Manifest:
    """The manifest of a stored run after every file agreed with it.

    Raises DamagedResult if one does not, ConfigurationError if there is no manifest.
    """
    found = read_manifest(folder)
    if found is None:
        raise ConfigurationError(
            f"{shown(str(folder))} has no {manifest.FILE}: it is no result, or one of an older version that cannot "
            "be verified; run it again"
        )
    for name, entry in found.files.items():
        read_file(folder, name, entry)
    for name in (SUMMARY_FILE, CONFIGURATION_FILE):
        if name not in found.files:
            raise damaged(folder, f"{manifest.FILE} does not list {name}")
    return found


def damaged(folder: Path, why: str) -> DamagedResult:
    """The error of a stored run that does not agree with its manifest."""
    return DamagedResult(
        f"{shown(str(folder))} is not a whole result of peristalsis ({why}); run it again, or move it aside with "
        f"peristalsis check {shown(str(folder))} --quarantine"
    )


def _reason(error: OSError | ValueError) -> str:
    said = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return " ".join(said.split())[:120]


def quarantine(folder: Path) -> Path:
    """Move a damaged result aside, under NAME.damaged-TIME, and return where to; nothing is deleted. OSError."""
    aside = _beside_as(folder, "damaged")
    disk.DISK.rename(_named(folder), aside)
    disk.DISK.synchronise(aside.parent)
    return aside


def _beside_as(folder: Path, why: str) -> Path:
    """A new name beside a folder that says why it is there."""
    moment = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    named = _named(folder)
    return named.with_name(f"{named.name[:180]}.{why}-{moment}-{uuid.uuid4().hex[:8]}")


def _named(folder: Path) -> Path:
    """The same folder by a path that ends in its own name, which "." and ".." do not."""
    return folder if folder.name not in ("", "..") else folder.resolve()


# --- places ---------------------------------------------------------------------------------------


def check_target(target: Path, overwrite: bool) -> None:
    """Refuse, before anything is computed, a folder that exists or cannot be made. Raises WriteError."""
    disk.require_locks()
    try:
        _check_target(target, overwrite)
    except (OSError, ValueError) as error:
        raise WriteError(f"{shown(str(target))}: {_reason(error)}; choose another folder with --out") from None


def _check_target(target: Path, overwrite: bool) -> None:
    if target.is_symlink():
        raise WriteError(
            f"{shown(str(target))} is a symbolic link, which is neither followed nor replaced; name its target with "
            "--out"
        )
    if not target.name or "\0" in target.name or len(os.fsencode(target.name)) > LONGEST_NAME:
        raise WriteError(
            f"{shown(str(target))}: a folder cannot have this name, or not with the hidden one beside it: at most "
            f"{LONGEST_NAME} bytes; choose another one with --out"
        )
    if target.exists() and not overwrite:
        raise WriteError(f"{shown(str(target))} exists; choose another folder with --out, or say --overwrite")
    if target.exists() and not target.is_dir():
        raise WriteError(f"{shown(str(target))} is a file, not a folder; choose another one with --out")
    if target.is_dir() and any(target.iterdir()) and not (target / SUMMARY_FILE).exists():
        raise WriteError(
            f"{shown(str(target))} holds files but no result of peristalsis, so it is not overwritten; choose another"
        )
    parent = target.parent
    while not parent.exists() and parent != parent.parent:
        parent = parent.parent
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise WriteError(f"{shown(str(parent))} is not a folder that can be written to; choose another one with --out")


def unfinished(target: Path) -> list[Path]:
    """Hidden folders beside a target in which runs of its name were left, in the order of their names."""
    return _beside(target, "tmp")


def _beside(target: Path, kind: str) -> list[Path]:
    pattern = re.compile(rf"\.{kind}-{re.escape(target.name)}-[0-9a-f]{{16}}")
    try:
        names = sorted(name for name in os.listdir(target.parent) if pattern.fullmatch(name))
    except OSError:
        return []
    folders = [target.parent / name for name in names]
    return [folder for folder in folders if folder.is_dir() and not folder.is_symlink()]


def _hidden(target: Path, kind: str) -> Path:
    return target.parent / f".{kind}-{target.name}-{uuid.uuid4().hex[:16]}"


def recover(target: Path) -> None:
    """Finish what a crash cut short between two renames: a whole result in a hidden folder gets its name.

    Without one, an old result that was being replaced gets its name back. Nothing is done where a result stands.
    Raises WriteError.
    """
    if _stands(target) or not (unfinished(target) or _beside(target, "old")):
        return
    try:
        putting = Claim(target, kind="put", patience=PATIENCE)  # who is between the two renames is let finish
    except WriteError:
        return
    try:
        if not _stands(target):
            _recover(target)
    finally:
        putting.release()


def _stands(target: Path) -> bool:
    return target.exists() or target.is_symlink()


def _recover(target: Path) -> None:
    for folder in unfinished(target):
        workspace = Workspace(target, folder)
        try:
            workspace.open()
            verify(folder)
        except ConfigurationError:
            workspace.close()
            continue
        except WriteError:
            continue
        workspace.place()
        return
    for old in _beside(target, "old"):
        with suppress(ConfigurationError):
            verify(old)
            _written(target, lambda old=old: disk.DISK.rename(old, target))  # type: ignore[misc]
            return


# --- writing --------------------------------------------------------------------------------------


class Workspace:
    """The hidden folder in which a run lives until it is whole. It is made, and locked, at its first use.

    target: the folder of the result. folder: one that was left by an earlier process, to go on in. claim: the name of
    the target, if it is taken already; it is given up with the folder.
    """

    def __init__(self, target: Path, folder: Path | None = None, claim: Claim | None = None) -> None:
        self.target = target
        self.folder = _hidden(target, "tmp") if folder is None else folder
        self._claim = claim
        self._lock: int | None = None
        self._parents = [target.parent] if claim is None else claim.parents
        """Folders whose new names must survive, the nearest first: the parent, and above it those not made yet."""

    def take_over(self, claim: Claim) -> None:
        """Hold the name of the target, which was taken before, until the folder is closed."""
        self._claim = claim

    def open(self) -> Path:
        """The folder, made and locked. Raises WriteError, also when another process works in it."""
        if self._lock is not None:
            return self.folder
        while not self._parents[-1].exists():
            self._parents.append(self._parents[-1].parent)
        _written(self.target, lambda: disk.DISK.make_folder(self.folder))
        try:
            flags = os.O_RDWR | os.O_CREAT | disk.NO_FOLLOW | disk.CLOSE_AT_START
            self._lock = os.open(self.folder / LOCK_FILE, flags, 0o666)
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.close()
            raise WriteError(
                f"{shown(str(self.folder))} is being worked in by another process; wait for it, or choose another "
                "folder with --out"
            ) from None
        except OSError as error:
            self.close()
            raise _write_error(self.target, error) from None
        return self.folder

    def has_checkpoints(self) -> bool:
        """Whether a run could go on from here."""
        return any((self.folder / name).is_file() for name in CHECKPOINTS)

    def close(self) -> None:
        """Give up the locks and leave the folder as it is, for a later process to go on in."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None
        if self._claim is not None:
            self._claim.release()
            self._claim = None

    def discard(self) -> None:
        """Remove the folder; what cannot be removed is left."""
        with suppress(OSError):
            if self.folder.exists():
                disk.DISK.remove_folder(self.folder)
        self.close()

    def write(self, name: str, content: bytes) -> None:
        """Put a file into the folder, whole or not at all, and safe from a power failure. Raises WriteError."""
        folder = self.open()
        _written(self.target, lambda: disk.replace_file(folder / name, content))

    def publish(
        self,
        files: Mapping[str, bytes],
        status: str,
        about: Mapping[str, Any],
        extras: Callable[[Path], None] | None = None,
        keep_checkpoints: bool = False,
        overwrite: bool = True,
    ) -> Path:
        """Write the files of a finished run, its manifest last, and put the folder in place of the target.

        extras: called with the folder to add what can be made again from the files, such as pictures; it is not in
        the manifest. overwrite: whether a result that stands there by then is replaced. Raises WriteError; the folder
        stays then, and the old target with it.
        """
        folder = self.open()

        def fill() -> None:
            for name, content in files.items():
                disk.DISK.write(folder / name, content)
            if extras is not None:
                extras(folder)
            for path in sorted(folder.rglob("*")):
                if path.name.startswith(disk.UNFINISHED):  # of a process that was killed while it wrote
                    disk.DISK.remove(path)
                elif path.is_file() and not path.is_symlink():
                    disk.DISK.synchronise(path)
            disk.DISK.synchronise(folder)
            listed = {name: Entry.of(content) for name, content in files.items()}
            disk.replace_file(folder / manifest.FILE, Manifest(status, listed, about).encode())
            if not keep_checkpoints:
                for name in CHECKPOINTS:
                    disk.DISK.remove(folder / name)

        _written(self.target, fill)
        return self.put_in_place(overwrite)

    def put_in_place(self, overwrite: bool = True) -> Path:
        """Give the finished folder its name; an old result is moved aside first and removed last.

        What may not be replaced stands, whoever was first: the folder then gets a name of its own beside it, which the
        WriteError says.
        """
        putting = Claim(self.target, kind="put", patience=PATIENCE)
        try:
            try:
                check_target(self.target, overwrite)
            except WriteError:
                raise self._kept_apart() from None
            try:
                return self.place(overwrite)
            except WriteError:
                if overwrite or not _stands(self.target):
                    raise
                raise self._kept_apart() from None
        finally:
            putting.release()

    def place(self, overwrite: bool = True) -> Path:
        """`put_in_place` for who has seen to it that nobody else does the same. Raises OSError where it may not."""
        old = _hidden(self.target, "old")

        def rename() -> None:
            disk.DISK.remove(self.folder / LOCK_FILE)
            replaced = overwrite and self.target.exists()
            if replaced:
                disk.DISK.rename(self.target, old)
            try:
                disk.DISK.rename(self.folder, self.target)  # the system refuses to replace a folder that holds files
            except OSError:
                if replaced:
                    disk.DISK.rename(old, self.target)
                raise
            for parent in self._parents:
                disk.DISK.synchronise(parent)

        _written(self.target, rename)
        for left in _beside(self.target, "old"):
            with suppress(OSError):  # the new result stands; what cannot be removed is only in the way
                disk.DISK.remove_folder(left)
        self.close()
        return self.target

    def _kept_apart(self) -> WriteError:
        """Nothing that was computed is lost: the finished folder gets another name."""
        apart = _beside_as(self.target, "kept")

        def rename() -> None:
            disk.DISK.remove(self.folder / LOCK_FILE)
            disk.DISK.rename(self.folder, apart)
            disk.DISK.synchronise(apart.parent)

        _written(self.target, rename)
        self.close()
        return WriteError(
            f"{shown(str(self.target))} was written by somebody else in the meantime and is not replaced; this result "
            f"is kept in {shown(str(apart), 200)}: rename it, or choose another folder with --out"
        )


def _written(target: Path, action: Callable[[], None]) -> None:
    try:
        action()
    except OSError as error:
        raise _write_error(target, error) from None


def _write_error(target: Path, error: OSError) -> WriteError:
    return could_not(f"write {shown(str(target))}", error)
