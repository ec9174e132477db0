"""What Ctrl-C and SIGTERM do while a command is carried out; in a run, the Simulation stops between steps."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

STOPPING = (signal.SIGINT, signal.SIGTERM)


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


@contextmanager
def _handled(handler: Callable[[int, FrameType | None], Any], numbers: tuple[signal.Signals, ...]) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may set handlers
        return
    kept = {number: signal.getsignal(number) for number in numbers}
    try:
        for number in numbers:
            signal.signal(number, handler)
        yield
    finally:
        for number, old in kept.items():
            signal.signal(number, signal.SIG_DFL if old is None else old)


@contextmanager
def sigterm_as_interrupt() -> Iterator[None]:
    """SIGTERM raises KeyboardInterrupt, as Ctrl-C does, so that what is half done is cleaned up."""
    with _handled(_interrupt, (signal.SIGTERM,)):
        yield


class Held:
    """Ctrl-C and SIGTERM held back, so that writing is not cut in two; the second one is obeyed at once."""

    def __init__(self) -> None:
        self.asked = False

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """The handler: note the first signal."""
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True

    @contextmanager
    def released(self) -> Iterator[None]:
        """A part, such as drawing, that may be cut short: a signal held back until now is obeyed here."""
        if self.asked:
            raise KeyboardInterrupt
        with _handled(_interrupt, STOPPING):
            yield


@contextmanager
def held_back() -> Iterator[Held]:
    """Hold signals back; afterwards, `asked` says whether one came."""
    held = Held()
    with _handled(held, STOPPING):
        yield held
