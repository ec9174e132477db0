"""How processes begin and end: without the program's own file, undisturbed by Ctrl-C, ended with their parent."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import wait
from typing import Any

MAIN = "__main__"
HELD = (signal.SIGINT, signal.SIGTERM)
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


@contextmanager
def undisturbed() -> Iterator[None]:
    """Hold Ctrl-C and SIGTERM back while a process is started: neither the start is cut in two, nor what it starts.

    A process that is started meanwhile holds them back too, until it calls `deaf_to_interrupts`; threads do for good.
    Another thread of this process may still be given one; its handler, which runs in the main thread, then waits.
    """
    came: list[int] = []
    handlers = {}
    kept = signal.pthread_sigmask(signal.SIG_BLOCK, HELD)
    try:
        if threading.current_thread() is threading.main_thread():
            for one in HELD:
                if callable(signal.getsignal(one)):  # what is ignored stays so, also in what is started
                    handlers[one] = signal.signal(one, lambda number, frame: came.append(number))
        yield
    finally:
        for one, handler in handlers.items():
            signal.signal(one, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, kept)
        for number in came:
            signal.raise_signal(number)


def deaf_to_interrupts() -> None:
    """Leave Ctrl-C, which a terminal sends to all processes, to the one that started this; SIGTERM counts from now."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, HELD)


def end_with_parent() -> None:
    """End this process when the one that started it has ended; for a thread of its own."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)
