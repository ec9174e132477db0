"""Processes that are not of an executor: started fresh, without the program's own file, and ended with their parent."""

from __future__ import annotations

import multiprocessing
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import wait
from typing import Any

MAIN = "__main__"
_STARTING = threading.Lock()


@contextmanager
def without_main() -> Iterator[None]:
    """While this lasts, processes that are started do not learn from which file this program came."""
    with _STARTING:
        main = vars(sys.modules[MAIN])
        kept: dict[str, Any] = {name: main[name] for name in ("__file__", "__spec__") if name in main}
        main.pop("__file__", None)
        main["__spec__"] = None
        try:
            yield
        finally:
            main.pop("__spec__", None)
            main.update(kept)


def end_with_parent() -> None:
    """End this process when the one that started it has ended; for a thread of its own."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)
