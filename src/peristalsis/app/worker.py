"""The process that one run is in: it computes, sends frames, and listens between them.

It is started before it is wanted, so that its kernels are loaded when a page asks for a run. What it sends are pairs
of a word and its content; what it takes are the messages of `Orders`.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from ..errors import DivergenceError, InterruptedRun, PeristalsisError

PIECE = 0.02
"""Simulated time between frames [s]: fifty a second, and orders are heard as often."""
NICE = 5
"""How far a run stands back behind the browser that shows it."""


@dataclass(frozen=True)
class Start:
    """The run to make, as TOML, and the folder that its result may be stored in."""

    toml: str
    folder: str


@dataclass(frozen=True)
class Change:
    """Parameters to change from now on, and the number by which the page knows that they have been."""

    changes: Mapping[str, Any]
    number: int


@dataclass(frozen=True)
class Save:
    """Store the result so far in a folder of this name."""

    name: str


RESULT = "result"
"""Name of the folder of a run that is over; it is whole when its process has ended."""
PAUSE, RESUME, STEP, STOP = "pause", "resume", "step", "stop"


def serve(pipe: Connection) -> None:
    """What the process does: get ready, wait for a run, make it, end."""
    from ..running.spawning import deaf_to_interrupts, end_with_parent

    deaf_to_interrupts()  # Ctrl-C is for the server, which ends its runs
    threading.Thread(target=end_with_parent, daemon=True).start()
    stand_back()
    with suppress(EOFError, OSError):  # the server has gone
        try:
            _get_ready(pipe)
            order = pipe.recv()
            if isinstance(order, Start):
                _Run(pipe, order).make()
        except PeristalsisError as error:
            pipe.send(("failed", str(error)))
        except MemoryError:
            pipe.send(("failed", "not enough memory for this run; choose the quick grid or a shorter run"))
        except Exception as error:
            pipe.send(("failed", f"unforeseen {type(error).__name__}: {error} (please report it)"))


def stand_back() -> None:
    """Let the browser that shows the run go first."""
    import os

    with suppress(AttributeError, OSError):
        os.nice(NICE)


def _get_ready(pipe: Connection) -> None:
    """Load the kernels, or compile them where no run has been made on this machine, and say so."""
    from ..running.warm_up import warm_up

    class Lines:
        """Takes the place of stderr: what compiling says goes to the page."""

        def write(self, text: str) -> int:
            if text.strip():
                pipe.send(("note", text.strip().removeprefix("peristalsis: ")))
            return len(text)

        def flush(self) -> None:
            """Nothing is held back."""

    kept, sys.stderr = sys.stderr, Lines()
    try:
        warm_up()
    finally:
        sys.stderr = kept
    pipe.send(("idle", None))


class _Run:
    """A simulation with the pipe that it is seen and led through."""

    def __init__(self, pipe: Connection, start: Start) -> None:
        from ..inputs.config import Configuration
        from ..running.simulation import Simulation
        from .frames import Camera

        self.pipe = pipe
        self.folder = Path(start.folder)
        configuration = Configuration.from_toml(start.toml)
        self.simulation = Simulation(configuration)
        self.camera = Camera.of(self.simulation)
        self.until = configuration.run.duration
        self.paused = False
        self.over = False

    def make(self) -> None:
        """Advance to the end, a frame at a time, and store the result."""
        self.pipe.send(("header", self.camera.header(self.simulation)))
        for remark in self.simulation.remarks:
            self.pipe.send(("remark", remark))
        self._show()
        begin, seen = time.perf_counter(), 0
        try:
            while not self.over and self.simulation.stopped is None and self.simulation.time < self.until - 1e-9:
                while not self.over and self.pipe.poll(None if self._waits else 0.0):
                    self._obey(self.pipe.recv())
                if not (self.over or self.paused):
                    self._advance()
                    seen += 1
        except (DivergenceError, InterruptedRun) as error:
            self.simulation.failure, self.simulation.error = error, str(error)
        seconds = time.perf_counter() - begin
        from .outcomes import outcome

        result = self.simulation.result()
        rate = seen / seconds if seconds > 0.0 else 0.0
        self.pipe.send(("ended", {**outcome(result), "frames_per_second": round(rate, 1), "stopped": self.over}))
        result.save(self.folder / RESULT)

    @property
    def _waits(self) -> bool:
        """Whether nothing happens before the next order; the last step of a paused run needs none."""
        return self.paused and self.simulation.stopped is None and self.simulation.time < self.until - 1e-9

    def _advance(self) -> None:
        left = self.until - self.simulation.time
        self.simulation.advance(f"{min(PIECE, left):.9g} s")
        self._show()

    def _show(self) -> None:
        self.pipe.send(("frame", self.camera.take(self.simulation)))

    def _obey(self, order: object) -> None:
        match order:
            case "pause" | "resume":
                self.paused = order == PAUSE
                self.pipe.send(("paused", self.paused))
            case "step":
                if self._waits:
                    self._advance()
            case "stop":
                self.over = True
            case Change(changes, number):
                try:
                    self.simulation.set(changes)
                except PeristalsisError as error:
                    self.pipe.send(("refused", (number, str(error))))
                else:
                    self.pipe.send(("changed", (number, self.simulation.time)))
            case Save(name):
                self.simulation.result().save(self.folder / name)
                self.pipe.send(("saved", name))
