"""A disk that fails: at its n-th operation, in one of the ways in which disks and processes fail."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from peristalsis.storing.disk import Disk

FAULTS = ("ENOSPC", "EIO", "EINTR", "short", "kill", "torn", "power")


class Killed(BaseException):
    """The process is gone: nothing of it runs any more, so every later operation raises this as well."""


class FaultyDisk(Disk):
    """Fails at operation number `at` (from 0).

    ENOSPC, EIO, EINTR: the operation raises, once. short: a write takes one byte, and the next one goes on. kill: the
    process dies before the operation. torn: it dies in it, half of a write done. power: it dies and the machine with
    it: what was not synchronised is lost, contents and names.
    """

    def __init__(self, at: int, fault: str) -> None:
        self.at = at
        self.fault = fault
        self.count = 0
        self.dead = False
        self._unsafe: set[Path] = set()  # written, not synchronised
        self._renamed: list[tuple[Path, Path, Path | None]] = []  # old name, new name, what stood there before

    @property
    def reached(self) -> bool:
        """Whether there were enough operations for the fault."""
        return self.count > self.at

    def _operation(self) -> bool:
        """Count; True where this operation is to be done in half."""
        if self.dead:
            raise Killed
        number, self.count = self.count, self.count + 1
        if number != self.at or self.fault == "short":
            return False
        if self.fault in ("ENOSPC", "EIO", "EINTR"):
            code = getattr(errno, self.fault)
            raise OSError(code, os.strerror(code))
        if self.fault == "torn":
            return True
        self._die()
        raise Killed

    def _die(self) -> None:
        self.dead = True
        if self.fault == "power":
            for old, new, before in reversed(self._renamed):
                if new.exists():
                    os.replace(new, old)
                if before is not None and before.exists():
                    os.replace(before, new)
            for path in self._unsafe:
                if path.is_file():
                    os.truncate(path, path.stat().st_size // 2)

    def make_folder(self, path: Path) -> None:
        self._operation()
        super().make_folder(path)

    def write(self, path: Path, content: bytes) -> None:
        self._unsafe.add(path)
        super().write(path, content)

    def put(self, descriptor: int, content: memoryview) -> int:
        half = self._operation()
        if half:
            super().put(descriptor, content[: len(content) // 2])
            self._die()
            raise Killed
        if self.fault == "short" and self.count - 1 == self.at:
            return super().put(descriptor, content[:1])
        return super().put(descriptor, content)

    def synchronise(self, path: Path) -> None:
        self._operation()
        super().synchronise(path)
        self._unsafe.discard(path)
        self._renamed = [entry for entry in self._renamed if entry[1].parent != path]

    def rename(self, old: Path, new: Path) -> None:
        self._operation()
        before = None
        if self.fault == "power" and new.is_file():
            before = new.with_name(f"{new.name}.before-power")
            os.link(new, before)
        super().rename(old, new)
        self._renamed.append((old, new, before))
        self._unsafe = {new if path == old else path for path in self._unsafe}

    def remove(self, path: Path) -> None:
        self._operation()
        super().remove(path)

    def remove_folder(self, path: Path) -> None:
        self._operation()
        super().remove_folder(path)
