"""Names that are taken: one process at a time makes a result, and others are refused before they compute.

A lock is a hidden file beside its place, `.lock-NAME`, held by the system: it ends with its process, however that
ends. Nothing rests on it alone: what is put in place is put there by a rename that refuses to replace.
"""

from __future__ import annotations

import os
import time
from contextlib import suppress
from pathlib import Path

from ..errors import WriteError, could_not, shown
from .disk import CLOSE_AT_START, NO_FOLLOW, fcntl, require_locks

PATIENCE = 10.0
"""Seconds that are waited for another process to put something in place, or for one that is being stopped to end."""
_PAUSE = 0.02


class Claim:
    """The name of a folder or file, taken until `release`.

    alone: False lets others in that say the same, such as runs that may all overwrite. patience: seconds to wait for
    the name. kind: names of different kinds do not hinder one another. Raises WriteError where another process has the
    name, or where no lock can be had.
    """

    def __init__(self, target: Path, alone: bool = True, patience: float = 0.0, kind: str = "lock") -> None:
        require_locks()
        self.path = target.parent / f".{kind}-{target.name}"
        self.parents = [target.parent]
        """Folders whose new names must survive, the nearest first: the parent, and above it those not made yet."""
        while not self.parents[-1].exists():
            self.parents.append(self.parents[-1].parent)
        self._alone = alone
        self._descriptor: int | None = None
        self._unmade: OSError | None = None
        """Why the lock could not be made at the last try, where its folder had gone or cannot have it."""
        last = time.monotonic() + patience
        try:
            while not self._taken():
                if time.monotonic() >= last:
                    if self._unmade is not None:
                        raise self._unmade
                    raise WriteError(
                        f"{shown(str(target))} is being worked in by another process; wait for it, or choose another "
                        "place with --out"
                    )
                time.sleep(_PAUSE)
        except OSError as error:
            self.release()
            raise could_not(f"write {shown(str(target))}", error, "another place with --out") from None
        except BaseException:
            self.release()
            raise

    def _taken(self) -> bool:
        """Whether the lock is ours now."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        try:
            descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT | NO_FOLLOW | CLOSE_AT_START, 0o666)
        except FileNotFoundError as error:  # who had made the folder has just removed it, or it takes no files
            self._unmade = error
            return False
        self._unmade = None
        kept = False
        try:
            fcntl.flock(descriptor, (fcntl.LOCK_EX if self._alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
            # Who had the name removes the file when it is done: a lock on a file without a name is worth nothing.
            kept = _has_name(self.path, descriptor)
        except BlockingIOError:
            return False
        finally:
            if not kept:
                os.close(descriptor)
        self._descriptor = descriptor if kept else None
        return kept

    def release(self) -> None:
        """Give the name up, and remove what was made for the lock alone; a second time does nothing."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            with suppress(OSError):  # of several that let one another in, the last one removes the file
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                os.unlink(self.path)
            os.close(descriptor)
        for parent in self.parents[:-1]:
            try:
                parent.rmdir()  # only where it is empty
            except OSError:
                break


def _has_name(path: Path, descriptor: int) -> bool:
    try:
        named, opened = os.stat(path, follow_symlinks=False), os.fstat(descriptor)
    except FileNotFoundError:
        return False
    return (named.st_dev, named.st_ino) == (opened.st_dev, opened.st_ino)
