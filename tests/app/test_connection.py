"""A page and its server: a server that has ended, an address that comes while the page is open, orders that cross."""

import asyncio
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

from peristalsis.app.asked import Asked
from peristalsis.app.runs import Run, Runs

from .conftest import serving
from .visiting import IDLE, QUICK, Visit

SILENT = (
    "The server does not answer; is peristalsis app still running? Start it again, and open the address that it prints"
)


def test_a_server_that_has_ended_is_said_and_nothing_hangs(browser: Any) -> None:
    with serving() as live:
        own = Visit(browser, live, {})
        page = own.open(QUICK + IDLE)
        page.click("#run")
        own.state("a", "computing")
        page.click("[data-file=film]")
        own.until("document.getElementById('kept').textContent.startsWith('Making')")
        os.kill(live.process, signal.SIGINT)
        own.until(f"document.getElementById('problem').textContent === {SILENT!r}")
    assert page.inner_text("#kept") == "The connection was lost before the file was made; ask for it again"
    assert page.is_enabled("[data-file=film]")
    scenario = page.input_value("#scenario")
    presses: list[Callable[[], Any]] = [
        lambda: page.click("#run"),
        lambda: page.click("#toml"),
        lambda: page.select_option("#scenario", "fig3f"),
    ]
    for press in presses:
        page.evaluate("document.getElementById('problem').textContent = ''")
        press()
        own.until(f"document.getElementById('problem').textContent === {SILENT!r}")
    assert page.input_value("#scenario") == scenario, "a choice that could not be read is taken back"
    page.focus("#control-pressure")
    page.keyboard.press("ArrowRight")  # and controls go on
    own.context.close()
    assert not [text for text in own.complaints if "TypeError" in text]


def test_an_address_that_comes_while_the_page_is_open_is_taken(visit: Callable[..., Visit]) -> None:
    own = visit()
    page = own.open(QUICK + "&a.v.pressure=0.3&a.s.pacemaker=off")
    page.evaluate("location.hash = '#a.scenario=fig3f&a.v.viscous_friction=77'")
    own.until("document.querySelector('#control-viscous_friction + input').value === '77'")
    assert page.input_value("#scenario") == "fig3f"
    assert page.is_checked("#switch-pacemaker"), "nothing is left of the former"
    page.evaluate("location.hash = '#view'")  # the link that skips to the picture
    own.until("location.hash.includes('viscous_friction=77')")
    assert page.input_value("#control-viscous_friction + input") == "77"


def test_lines_of_a_run_that_was_changed_on_the_way_say_so(visit: Callable[..., Visit]) -> None:
    own = visit()
    page = own.open(QUICK + IDLE)
    page.click("#run")
    own.state("a", "computing")
    page.click("#python")
    own.until("document.getElementById('words').textContent.includes('ps.run')")
    assert page.inner_text("#kept") == ""
    own.slide("pressure", "ArrowRight", 1)
    own.until("window.peristalsis.records.get(window.peristalsis.shown.a).changes.length > 0")
    for words in ("#python", "#toml"):
        page.click(words)
        own.until("document.getElementById('kept').textContent.startsWith('Controls were moved while this run')")
    page.click("#stop")
    own.state("a", "over")


def test_a_result_for_one_who_has_gone(tmp_path: Path) -> None:
    """It is stored on the way after the page, or the server, has given up waiting for it."""
    run, loop = Run("run-one", "page-one", "a", Asked(), tmp_path), asyncio.new_event_loop()
    run.saved["result"] = loop.create_future()
    run.saved["result"].cancel()
    Runs(tmp_path, 2, 1.0)._hear(run, "saved", "result")
    loop.close()
