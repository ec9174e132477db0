"""Runs by name and runs kept on disk: begun, taken up again after whatever ended them, and put in their place."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

from .. import scenarios
from ..errors import ConfigurationError, DivergenceError, InterruptedRun, WriteError, shown
from ..inputs.config import Configuration
from ..model.ends import ANALLY, ORALLY
from ..names import CERTAIN
from ..paths import located
from ..results.result import UNFINISHED, Result, load
from ..storing.checkpoint import EVERY, Checkpoints, Found, newest
from ..storing.environment import code_version
from ..storing.locks import Claim
from ..storing.store import LAST_STATE, Workspace, check_target, read_manifest, recover, unfinished
from .certain import make_certain, neighbours, write_table
from .simulation import Simulation

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
    certain: bool = False,
    workers: int = 1,
) -> Result:
    """Run a scenario (the file's own, or the baseline, if none is named) and return its result.

    changes: parameters by name, values as text with a unit ("120 mN*s/cm") or plain for numbers without unit.
    reading: tight, stretched, printed or edge. file: a TOML configuration laid over the scenario. out: folder to store
    the result in, with checkpoints on the way; without it nothing is written. resume: go on from the newest checkpoint
    that an earlier run to this folder (out/SCENARIO unless given) left, or return its result if it had finished; one
    that had finished goes on from its end if only `run.duration` or a stop condition has changed.
    certain: run the doubled grid and the halved steps as well and compare: `summary["certain"]` says whether they
    agree, at about five times the cost in all; workers: processes for these two, 1 or 2.
    Raises ConfigurationError for bad input and WriteError for a folder that cannot be written; a run that diverges or
    is interrupted returns its history with `status`. Remarks, such as a grid too coarse for the wave, are in
    `result.remarks`, and each is said once through the logger "peristalsis".
    """
    configuration = scenarios.configuration(scenario, reading=reading, changes=changes, file=file)
    if certain:
        neighbours(configuration)  # refused now rather than at the end
    if out is None and not resume:
        result = Simulation(configuration, progress=progress).run()
        return _said(make_certain(result, workers) if certain else result)
    target = Path("out", configuration.scenario) if out is None else located(out)
    kept = KeptRun(configuration, target, resume, overwrite)
    if kept.finished is not None:
        return kept.finished_and_certain(workers) if certain else kept.finished
    with kept:
        result = kept.begin(progress).run()
        if certain:
            result = make_certain(result, workers)
        kept.save(result, partial(write_table, result.summary))
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
    between checkpoints. patience: seconds to wait for another process that works there. The name of the folder is
    taken until the end: Raises WriteError for a folder that cannot or may not be written, or in which another process
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
        patience: float = 0.0,
    ) -> None:
        self.configuration = configuration
        self.target = target
        self.finished: Result | None = None
        self._say = say if say is not None else _nothing
        self._every = every
        self._left: _Left | None = None
        self._overwrite = overwrite
        self._simulation: Simulation | None = None
        recover(target)
        check_target(target, overwrite or resume)
        claim = Claim(target, alone=resume or not overwrite, patience=patience)
        self.workspace = Workspace(target, claim=claim)
        try:
            recover(target)
            check_target(target, overwrite or resume)  # again, now that nobody else may write there
            if resume:
                self._look_back()
            if self._left is not None and self._left.workspace is not None:
                self.workspace = self._left.workspace
                self.workspace.take_over(claim)
                self.workspace.open()  # refused if another process works in it
        except BaseException:
            claim.release()
            raise
        if self.finished is not None:
            self.workspace.close()

    def _look_back(self) -> None:
        """Find what an earlier run left: a result, or the newest checkpoint."""
        left: list[_Left] = []
        if self.target.exists() and not self._overwrite:
            recorded = read_manifest(self.target)
            if recorded is None or recorded.status != "failed":  # a process that died is tried again
                found = self._stored()
                if self.finished is not None:
                    return
                left += [] if found is None else [_Left(found, None)]
            self._overwrite = True  # what was cut short is replaced by what goes on from it
        for folder in unfinished(self.target):
            found = self._usable(folder)
            if found is not None:
                left.append(_Left(found, Workspace(self.target, folder)))
        if not left:
            self._say(f"nothing to resume in {shown(str(self.target))} or beside it: the run begins at its start")
            return
        self._left = max(left, key=lambda one: one.found.head.step)

    def _stored(self) -> Found | None:
        """From where the run that is stored goes on; `finished` is set where nothing is left to run."""
        stored, place = load(self.target), shown(str(self.target))
        if stored.configuration.digest() == self.configuration.digest():
            found = self._usable(self.target) if stored.status == InterruptedRun.status else None
            self.finished = stored if found is None else None
            return found
        if stored.configuration.digest(ends=False) != self.configuration.digest(ends=False):
            raise WriteError(
                f"{place} holds a run of another configuration; choose another folder with --out, or say --overwrite"
            )
        wanted, ran = self.configuration.run, stored.configuration.run
        if stored.status == DivergenceError.status:
            raise WriteError(
                f"{place} holds a run that diverged at t = {stored.summary['simulated_s']:g} s: it is not made longer; "
                "change its parameters, in another folder (--out) or with --overwrite"
            )
        if stored.status in (ANALLY, ORALLY) and ran.stop_when_expelled:
            only_longer = _with_ends_of(stored.configuration, self.configuration, ("run.duration",))
            if only_longer.digest() != self.configuration.digest() or wanted.duration < stored.summary["simulated_s"]:
                raise WriteError(
                    f"{place} holds a run that ended when the pellet was expelled, and its last state is not kept; "
                    "choose another folder with --out, or say --overwrite to run it anew"
                )
            self.finished = replace(stored, configuration=self.configuration)
            self.finished.save(self.target, overwrite=True, workspace=self.workspace)
            self._say(f"{place}: the pellet was expelled before, so a longer run is the same")
            return None
        found = self._usable(self.target)
        if found is None:
            raise WriteError(
                f"{place} holds a run of {stored.summary['simulated_s']:g} s without a usable last state "
                f"({LAST_STATE}), so it cannot be made longer; choose another folder with --out, or say --overwrite"
            )
        return found

    def _usable(self, folder: Path) -> Found | None:
        found = newest(folder, ended=folder == self.target)
        if found is None or not self._is_ours(found):
            return None
        if found.head.code != code_version():
            self._say(
                f"the checkpoint in {shown(str(folder))} was written by version {found.head.code} of the code, this is "
                f"{code_version()}: it is not used"
            )
            return None
        return found

    def _is_ours(self, found: Found) -> bool:
        """Whether a checkpoint is of this run, or of one that differs from it in its end alone."""
        if found.head.digest == self.configuration.digest():
            return True
        try:
            begun = Configuration.from_toml(found.head.configuration)
        except ConfigurationError:
            return False
        return begun.digest(ends=False) == self.configuration.digest(ends=False)

    def begin(self, progress: Progress | None = None) -> Simulation:
        """The simulation, at its start or where the checkpoint is."""
        every_simulated = self.configuration.run.checkpoint
        checkpoints = Checkpoints(self.workspace, every_simulated, self._every, self._say)
        simulation = Simulation(self.configuration, progress=progress, checkpoints=checkpoints)
        if self._left is not None:
            found = self._left.found
            simulation.restore(found)
            self._say(f"resumed at t = {found.head.time:.6g} s from {shown(str(found.file))}")
        self._simulation = simulation
        return simulation

    def finished_and_certain(
        self, workers: int = 1, say: Say | None = None, extras: Callable[[Result, Path], None] | None = None
    ) -> Result:
        """The finished result with the verdict of its neighbours, made and stored now if it has none yet.

        extras: called with the result and the folder before that is put in place, to add files such as pictures.
        """
        if self.finished is None:
            raise ValueError("the run is not finished")
        known = self.finished.summary.get(CERTAIN)
        if self.finished.status in UNFINISHED or (known is not None and known["agrees"] is not None):
            return self.finished
        result = make_certain(self.finished, workers, say)

        def fill(folder: Path) -> None:
            write_table(result.summary, folder)
            if extras is not None:
                extras(result, folder)

        result.save(self.target, True, fill)
        return result

    def save(self, result: Result, extras: Callable[[Path], None] | None = None) -> None:
        """Put the result in place, and remove what other runs of this configuration left beside it."""
        run = self._simulation
        if run is not None and result.status not in UNFINISHED and run.stopped not in (ANALLY, ORALLY):
            self.workspace.write(LAST_STATE, run.last_state())
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


def _with_ends_of(old: Configuration, new: Configuration, keys: tuple[str, ...]) -> Configuration:
    """The old configuration with these parameters of the new one."""
    return old.with_changes({key: text for key, text in new.texts().items() if key in keys})


def _nothing(text: str) -> None:
    """Say nothing."""
