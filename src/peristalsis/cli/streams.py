"""Where answers and messages go: answers to stdout, everything else to stderr."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TextIO, cast

from ..errors import PeristalsisError

if TYPE_CHECKING:
    from rich.progress import Progress

PLAIN_WIDTH = 150
"""Columns of a table that does not go to a terminal."""

EVERY = 0.1
"""Seconds between two updates of the progress bar."""


class ForgivingStream:
    """A text stream that falls silent, instead of raising, once it cannot be written to."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.error: OSError | None = None
        with suppress(AttributeError, ValueError, OSError):
            cast(Any, stream).reconfigure(errors="backslashreplace")  # any name of a file can be shown

    def write(self, text: str) -> int:
        """Write, or do nothing."""
        if self.error is None:
            try:
                return self._stream.write(text)
            except OSError as error:
                self._silence(error)
        return len(text)

    def flush(self) -> None:
        """Flush, or do nothing."""
        if self.error is None:
            try:
                self._stream.flush()
            except OSError as error:
                self._silence(error)

    def _silence(self, error: OSError) -> None:
        self.error = error
        with suppress(OSError, ValueError):  # what is left in the buffer must not fail again at exit
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@dataclass(frozen=True)
class Streams:
    """Both streams of the process while a command is carried out."""

    out: ForgivingStream
    err: ForgivingStream

    def lost(self) -> str | None:
        """Why stdout could not be written; a reader that went away, as `head` does, is no failure."""
        self.out.flush()
        error = self.out.error
        if error is None or isinstance(error, BrokenPipeError):
            return None
        return error.strerror or str(error)


@contextmanager
def forgiving_streams() -> Iterator[Streams]:
    """Replace stdout and stderr by streams that never raise."""
    kept = sys.stdout, sys.stderr
    with open(os.devnull, "w", encoding="utf-8") as nowhere:
        streams = Streams(ForgivingStream(kept[0] or nowhere), ForgivingStream(kept[1] or nowhere))
        sys.stdout, sys.stderr = cast(TextIO, streams.out), cast(TextIO, streams.err)
        try:
            yield streams
        finally:
            streams.out.flush()
            streams.err.flush()
            sys.stdout, sys.stderr = kept


def spelled(path: os.PathLike[str] | str) -> str:
    """A path on one line."""
    text = str(path)
    return text if text.isprintable() else ascii(text)


class Screen:
    """Answers on stdout, as text or, with `json`, as exactly one JSON object; messages on stderr."""

    def __init__(self, json: bool) -> None:
        self.json = json
        self.scenario: str | None = None
        self.if_interrupted = "interrupted"
        self._answered = False

    def say(self, text: str) -> None:
        """A line of an answer for a person; nothing with --json."""
        if not self.json:
            print(text, file=sys.stdout)

    def answer(self, content: Any) -> None:
        """The JSON object; nothing without --json, nor a second time."""
        if self.json and not self._answered:
            self._answered = True
            print(json.dumps(content, indent=2, allow_nan=False), file=sys.stdout)

    def table(self, columns: Sequence[str], rows: Iterable[Sequence[str]], title: str | None = None) -> None:
        """A table for a person; the first column is never folded. Nothing with --json."""
        if self.json:
            return
        from rich import box
        from rich.console import Console
        from rich.table import Table
        from rich.text import Text

        stream = cast(TextIO, sys.stdout)
        plain = not stream.isatty() and "COLUMNS" not in os.environ
        console = Console(file=stream, width=PLAIN_WIDTH if plain else None)
        table = Table(title=title and Text(title), box=box.SIMPLE_HEAD, title_justify="left")
        for index, column in enumerate(columns):
            table.add_column(Text(column), no_wrap=index == 0, overflow="fold")
        for row in rows:
            table.add_row(*(Text(cell) for cell in row))
        console.print(table)

    def line(self, text: str) -> None:
        """A message on stderr."""
        print(text, file=sys.stderr)

    def warn(self, text: str) -> None:
        """A warning on stderr."""
        self.line(f"warning: {text}")

    def fail(self, error: PeristalsisError, fields: Mapping[str, Any] | None = None, also: str = "") -> int:
        """One line on stderr, one object on stdout with --json, and the exit code.

        fields: what the object holds besides scenario, status and error, or instead. also: more for stderr.
        """
        said = str(error)
        self.line(f"{said if said.startswith(error.status) else f'error: {said}'}{also}")
        self.answer({"scenario": self.scenario, "status": error.status, "error": str(error)} | dict(fields or {}))
        return error.exit_code


class RunProgress:
    """How far a run is, on stderr: a bar on a terminal, else a line for every tenth; none before `start`."""

    def __init__(self, screen: Screen, duration: float, pellet: bool) -> None:
        self._screen = screen
        self._duration = duration
        self._pellet = pellet
        self._bar: Progress | None = None
        self._tenths: int | None = None
        self._next = 0.0

    def __enter__(self) -> RunProgress:
        self._screen.line("preparing")
        return self

    def start(self) -> None:
        """From now on, steps are shown."""
        self._tenths = 0
        if not sys.stderr.isatty():
            return
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        self._bar = Progress(
            TextColumn("running"),
            BarColumn(),
            TextColumn("{task.fields[now]}"),
            TimeRemainingColumn(),
            console=Console(file=cast(TextIO, sys.stderr)),
            transient=True,
            redirect_stdout=False,
            redirect_stderr=False,
        )
        self._bar.add_task("run", total=self._duration, now="")
        self._bar.start()

    def see(self, seconds: float, position: float) -> None:
        """A step was made: simulated time [s], position of the pellet [cm]."""
        if self._tenths is None:
            return
        if self._bar is not None:
            if time.monotonic() >= self._next:
                self._next = time.monotonic() + EVERY
                self._bar.update(self._bar.task_ids[0], completed=seconds, now=self._now(seconds, position))
            return
        tenths = int(10.0 * seconds / self._duration + 1e-9)
        if tenths > self._tenths:
            self._tenths = tenths
            self._screen.line(f"{10 * tenths:3d} %  {self._now(seconds, position)}")

    def _now(self, seconds: float, position: float) -> str:
        place = f", pellet at {position:.2f} cm" if self._pellet else ""
        return f"t = {seconds:.4g} of {self._duration:.4g} s{place}"

    def done(self, why: str, seconds: float) -> None:
        """The run is over at a simulated time [s], perhaps before its longest duration: a full bar, or a last line."""
        words = f"100 %  t = {seconds:.4g} s: {why}"
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], total=1.0, completed=1.0, now=words)
        elif self._tenths is not None and self._tenths < 10:
            self._tenths = 10
            self._screen.line(words)

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()
