"""The runs of all pages: started within limits, kept while a page wants them, ended when it goes."""

from __future__ import annotations

import asyncio
import secrets
import shutil
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import ConfigurationError
from . import worker
from .asked import Asked, read_live
from .processes import Worker

KEPT = 4
"""Runs whose pictures are kept for each page: two side by side, and the ones before them."""
MOST_PAGES = 16
"""Pages that may have runs at a time."""

COMPUTING, OVER, FAILED = "computing", "over", "failed"


@dataclass(eq=False)
class Run:
    """One run as the server knows it: every frame so far, and everything else that a page was told.

    slot: where its page shows it. log: what pages are told in words, in order. alone: set when its process has ended.
    watchers: called when there is something new. saved: what waits for a result that is stored on the way.
    """

    name: str
    page: str
    slot: str
    asked: Asked
    folder: Path
    frames: list[bytes] = field(default_factory=list)
    log: list[dict[str, Any]] = field(default_factory=list)
    state: str = COMPUTING
    ready: bool = False
    outcome: dict[str, Any] | None = None
    worker: Worker | None = None
    alone: asyncio.Event = field(default_factory=asyncio.Event)
    watchers: set[Callable[[], None]] = field(default_factory=set)
    saved: dict[str, asyncio.Future[bool]] = field(default_factory=dict)

    def tell(self, kind: str, **content: Any) -> None:
        """Add a message for pages."""
        self.log.append({"kind": kind, "run": self.name, **content})
        self.notify()

    def notify(self) -> None:
        """Wake the pages that watch."""
        for watcher in list(self.watchers):
            watcher()

    def packed(self, first: int, most: int) -> tuple[bytes, int]:
        """Frames from number `first` on as one message, at most so many, and the number of the next.

        The name in 8 letters, number of the first frame and bytes of each as uint32, then the frames.
        """
        chosen = self.frames[first : first + most]
        head = struct.pack("<8sII", self.name.encode("ascii"), first, len(chosen[0]))
        return head + b"".join(chosen), first + len(chosen)


