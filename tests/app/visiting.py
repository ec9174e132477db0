"""A page in the system's browser, as a test uses it."""

import time
from typing import Any

from .conftest import Live

QUICK = "a.grid=quick&b.grid=quick&a.v.duration=1.5&b.v.duration=1.5"
"""Runs of a second or two, by the permalink."""
IDLE = "&a.s.pacemaker=off&a.s.receptors=off&a.v.duration=60"
"""Where nothing moves, for a run that lasts."""


class Visit:
    """A page in a context of its own, with all that the browser complained of or asked others for."""

    def __init__(self, browser: Any, live: Live, options: dict[str, Any]) -> None:
        self.live = live
        self.context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **options})
        self.complaints: list[str] = []
        self.elsewhere: list[str] = []
        self.page = self.tab()

    def tab(self) -> Any:
        page = self.context.new_page()
        page.on(
            "console", lambda said: self.complaints.append(said.text) if said.type in ("error", "warning") else None
        )
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("request", self._asked)
        page.on("websocket", lambda chat: self._asked(chat))
        return page

    def _asked(self, request: Any) -> None:
        if not request.url.startswith((f"http://{self.live.host}/", f"ws://{self.live.host}/", "blob:", "data:")):
            self.elsewhere.append(request.url)

    def open(self, state: str = QUICK, page: Any = None) -> Any:
        page = page or self.page
        page.goto(f"{self.live.address}#{state}")
        page.wait_for_selector("html[data-ready]")
        self.until(
            "document.getElementById('status').textContent.includes('Choose') || window.peristalsis.records.size"
        )
        return page

    def until(self, script: str, page: Any = None, seconds: float = 120.0) -> Any:
        """Wait for something; scripts are asked from outside, for the page's policy lets none be made in it."""
        page = page or self.page
        end = time.monotonic() + seconds
        while not (found := page.evaluate(script)):
            assert time.monotonic() < end, f"{script}: {page.inner_text('#status')} {page.inner_text('#problem')}"
            page.wait_for_timeout(50)
        return found

    def state(self, slot: str, state: str, page: Any = None) -> None:
        self.until(
            "(() => { const { records, shown } = window.peristalsis;"
            f" const run = records.get(shown.{slot}); return run?.state === '{state}' && run.frames.length > 0 }})()",
            page,
        )

    def number(self, script: str) -> float:
        found: float = self.page.evaluate(f"(() => {{ const p = window.peristalsis; return {script} }})()")
        return found

    def slide(self, name: str, keys: str, times: int) -> None:
        self.page.focus(f"#control-{name}")
        for _ in range(times):
            self.page.keyboard.press(keys)
