"""Files that appear whole or not at all: written beside their place, and renamed when they are done."""

from __future__ import annotations

import os
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import could_not, shown


@contextmanager
def whole(target: Path) -> Iterator[Path]:
    """A path beside `target`, of the same ending, that takes its place unless something is raised meanwhile."""
    temporary = target.parent / f".tmp-{uuid.uuid4().hex[:8]}{target.suffix}"
    try:
        yield temporary
        os.replace(temporary, target)
    finally:
        with suppress(OSError):  # it is in its place, or there is no folder for it to be in
            temporary.unlink()


@contextmanager
def whole_in_folder(target: Path) -> Iterator[Path]:
    """`whole` where a user asked for it: the folder is made, and WriteError says why it cannot be written."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with whole(target) as temporary:
            yield temporary
    except OSError as error:
        raise could_not(f"write {shown(str(target))}", error, "another place") from None