class Runs:
    """All runs of one server. Everything here happens in the event loop, but for what processes do.

    folder: for results. most: runs that compute at a time. seconds: how long a page that has gone is waited for.
    """

    def __init__(self, folder: Path, most: int, seconds: float) -> None:
        self.folder = folder
        self.most = most
        self.patience = seconds
        self.runs: dict[str, Run] = {}
        self._pages: dict[str, int] = {}
        self._leaving: dict[str, asyncio.TimerHandle] = {}
        self._spare: Worker | None = None
        self._spare_notes: list[str] = []
        self._tasks: set[asyncio.Task[None]] = set()

    async def prepare(self) -> None:
        """Have a process ready for the next run."""
        if self._spare is None or not self._spare.alive():
            self._spare_notes = []
            self._spare = await self._new_worker()

    async def _new_worker(self) -> Worker:
        loop = asyncio.get_running_loop()
        holder: list[Worker] = []

        def heard(word: str, content: Any) -> None:  # of a process that has no run yet
            if word == "idle" and holder:
                holder[0].idle = True
            if word == "note":
                self._spare_notes.append(content)

        made = await asyncio.to_thread(Worker, lambda word, content: _into(loop, heard, word, content))
        holder.append(made)
        return made

    async def start(self, page: str, slot: str, asked: Asked) -> Run:
        """Start a run in a slot of a page, instead of what is under way there.

        Raises ConfigurationError where it is refused. Pages that have gone give way.
        """
        configuration = asked.configuration()
        for former in [run for run in self.runs.values() if (run.page, run.slot, run.state) == (page, slot, COMPUTING)]:
            self._cut_short(former)
        for gone in [run for run in self.runs.values() if run.page in self._leaving]:
            self._cut_short(gone)
        computing = [run for run in self.runs.values() if run.state == COMPUTING]
        if len(computing) >= self.most:
            raise ConfigurationError(
                f"{len(computing)} runs are under way, and the limit is {self.most} (--runs); "
                "stop one, or wait for its end"
            )
        if page not in self._pages:
            raise ConfigurationError("the page is not known; load it again")
        self._drop_oldest(page)
        name = secrets.token_hex(4)
        folder = self.folder / name
        folder.mkdir()
        run = Run(name, page, slot, asked, folder)
        self.runs[name] = run  # before anything is waited for: the limit counts it
        await self.prepare()
        taken, self._spare = self._spare, None
        assert taken is not None
        run.worker = taken
        for note in self._spare_notes:
            run.tell("note", text=note)
        loop = asyncio.get_running_loop()
        taken.heard = lambda word, content: _into(loop, self._hear, run, word, content)
        taken.tell(worker.Start(configuration.to_toml(), str(folder)))
        if len(computing) + 1 < self.most:
            self._prepare_soon()
        return run

    def of(self, page: str, name: object) -> Run:
        """A run of a page by its name. Raises ConfigurationError for one that is not the page's."""
        run = self.runs.get(name) if isinstance(name, str) else None
        if run is None or run.page != page:
            raise ConfigurationError("this run is no longer kept; start it again")
        return run

    def change(self, run: Run, content: object, number: int) -> None:
        """Change inputs of a run under way. Raises ConfigurationError for what cannot be."""
        if run.state != COMPUTING or not run.ready or run.worker is None:
            raise ConfigurationError("the run is not under way; the change counts for the next one")
        run.asked, changes = read_live(content, run.asked)
        if changes:
            run.worker.tell(worker.Change(changes, number))

    def order(self, run: Run, word: str) -> None:
        """Pause, resume, step or stop a run."""
        if run.state == COMPUTING and run.worker is not None:
            run.worker.tell(word)

    async def stored(self, run: Run) -> Path:
        """The folder of a run's result, stored as it stands where it is under way."""
        if run.state == OVER:
            await run.alone.wait()
            if not (run.folder / worker.RESULT).is_dir():
                raise ConfigurationError("the result is not there: the run was ended while it was stored")
            return run.folder / worker.RESULT
        if run.state != COMPUTING or run.worker is None:
            raise ConfigurationError("the run has no result; start it again")
        name = f"result-{secrets.token_hex(4)}"
        run.saved[name] = asyncio.get_running_loop().create_future()
        run.worker.tell(worker.Save(name))
        if not await run.saved[name]:  # it came to its end meanwhile
            return await self.stored(run)
        return run.folder / name

    def enter(self, page: str) -> None:
        """A page has come, or come back."""
        if page not in self._pages and len(self._pages) >= MOST_PAGES:
            raise ConfigurationError(f"{MOST_PAGES} pages are open, and that is the limit; close one")
        self._pages[page] = self._pages.get(page, 0) + 1
        waiting = self._leaving.pop(page, None)
        if waiting is not None:
            waiting.cancel()

    def leave(self, page: str) -> None:
        """A page has gone: its runs end if it does not come back."""
        self._pages[page] -= 1
        if self._pages[page] == 0:
            loop = asyncio.get_running_loop()
            self._leaving[page] = loop.call_later(self.patience, self._forget_page, page)

    def close(self) -> None:
        """End every process."""
        for task in self._tasks:
            task.cancel()
        for run in list(self.runs.values()):
            self._drop(run)
        if self._spare is not None:
            self._spare.end()

    def _forget_page(self, page: str) -> None:
        self._leaving.pop(page, None)
        self._pages.pop(page, None)
        for run in [one for one in self.runs.values() if one.page == page]:
            self._drop(run)

    def _drop_oldest(self, page: str) -> None:
        done = [run for run in self.runs.values() if run.page == page and run.state != COMPUTING]
        for run in done[: max(0, len(done) - KEPT + 1)]:
            self._drop(run)

    def _cut_short(self, run: Run) -> None:
        """End a run that computes; its pictures stay."""
        if run.state == COMPUTING:
            run.state = FAILED
            run.tell("cut")
        if run.worker is not None:
            run.worker.heard = lambda word, content: None
            run.worker.end()
            run.worker = None
        run.alone.set()
        self._release(run)

    def _drop(self, run: Run) -> None:
        self.runs.pop(run.name, None)
        self._cut_short(run)
        shutil.rmtree(run.folder, ignore_errors=True)

    def _release(self, run: Run) -> None:
        """Answer those who wait for a stored result of a run that makes no more."""
        for waiting in run.saved.values():
            if not waiting.done():
                waiting.set_result(False)

    def _hear(self, run: Run, word: str, content: Any) -> None:
        """What the process of a run has sent."""
        match word:
            case "frame":
                run.frames.append(content)
                run.notify()
            case "note" | "remark":
                run.tell(word, text=content)
            case "header":
                run.ready = True
                run.tell("header", header=content)
            case "paused":
                run.tell("paused", paused=content)
            case "changed":
                run.tell("changed", number=content[0], time=content[1])
            case "refused":
                run.tell("refused", number=content[0], text=content[1])
            case "saved":
                if not run.saved[content].done():  # who waited for it may have gone
                    run.saved[content].set_result(True)
            case "ended":
                run.state, run.outcome = OVER, content
                run.tell("ended", outcome=content)
            case "failed":
                run.state = FAILED
                run.tell("failed", text=content)
            case "gone":
                self._gone(run, content)

    def _gone(self, run: Run, code: int | None) -> None:
        run.worker = None
        run.alone.set()
        self._release(run)
        if run.state == COMPUTING:
            run.state = FAILED
            how = "was ended from outside, for want of memory perhaps" if (code or 0) < 0 else "ended unexpectedly"
            run.tell("failed", text=f"the process of this run {how}; start it again")
        self._prepare_soon()

    def _prepare_soon(self) -> None:
        task = asyncio.ensure_future(self.prepare())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def _into(loop: asyncio.AbstractEventLoop, call: Callable[..., None], *content: Any) -> None:
    """Have the event loop call something; nothing once it has ended."""
    if not loop.is_closed():
        loop.call_soon_threadsafe(call, *content)
