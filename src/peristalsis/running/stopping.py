"""How a run is stopped from outside, and what to set for one that does not stop."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_WAYS_ON = (
    ("expelled", "set run.stop_when_expelled = false beforehand for one that does"),
    ("the pellet has reached", "set run.stop_position farther on beforehand for one that does"),
    ("the pellet has come to rest", "set run.stop_when_arrested = false beforehand for one that does"),
)


def way_on(reason: str) -> str:
    """What to set for a run that is not stopped for this reason."""
    ways = [way for begins, way in _WAYS_ON if reason.startswith(begins)]
    return ways[0] if ways else "an observer stopped it; take it out for one that does"


@contextmanager
def stop_at_signals() -> Iterator[Callable[[], bool]]:
    """Turn Ctrl-C and SIGTERM into a stop between two steps; outside the main thread, leave signals alone."""
    asked: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return

    def note(number: int, frame: object) -> None:
        asked.append(number)

    kept = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: bool(asked)
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)
