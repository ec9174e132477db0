"""A server of the app as users start it, one for all tests here, and what its page needs to talk to it."""

import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from .visiting import Visit

QUICK = {"grid": "quick", "values": {"duration": 1.0}}
"""A run of a second or so."""
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@dataclass(frozen=True)
class Live:
    """A server that runs: its port, the key of its address, the token of its page."""

    port: int
    key: str
    token: str
    process: int

    @property
    def host(self) -> str:
        return f"127.0.0.1:{self.port}"

    @property
    def address(self) -> str:
        return f"http://{self.host}/?key={self.key}"

    @property
    def cookie(self) -> str:
        return f"peristalsis-{self.port}={self.key}"

    def get(self, path: str) -> tuple[int, dict[str, str], bytes]:
        """Status, headers and body of a page's own request."""
        asked = urllib.request.Request(f"http://{self.host}{path}", headers={"Cookie": self.cookie})
        try:
            with urllib.request.urlopen(asked) as answer:
                return answer.status, dict(answer.headers.items()), answer.read()
        except urllib.error.HTTPError as error:
            return error.code, dict(error.headers.items()), error.read()


@dataclass
class Page:
    """A page without a browser: its WebSocket, and all that it heard."""

    socket: Any
    heard: list[dict[str, Any]] = field(default_factory=list)
    frames: dict[str, list[bytes]] = field(default_factory=dict)

    def say(self, does: str, **content: Any) -> None:
        self.socket.send(json.dumps({"do": does, **content}))

    def until(self, wanted: Callable[[dict[str, Any]], bool], seconds: float = 120.0) -> dict[str, Any]:
        """The first word of this kind from now on."""
        end = time.monotonic() + seconds
        while True:
            got = self.socket.recv(timeout=max(0.01, end - time.monotonic()))
            if isinstance(got, bytes):
                self.frames.setdefault(got[:8].decode(), []).append(got)
                continue
            word = json.loads(got)
            self.heard.append(word)
            if wanted(word):
                return word

    def word(self, kind: str, **content: Any) -> dict[str, Any]:
        """The next word of a kind."""
        return self.until(lambda word: word["kind"] == kind and content.items() <= word.items())

    def start(self, asked: dict[str, Any] = QUICK, slot: str = "a") -> str:
        """Start a run and give its name."""
        self.say("start", slot=slot, asked=asked)
        name: str = self.word("started")["run"]
        return name

    def close(self) -> None:
        self.socket.close()


@contextmanager
def serving() -> Iterator[Live]:
    """`peristalsis app` on a free port."""
    for needed in ("starlette", "uvicorn", "websockets"):
        pytest.importorskip(needed)
    words = [sys.executable, "-m", "peristalsis", "app", "--port", "0", "--no-browser", "--wait", "3"]
    environment = {**os.environ, "PYTHONUNBUFFERED": "1", "OMP_NUM_THREADS": "1"}
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        try:
            found = re.search(r"127\.0\.0\.1:(\d+)/\?key=(\S+)", process.stdout.readline())
            assert found is not None, "the server did not say its address"
            without_token = Live(int(found[1]), found[2], "", process.pid)
            token = re.search(rb'name="token" content="([^"]+)"', without_token.get("/")[2])
            assert token is not None
            yield Live(without_token.port, without_token.key, token[1].decode(), process.pid)
        finally:
            process.terminate()


@pytest.fixture(scope="session")
def live() -> Iterator[Live]:
    """The server of all tests."""
    with serving() as server:
        yield server


@pytest.fixture
def page(live: Live) -> Iterator[Callable[..., Page]]:
    """Opens pages by their name; they are closed after the test."""
    from websockets.sync.client import connect

    with ExitStack() as opened:

        def visit(name: str = "page-of-the-tests-1") -> Page:
            chat = connect(
                f"ws://{live.host}/talk?page={name}",
                origin=f"http://{live.host}",
                subprotocols=["peristalsis.1", f"token.{live.token}"],
                additional_headers={"Cookie": live.cookie},
            )
            return Page(opened.enter_context(chat))

        yield visit


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """The system's Chromium."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: make test-app does it")
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        pytest.skip("no Chromium is installed: apt-get install chromium, or make test-app as root")
    with playwright.sync_playwright() as driver:
        own = driver.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield own
        own.close()


@pytest.fixture
def visit(browser: Any, live: Live) -> Iterator[Callable[..., "Visit"]]:
    """Opens pages; in the end none may have complained, nor asked another machine for anything."""
    from .visiting import Visit

    opened: list[Visit] = []

    def come(**options: Any) -> Visit:
        opened.append(Visit(browser, live, options))
        return opened[-1]

    yield come
    for one in opened:
        one.context.close()
    assert [text for one in opened for text in one.complaints] == []
    assert [address for one in opened for address in one.elsewhere] == []
