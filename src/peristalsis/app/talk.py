"""The conversation with one page over its WebSocket: orders in, frames and words out; never waits for a run."""

from __future__ import annotations

import asyncio
import json
import re
import secrets
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from ..errors import ConfigurationError, PeristalsisError, shown
from . import asked as asking
from . import exports, worker
from .lessons import BY_NAME
from .processes import write_file
from .runs import COMPUTING, Run, Runs
from .safety import PROTOCOL

PAGE = re.compile(r"[A-Za-z0-9-]{16,64}")
MOST_FRAMES = 100
"""Frames of a run in one message, so that two runs and words take turns."""
LONGEST_EXPORT = 300.0
"""Seconds after which a film or a figure is given up."""
ORDERS = {"pause": worker.PAUSE, "resume": worker.RESUME, "step": worker.STEP, "stop": worker.STOP}


class Watched:
    """A run that a page watches, and how much of it the page has."""

    def __init__(self, run: Run) -> None:
        self.run = run
        self.told = 0
        self.shown = 0

    def has_more(self) -> bool:
        """Whether there is something that the page has not got."""
        return self.told < len(self.run.log) or self.shown < len(self.run.frames)


class Talk:
    """One page: what it says is an object with `do`, what it hears an object with `kind`, or frames as bytes."""

    def __init__(self, socket: WebSocket, runs: Runs, files: dict[str, tuple[Path, str]]) -> None:
        self.socket = socket
        self.runs = runs
        self.files = files
        self.page = ""
        self.watched: dict[str, Watched] = {}
        self.news = asyncio.Event()
        self.exporting = False
        self._said: list[dict[str, Any]] = []
        self._tasks: set[asyncio.Task[None]] = set()

    async def serve(self) -> None:
        """Talk until the page goes."""
        page = self.socket.query_params.get("page", "")
        if not PAGE.fullmatch(page):
            await self.socket.close(4400)
            return
        try:
            self.runs.enter(page)
        except ConfigurationError as error:
            await self.socket.accept(PROTOCOL)
            await self.socket.send_text(json.dumps({"kind": "refused", "text": str(error)}))
            await self.socket.close(4429)
            return
        self.page = page
        await self.socket.accept(PROTOCOL)
        out = asyncio.ensure_future(self._send())
        try:
            while True:
                await self._hear(await self.socket.receive_text())
        except (WebSocketDisconnect, KeyError):  # KeyError: bytes, where only text is taken
            pass
        finally:
            out.cancel()
            for task in self._tasks:
                task.cancel()
            for one in self.watched.values():
                one.run.watchers.discard(self.news.set)
            self.runs.leave(page)

    def say(self, kind: str, **content: Any) -> None:
        """Have something said to this page alone."""
        self._said.append({"kind": kind, **content})
        self.news.set()

    async def _send(self) -> None:
        """Send what is new, a part of each run by turns, as fast as the page takes it."""
        try:
            while True:
                await self.news.wait()
                self.news.clear()
                while self._said or any(one.has_more() for one in self.watched.values()):
                    for message in self._said[: len(self._said)]:
                        self._said.remove(message)
                        await self.socket.send_text(json.dumps(message))
                    for one in list(self.watched.values()):
                        await self._send_some(one)
        except (WebSocketDisconnect, RuntimeError):  # the page has gone; who hears notices too
            return

    async def _send_some(self, one: Watched) -> None:
        run = one.run
        final = run.state != COMPUTING  # the end is told when its frames have been shown
        upto = len(run.log) - (1 if final and one.told < len(run.log) and one.shown < len(run.frames) else 0)
        for message in run.log[one.told : upto]:
            one.told += 1
            await self.socket.send_text(json.dumps(message))
        if one.shown < len(run.frames):
            content, one.shown = run.packed(one.shown, MOST_FRAMES)
            await self.socket.send_bytes(content)

    async def _hear(self, text: str) -> None:
        number = None
        try:
            said = json.loads(text)
            if not isinstance(said, dict):
                raise ConfigurationError("a page says objects, and nothing else")
            number = said.get("number")
            does = said.get("do")
            known: dict[str, Callable[[dict[str, Any]], Awaitable[None]]] = {
                "start": self._start,
                "attach": self._attach,
                "set": self._set,
                "order": self._order,
                "words": self._words,
                "judge": self._judge,
                "export": self._export,
            }
            if not isinstance(does, str) or does not in known:
                raise ConfigurationError(f"do = {shown(does)}: the page and the server do not belong together; reload")
            await known[does](said)
        except PeristalsisError as error:
            self.say("refused", number=number, text=str(error))
        except (ValueError, RecursionError):
            self.say("refused", number=None, text="this was no JSON; reload the page")

    async def _start(self, said: dict[str, Any]) -> None:
        slot = said.get("slot")
        if slot not in ("a", "b"):
            raise ConfigurationError(f"slot = {shown(slot)}: a page shows runs a and b")
        run = await self.runs.start(self.page, slot, asking.read(said.get("asked")))
        self.say("started", run=run.name, slot=slot)
        self._watch(run)

    async def _attach(self, said: dict[str, Any]) -> None:
        try:
            run = self.runs.of(self.page, said.get("run"))
        except ConfigurationError:
            self.say("gone", run=shown(said.get("run")).strip("'"))
            return
        self._watch(run)

    async def _set(self, said: dict[str, Any]) -> None:
        number = said.get("number")
        if not isinstance(number, int) or isinstance(number, bool):
            raise ConfigurationError("a change has a number")
        self.runs.change(self._run(said), said.get("change"), number)

    async def _order(self, said: dict[str, Any]) -> None:
        word = said.get("order")
        if not isinstance(word, str) or word not in ORDERS:
            raise ConfigurationError(f"order = {shown(word)}: a run can be told to {', '.join(ORDERS)}")
        self.runs.order(self._run(said), ORDERS[word])

    async def _words(self, said: dict[str, Any]) -> None:
        asked = asking.read(said.get("asked"))
        self.say("words", number=said.get("number"), toml=asked.configuration().to_toml(), python=asked.python())

    async def _judge(self, said: dict[str, Any]) -> None:
        name, names = said.get("lesson"), said.get("runs")
        if not isinstance(name, str) or name not in BY_NAME or not isinstance(names, list):
            raise ConfigurationError("there is no such lesson")
        lesson = BY_NAME[name]
        outcomes = [self.runs.of(self.page, one).outcome for one in names]
        if len(outcomes) != len(lesson.settings) or any(one is None for one in outcomes):
            raise ConfigurationError("the answer is found when every run of the lesson has come to its end")
        found = [one for one in outcomes if one is not None]
        answer = lesson.judged(found)
        self.say("judged", lesson=name, answer=answer, because=lesson.because, found=lesson.told(found))

    async def _export(self, said: dict[str, Any]) -> None:
        what = said.get("what")
        if not isinstance(what, str) or what not in exports.KINDS:
            raise ConfigurationError(f"what = {shown(what)}: choose one of {', '.join(exports.KINDS)}")
        if self.exporting:
            raise ConfigurationError("one file at a time: wait for the one that is being made")
        run = self._run(said)
        self.exporting = True
        task = asyncio.ensure_future(self._make_file(run, what))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _make_file(self, run: Run, what: str) -> None:
        kind = exports.KINDS[what]
        self.say("export", run=run.name, what=what, state="working")
        try:
            stored = await self.runs.stored(run)
            target = run.folder / f"{what}-{secrets.token_hex(4)}.{kind.ending}"
            why = await asyncio.to_thread(write_file, stored, what, target, LONGEST_EXPORT)
            if why is not None:
                raise ConfigurationError(why)
        except PeristalsisError as error:
            self.say("export", run=run.name, what=what, state="failed", text=str(error))
        else:
            handle, name = secrets.token_urlsafe(16), f"{run.asked.scenario}-{what}.{kind.ending}"
            self.files[handle] = (target, name)
            self.say("export", run=run.name, what=what, state="ready", link=f"/files/{handle}", name=name)
        finally:
            self.exporting = False

    def _run(self, said: dict[str, Any]) -> Run:
        return self.runs.of(self.page, said.get("run"))

    def _watch(self, run: Run) -> None:
        self.watched = {name: one for name, one in self.watched.items() if self.runs.runs.get(name) is one.run}
        if run.name not in self.watched:
            self.watched[run.name] = Watched(run)
            run.watchers.add(self.news.set)
        self.news.set()
