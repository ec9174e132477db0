"""Checkpoints of a run under way: two files by turns, each whole and with its own hash, so that one always stands.

A checkpoint holds everything that the rest of the run depends on, to the bit: the state, what was recorded, how the
inputs stand. `Simulation` decides what they contain; here they are written and the newest is found.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..errors import ConfigurationError, WriteError, shown
from . import disk
from .packing import unpack
from .store import CHECKPOINTS, LAST_STATE, Workspace, unfinished

EVERY = 10.0
"""Seconds on the clock between two checkpoints, where the run does not say how much simulated time."""
SHARE = 0.05
"""Largest share of the clock that writing checkpoints may take: large ones are written less often."""
LARGEST = 8_000_000_000
"""Bytes of a checkpoint that are read."""


@dataclass(frozen=True)
class Head:
    """What tells checkpoints apart: step, time [s], digest and TOML of the configuration, code, hash of the start."""

    step: int
    time: float
    digest: str
    configuration: str
    code: str
    start: str


@dataclass(frozen=True)
class Found:
    """A checkpoint that was read: its head, its bytes, the file it is in, and what is to be said about it."""

    head: Head
    content: bytes
    file: Path
    remarks: tuple[str, ...] = ()


class Checkpoints:
    """Writes checkpoints of a run into its workspace.

    simulated: simulated time between two [s]; 0 leaves it to the clock, one every `every` seconds. warn: told once
    when one cannot be written; the run goes on, with the last good one.
    """

    def __init__(
        self,
        workspace: Workspace,
        simulated: float = 0.0,
        every: float = EVERY,
        warn: Callable[[str], None] | None = None,
    ) -> None:
        self.workspace = workspace
        self._simulated = simulated
        self._every = every
        self._warn = warn
        self._turn = 0
        self._next_time = simulated
        self._next_clock = time.monotonic() + every

    def go_on_after(self, found: Found) -> None:
        """The run goes on from this checkpoint: it is the last to be replaced."""
        if found.file.parent == self.workspace.folder and found.file.name in CHECKPOINTS:
            self._turn = 1 - CHECKPOINTS.index(found.file.name)
        self._plan(found.head.time)

    def due(self, now: float) -> bool:
        """Whether to write one at this simulated time [s]."""
        if self._simulated > 0.0:
            return now >= self._next_time * (1.0 - 1e-12)
        return time.monotonic() >= self._next_clock

    def write(self, now: float, content: bytes) -> None:
        """Replace the older of the two; a disk that is full costs the checkpoint, not the run."""
        begin = time.monotonic()
        try:
            self.workspace.write(CHECKPOINTS[self._turn], content)
            self._turn = 1 - self._turn
        except WriteError as error:
            if self._warn is not None:
                self._warn(f"no checkpoint at t = {now:.6g} s: {error}; the run goes on")
                self._warn = None
        self._plan(now)
        self._next_clock = max(self._next_clock, time.monotonic() + (time.monotonic() - begin) / SHARE)

    def _plan(self, now: float) -> None:
        self._next_clock = time.monotonic() + self._every
        if self._simulated > 0.0:
            self._next_time = (int(now / self._simulated * (1.0 + 1e-12)) + 1) * self._simulated


def newest(folder: Path, ended: bool = False) -> Found | None:
    """The newest whole checkpoint in a folder, with a remark for each that is damaged; None if there is none.

    ended: whether the last state of a finished run counts as one; it needs the whole result beside it.
    """
    found: list[Found] = []
    remarks: list[str] = []
    for name in (*CHECKPOINTS, LAST_STATE) if ended else CHECKPOINTS:
        file = folder / name
        try:
            content = disk.read_regular(file, LARGEST)
            found.append(Found(unpack(content, {"head": Head})["head"], content, file))
        except FileNotFoundError:
            continue
        except (OSError, ValueError) as error:
            said = " ".join(str(error).split())[:120]
            remarks.append(f"the checkpoint {shown(str(file))} is damaged ({said}) and was passed over")
    if not found:
        return None
    best = max(found, key=lambda one: one.head.step)
    return Found(best.head, best.content, best.file, tuple(remarks))


def newest_of(place: Path) -> Found:
    """The newest checkpoint of a run: in a folder itself, or in the hidden ones that a run to it left beside it.

    Raises ConfigurationError if there is none.
    """
    found = [one for folder in (place, *unfinished(place)) if (one := newest(folder, folder == place)) is not None]
    if not found:
        raise ConfigurationError(
            f"no whole checkpoint in {shown(str(place))} or beside it; runs write them every {EVERY:g} s on the clock, "
            "or every run.checkpoint of simulated time"
        )
    return max(found, key=lambda one: one.head.step)
