"""The processes of the server: one a run, with a thread that hands on what it sends, and those that write files."""

from __future__ import annotations

import multiprocessing
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from ..running.spawning import undisturbed, without_main
from . import exports, worker

PATIENCE = 3.0
"""Seconds that a process is given to end by itself."""

Heard = Callable[[str, Any], None]


class Worker:
    """A process that makes one run.

    heard: called with every word and content that it sends, and with ("gone", None) when it has ended, in a thread of
    its own; may be replaced at any time.
    """

    def __init__(self, heard: Heard) -> None:
        self.heard = heard
        self.idle = False
        # Fresh processes: a forked one would share the state of compiled code and threads.
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=worker.serve, args=(theirs,), daemon=True)
        _begin(self._process)
        theirs.close()
        threading.Thread(target=self._listen, daemon=True).start()

    def tell(self, order: object) -> None:
        """Send an order; one that has ended takes none, and says so by itself."""
        with suppress(OSError):
            self._pipe.send(order)

    def alive(self) -> bool:
        """Whether the process is there."""
        return self._process.is_alive()

    def end(self) -> None:
        """End the process at once, whatever it is at: nothing that it has not sent is wanted."""
        self._process.kill()

    def _listen(self) -> None:
        try:
            while True:
                word, content = self._pipe.recv()
                self.heard(word, content)
        except (EOFError, OSError):
            self._pipe.close()
            self._process.join()
            self.heard("gone", self._process.exitcode)


def write_file(stored: Path, what: str, target: Path, seconds: float) -> str | None:
    """Write a file of `exports.KINDS` from a stored result in a process of its own; why it could not be, or None."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_export, args=(theirs, str(stored), what, str(target)), daemon=True)
    _begin(process)
    theirs.close()
    try:
        if not wait([ours], seconds):
            return (
                f"the {exports.KINDS[what].label} took more than {seconds:g} s and was given up; make the run shorter"
            )
        answer: str | None = ours.recv()
        return answer
    except EOFError:
        return f"the process that made the {exports.KINDS[what].label} ended early, for want of memory perhaps"
    finally:
        ours.close()
        if process.is_alive():
            process.join(PATIENCE)
            process.kill()
        process.join()


def _begin(process: BaseProcess) -> None:
    """Start a process; Ctrl-C, which reaches all of them at once, is for the server alone from the first moment on."""
    resource_tracker.ensure_running()  # starting that one would let signals through again
    with without_main(), undisturbed():
        process.start()


def _export(pipe: Connection, stored: str, what: str, target: str) -> None:
    from ..running.spawning import deaf_to_interrupts, end_with_parent

    deaf_to_interrupts()
    threading.Thread(target=end_with_parent, daemon=True).start()
    worker.stand_back()
    exports.make(pipe, stored, what, target)
