"""Runs by name and runs kept on disk: begun, taken up again after whatever ended them, and put in their place."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from . import scenarios
from .checkpoint import EVERY, Checkpoints, Found, newest
from .config import Configuration
from .environment import code_version
from .errors import WriteError, shown
from .paths import located
from .result import Result, load
from .simulation import Simulation
from .store import Workspace, check_target, recover, unfinished

Progress = Callable[[float, float], None]
Say = Callable[[str], None]


def run(
    scenario: str | None = None,
    changes: Mapping[str, Any] | None = None,
    *,
    reading: str | None = None,
    file: str | PathLike[str] | None = None,
    out: str | PathLike[str] | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> Result:
    """Run a scenario (the file's own, or the baseline, if none is named) and return its result.

    changes: parameters by name, values as text with a unit ("120 mN*s/cm") or plain for numbers without unit.
    reading: tight, stretched or printed. file: a TOML configuration laid over the scenario. out: folder to store the
    result in, with checkpoints on the way; without it nothing is written. resume: go on from the newest checkpoint
    that an earlier run to this folder (out/SCENARIO unless given) left, or return its result if it had finished.
    Raises ConfigurationError for bad input and WriteError for a folder that cannot be written; a run that diverges or
    is interrupted returns its history with `status`. Remarks, such as a grid too coarse for the wave, are in
    `result.remarks`, and each is said once through the logger "peristalsis".
    """
    configuration = scenarios.configuration(scenario, reading=reading, changes=changes, file=file)
    if out is None and not resume:
        return _said(Simulation(configuration, progress=progress).run())
    target = Path("out", configuration.scenario) if out is None else located(out)
    kept = KeptRun(configuration, target, resume, overwrite)
    if kept.finished is not None:
        return kept.finished
    with kept:
        result = kept.begin(progress).run()
        kept.save(result)
    return _said(result)


_LOG = logging.getLogger("peristalsis")
_SAID: set[str] = set()


def _said(result: Result) -> Result:
    """The result, once its remarks are said: each once in a process, on stderr unless logging is set up otherwise."""
    for remark in result.remarks:
        if remark not in _SAID:
            _SAID.add(remark)
            _LOG.warning("%s: %s", result.configuration.scenario, remark)
    return result


@dataclass(frozen=True)
class _Left:
    """What an earlier run left: its newest checkpoint, and the hidden folder it is in, None if in the result's own."""

    found: Found
    workspace: Workspace | None


class KeptRun:
    """One run on its way to a folder: finished already, taken up from a checkpoint, or begun anew.

    say: told, in one line each, from where the run goes on and what could not be used. every: seconds on the clock
    between checkpoints. Raises WriteError for a folder that cannot or may not be written, or in which another process
    works, and DamagedResult for a result there that is not whole.
    """

    def __init__(
        self,
        configuration: Configuration,
        target: Path,
        resume: bool = False,
        overwrite: bool = False,
        say: Say | None = None,
        every: float = EVERY,
    ) -> None:
        self.configuration = configuration
        self.target = target
        self.finished: Result | None = None
        self._say = say if say is not None else _nothing
        self._every = every
        self._left: _Left | None = None
        self._overwrite = overwrite
        recover(target)
        check_target(target, overwrite or resume)
        if resume:
            self._look_back()
        self.workspace = self._left.workspace if self._left is not None and self._left.workspace else Workspace(target)

    def _look_back(self) -> None:
        """Find what an earlier run left: a result, or the newest checkpoint."""
        left: list[_Left] = []
        if self.target.exists() and not self._overwrite:
            stored = load(self.target)
            if stored.configuration.digest() != self.configuration.digest():
                raise WriteError(
                    f"{shown(str(self.target))} holds a run of another configuration; choose another folder with "
                    "--out, or say --overwrite"
                )
            found = self._usable(self.target) if stored.status == "interrupted" else None
            if found is None:
                self.finished = stored
                return
            left.append(_Left(found, None))
            self._overwrite = True  # what was interrupted is replaced by what goes on from it
        for folder in unfinished(self.target):
            found = self._usable(folder)
            if found is not None:
                left.append(_Left(found, Workspace(self.target, folder)))
        if not left:
            self._say(f"nothing to resume in {shown(str(self.target))} or beside it: the run begins at its start")
            return
        self._left = max(left, key=lambda one: one.found.head.step)
        if self._left.workspace is not None:
            self._left.workspace.open()  # refused if another process works in it

    def _usable(self, folder: Path) -> Found | None:
        found = newest(folder)
        if found is None or found.head.digest != self.configuration.digest():
            return None
        if found.head.code != code_version():
            self._say(
                f"the checkpoint in {shown(str(folder))} was written by version {found.head.code} of the code, this is "
                f"{code_version()}: it is not used"
            )
            return None
        return found

    def begin(self, progress: Progress | None = None) -> Simulation:
        """The simulation, at its start or where the checkpoint is."""
        every_simulated = self.configuration.run.checkpoint
        checkpoints = Checkpoints(self.workspace, every_simulated, self._every, self._say)
        simulation = Simulation(self.configuration, progress=progress, checkpoints=checkpoints)
        if self._left is not None:
            found = self._left.found
            simulation.restore(found)
            self._say(f"resumed at t = {found.head.time:.6g} s from {shown(str(found.file))}")
        return simulation

    def save(self, result: Result, extras: Callable[[Path], None] | None = None) -> None:
        """Put the result in place, and remove what other runs of this configuration left beside it."""
        result.save(self.target, self._overwrite, extras, self.workspace)
        for folder in unfinished(self.target):
            found = newest(folder)
            if found is None or found.head.digest == self.configuration.digest():
                other = Workspace(self.target, folder)
                try:
                    other.open()
                except WriteError:  # somebody works in it
                    continue
                other.discard()

    def __enter__(self) -> KeptRun:
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the hidden folder for another time if a run could go on from it, else remove it."""
        if self.workspace.folder.exists() and not self.workspace.has_checkpoints():
            self.workspace.discard()
        self.workspace.close()


def _nothing(text: str) -> None:
    """Say nothing."""
