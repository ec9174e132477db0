"""The one door to the disk for what must not be lost: every write of a result, a checkpoint or a kept run.

`DISK` carries each operation out; a test puts in its place one that fails, is killed or loses what was not yet
synchronised. Operations are the system's own, so that "written" and "safe from a power failure" stay two things.
"""

from __future__ import annotations

import errno
import os
import stat
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..errors import WriteError

fcntl: Any
try:
    import fcntl
except ImportError:  # no POSIX system: runs that write nothing need none of it
    fcntl = None

_FULL_SYNC: int | None = getattr(fcntl, "F_FULLFSYNC", None)
"""Where fsync leaves data in the drive's own memory (macOS), the order that does not."""
NO_FOLLOW: int = getattr(os, "O_NOFOLLOW", 0)
CLOSE_AT_START: int = getattr(os, "O_CLOEXEC", 0)
_NO_WAITING: int = getattr(os, "O_NONBLOCK", 0)
_AS_BYTES: int = getattr(os, "O_BINARY", 0)
"""Flags of a file to be opened; 0 on systems that have no such flag."""


def require_locks() -> None:
    """Raise WriteError where results cannot be kept: nothing would tell two processes in one folder apart."""
    if fcntl is None:
        raise WriteError(
            "this system has no POSIX file locks (Python's module fcntl), without which results cannot be kept safely; "
            "use Linux, macOS or WSL, or run from Python without a folder"
        )


class Disk:
    """Operations on files and folders; all raise OSError as the system does, or WriteError if it has no locks."""

    def make_folder(self, path: Path) -> None:
        """Make a folder and its parents, unless it is there."""
        require_locks()
        path.mkdir(parents=True, exist_ok=True)

    def write(self, path: Path, content: bytes) -> None:
        """Write a whole file, over an old one of this name if there is one; a symbolic link is not followed."""
        require_locks()
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | NO_FOLLOW | CLOSE_AT_START, 0o666)
        try:
            view = memoryview(content)
            while view:
                view = view[self.put(descriptor, view) :]
        finally:
            os.close(descriptor)

    def put(self, descriptor: int, content: memoryview) -> int:
        """Write as much as the system takes at once; the number of bytes."""
        return os.write(descriptor, content)

    def synchronise(self, path: Path) -> None:
        """Return when a file, or the names in a folder, would survive a power failure."""
        descriptor = os.open(path, os.O_RDONLY | CLOSE_AT_START)
        try:
            if _FULL_SYNC is not None:  # pragma: no cover (macOS)
                fcntl.fcntl(descriptor, _FULL_SYNC)
            os.fsync(descriptor)
        except OSError as error:
            if error.errno != errno.EINVAL:  # a file system that cannot synchronise folders orders them itself
                raise
        finally:
            os.close(descriptor)

    def rename(self, old: Path, new: Path) -> None:
        """Give a file or folder its name, at once; a file replaces one that has it."""
        os.replace(old, new)

    def remove(self, path: Path) -> None:
        """Remove a file or a symbolic link, if it is there."""
        path.unlink(missing_ok=True)

    def remove_folder(self, path: Path) -> None:
        """Remove a folder with all that is in it; links in it are removed, not followed."""
        if path.is_symlink() or not path.is_dir():
            self.remove(path)
            return
        for inner in sorted(path.iterdir()):
            self.remove_folder(inner)
        path.rmdir()


DISK = Disk()

UNFINISHED = ".new-"
"""How the names of files begin that are being written."""


def replace_file(path: Path, content: bytes, mark: str = "") -> None:
    """Put a file in place whole: the old content or the new one is there at any time, and after a crash.

    mark: tells writers apart, where several may write the same file.
    """
    fresh = path.with_name(f"{UNFINISHED}{mark}{path.name}")
    try:
        DISK.write(fresh, content)
        DISK.synchronise(fresh)
        DISK.rename(fresh, path)
    except OSError:  # the part that was written must not stay and fill the disk
        with suppress(OSError):
            DISK.remove(fresh)
        raise
    DISK.synchronise(path.parent)


def read_regular(path: Path, most: int, follow: bool = False) -> bytes:
    """The content of a regular file of at most `most` bytes; OSError for anything else: pipes, devices, folders.

    follow: whether a symbolic link to one will do. A pipe that nobody writes to is not waited for.
    """
    link = 0 if follow else NO_FOLLOW
    descriptor = os.open(path, os.O_RDONLY | link | _NO_WAITING | CLOSE_AT_START | _AS_BYTES)
    with os.fdopen(descriptor, "rb") as file:
        about = os.fstat(descriptor)
        if stat.S_ISDIR(about.st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        if not stat.S_ISREG(about.st_mode):
            raise OSError(errno.EINVAL, "it is not a regular file")
        if about.st_size > most:
            raise OSError(errno.EFBIG, f"it has {about.st_size} bytes, more than {most}")
        return file.read(about.st_size + 1)
