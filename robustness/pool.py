"""Cases in processes that may die, hang or take too long: every one becomes a row."""

from __future__ import annotations

import multiprocessing
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from typing import Any

from .execution import Row, carry_out, of_case, second_opinion
from .plan import Case

Serve = Callable[[Connection, float, bool], None]

SILENCE = 4.0
"""Times the limit of a run, on the clock, after which a process that says nothing is ended."""
START = 600.0
"""Seconds on the clock that a process may take to begin: its kernels may be compiled first."""


class _Worker:
    def __init__(self, serve: Serve, limit: float, opinions: bool) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=serve, args=(theirs, limit, opinions), daemon=True)
        self.process.start()
        theirs.close()
        self.case: Case | None = None
        self.row: Row | None = None
        self.reached = 0.0
        self.heard = time.monotonic()
        self.ready = False

    def give(self, case: Case) -> None:
        self.case, self.row, self.reached, self.heard = case, None, 0.0, time.monotonic()
        with suppress(OSError):  # it died: seen where answers are taken
            self.pipe.send(case)

    def patience(self, limit: float) -> float:
        """Seconds of silence after which it is given up."""
        return SILENCE * limit if self.ready else START

    def end(self) -> None:
        self.pipe.close()
        self.process.kill()
        self.process.join()


def rows(
    cases: list[Case],
    workers: int,
    limit: float,
    opinions: bool = True,
    late: Callable[[], bool] = lambda: False,
    serve: Serve | None = None,
) -> Iterator[Row]:
    """The row of every case, in the order in which they are finished; none is begun once it is late."""
    queue = list(reversed(cases))
    staff: list[_Worker] = []
    try:
        while queue or any(one.case is not None for one in staff):
            if late():
                queue.clear()
            while queue and len(staff) < workers:
                staff.append(_Worker(serve or _serve, limit, opinions))
            for one in staff:
                if one.case is None and queue:
                    one.give(queue.pop())
            busy = {one.pipe: one for one in staff if one.case is not None}
            for pipe in wait(list(busy), timeout=1.0):
                one = busy[pipe]  # type: ignore[index]
                row = _hear(one)
                if row is not None:
                    yield row
                if not one.process.is_alive() and one.case is None:
                    staff.remove(one)
            for one in list(staff):
                silent = time.monotonic() - one.heard
                if one.case is not None and silent > one.patience(limit):
                    row = one.row or _lost(one, "too_slow", f"no step for {silent:.0f} s at t = {one.reached:.4g} s")
                    one.end()
                    staff.remove(one)
                    yield row
    finally:
        for one in staff:
            one.end()


def _hear(one: _Worker) -> Row | None:
    """What a process says; a row when its case is done or the process is dead."""
    try:
        kind, content = one.pipe.recv()
    except (EOFError, OSError):
        one.process.join()
        row = one.row or _lost(one, "traceback", f"the process ended with exit code {one.process.exitcode}")
        one.case = None
        return row
    one.heard, one.ready = time.monotonic(), True
    if kind == "at":
        one.reached = content
    elif kind == "row":
        one.row = content
    elif kind == "done":
        one.case = None
        return {**(one.row or {}), "other_ways": content}
    return None


def _lost(one: _Worker, outcome: str, words: str) -> Row:
    case = one.case
    assert case is not None
    return {
        **of_case(case),
        "outcome": outcome,
        "stage": "run" if one.reached > 0.0 else "start",
        "words": words,
        "simulated_s": one.reached,
    }


def _serve(pipe: Connection, limit: float, opinions: bool) -> None:
    pipe.send(("ready", None))
    threading.Thread(target=_end_with_parent, daemon=True).start()
    told = [0.0]

    def tell(simulated: float) -> None:
        if time.monotonic() - told[0] > 1.0:
            told[0] = time.monotonic()
            pipe.send(("at", simulated))

    while True:
        try:
            case: Any = pipe.recv()
        except EOFError:
            return
        row = carry_out(case, limit, tell)
        pipe.send(("row", row))
        pipe.send(("done", second_opinion(case, row, limit, tell) if opinions else {}))


def _end_with_parent() -> None:
    import os

    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)
