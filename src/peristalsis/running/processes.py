"""An executor of processes of this machine, each by itself, so that one that dies takes nothing along.

loky starts them, feeds them and finds out that one has died. A pool of several breaks as a whole when one of them does,
and does not tell which piece of work it was at; so each process here is a loky executor of its own.
"""

from __future__ import annotations

import os
import re
import signal
import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, Future, wait
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

from .. import plugins
from ..errors import InterruptedRun
from .spawning import deaf_to_interrupts, undisturbed

PATIENCE = 5.0
"""Seconds that work is given to come to an end in order when all is stopped."""
_LOOK = 1.0
"""Seconds between two looks of a process at whether the one that started it lives."""
_CODES = re.compile(r"(SIG[A-Z0-9]+|EXIT|UNKNOWN)\((-?\d+)\)")

_at_work = threading.Event()
"""Whether this process is carrying something out for another one."""


class Processes(Executor):
    """So many processes, started when they are first needed.

    They end with the one that started them, however that ends. What is submitted waits for the process with the least
    to do. If a process dies, what it was at raises BrokenExecutor, and the next piece starts another process.
    """

    def __init__(self, workers: int) -> None:
        self._lanes = [_Lane() for _ in range(workers)]

    def submit(self, work: Callable[..., Any], /, *args: Any, **named: Any) -> Future[Any]:
        """Have a process do `work(*args, **named)`; functions of a program that is no module are sent whole."""
        return min(self._lanes, key=_Lane.waiting).submit(work, args, named)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End all processes; with `cancel_futures`, work under way is stopped as by SIGTERM, then ended."""
        if cancel_futures:
            for lane in self._lanes:
                lane.hang_up()
            deadline = time.monotonic() + PATIENCE
            for lane in self._lanes:
                lane.settle(max(deadline - time.monotonic(), 0.0))
        for lane in self._lanes:
            lane.close(wait)


class _Lane:
    """One process at a time, and the line that tells it to stop when it goes dead."""

    def __init__(self) -> None:
        self._executor: Any = None
        self._line: Connection | None = None
        self._futures: list[Future[Any]] = []

    def waiting(self) -> int:
        """Pieces of work that are not done."""
        self._futures = [one for one in self._futures if not one.done()]
        return len(self._futures)

    def submit(self, work: Callable[..., Any], args: Iterable[Any], named: dict[str, Any]) -> Future[Any]:
        from concurrent.futures import BrokenExecutor

        for _ in range(2):  # it may have died while it had nothing to do
            _start_trackers()
            try:
                with undisturbed():  # cut in two, loky's start can neither go on nor be undone
                    if self._executor is None:
                        self._start()
                    future: Future[Any] = self._executor.submit(_carry_out, work, tuple(args), named)
                    self._futures.append(future)
            except BrokenExecutor:
                self.close(wait=False)
                continue
            return future
        raise BrokenExecutor("a process that was started ended at once")

    def _start(self) -> None:
        from loky.backend import get_context
        from loky.process_executor import ProcessPoolExecutor

        theirs, self._line = Pipe(duplex=False)
        # A context that does not read the program again: a script needs no guard, and may come from standard input.
        self._executor = ProcessPoolExecutor(
            max_workers=1, context=get_context("loky"), initializer=_begin, initargs=(theirs, os.getpid())
        )

    def hang_up(self) -> None:
        """Tell the process to stop what it is at."""
        line, self._line = self._line, None
        if line is not None:
            line.close()

    def settle(self, seconds: float) -> None:
        """Wait for what the process is at."""
        wait(self._futures, timeout=seconds)

    def close(self, wait: bool) -> None:
        """End the process, also one that is at something."""
        executor, self._executor = self._executor, None
        if executor is not None:
            executor.shutdown(wait=wait, kill_workers=self.waiting() > 0)
        self._futures.clear()
        self.hang_up()


def _start_trackers() -> None:
    """Have the processes that tidy up after loky and Python: starting one of them lets held signals through."""
    from multiprocessing import resource_tracker

    from loky.backend import resource_tracker as of_loky

    resource_tracker.ensure_running()
    of_loky.ensure_running()


def death(error: BaseException) -> str:
    """How a process died, in words, from what loky says of it."""
    found = _CODES.search(str(error))
    name, code = found.groups() if found else ("UNKNOWN", "0")
    if name == "EXIT":
        return f"its process ended by itself with exit code {code}"
    if name == "UNKNOWN":
        return "its process died"
    return f"its process was ended by {name}{', for want of memory perhaps' if name == 'SIGKILL' else ''}"


def _begin(line: Connection, parent: int) -> None:
    """What a process does first."""
    signal.signal(signal.SIGTERM, _stop)
    deaf_to_interrupts()  # the one who started it decides what Ctrl-C means
    threading.Thread(target=_watch, args=(line, parent), daemon=True).start()
    plugins.ready()


def _carry_out(work: Callable[..., Any], args: tuple[Any, ...], named: dict[str, Any]) -> Any:
    _at_work.set()
    try:
        return work(*args, **named)
    finally:
        _at_work.clear()


def _stop(number: int, frame: object) -> None:
    """Stop what is under way; a run takes the signal itself and stops between two steps."""
    if _at_work.is_set():
        raise InterruptedRun("stopped")


def _watch(line: Connection, parent: int) -> None:
    """Stop when the line goes dead; end at once with the parent: what was written stands, its locks are free."""
    with suppress(EOFError, OSError):
        while not line.poll(_LOOK):
            _end_without(parent)
        line.recv()
    _end_without(parent)
    os.kill(os.getpid(), signal.SIGTERM)
    while True:
        time.sleep(0.05)
        _end_without(parent)


def _end_without(parent: int) -> None:
    if os.getppid() != parent:
        os._exit(1)
