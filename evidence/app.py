"""What the app costs on this machine: first picture, pictures a second, lag of a slider, memory after thirty runs.

    python evidence/app.py [--parts first,live,lag,memory] [--runs 30] [--pictures FOLDER]

Needs the extras `app` and `browser` and the system's Chromium. Prints a table; with --pictures, the page as pictures.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

PARTS = ("first", "live", "lag", "memory")
SIZES = {"telephone": (360, 780), "desk": (1440, 900), "projector": (1920, 1080)}
STATE = "window.peristalsis.records.get(window.peristalsis.shown.{slot})?.state"


def until(page: Any, script: str, seconds: float = 300.0) -> None:
    """Wait until a script on the page is true; asked from outside, for the page's policy lets none be made in it."""
    end = time.monotonic() + seconds
    while not page.evaluate(script):
        if time.monotonic() > end:
            raise SystemExit(f"{script} never came: {page.inner_text('#status')} {page.inner_text('#problem')}")
        page.wait_for_timeout(20)


def memory(process: int) -> tuple[float, int]:
    """Resident memory [MB] of a process and of all that it started, and how many these are."""
    status = Path(f"/proc/{process}/status").read_text(encoding="ascii")
    found = re.search(r"VmRSS:\s+(\d+)", status)
    own, count = (int(found[1]) / 1024.0 if found else 0.0), 1
    for thread in Path(f"/proc/{process}/task").iterdir():
        for child in thread.joinpath("children").read_text(encoding="ascii").split():
            more, others = memory(int(child))
            own, count = own + more, count + others
    return own, count


def opened(browser: Any, address: str, width: int, height: int, **options: Any) -> Any:
    """The page, ready to be used."""
    page = browser.new_context(viewport={"width": width, "height": height}, **options).new_page()
    page.goto(address)
    page.wait_for_selector("html[data-ready]")
    return page


def cost(page: Any) -> float:
    """Processor time [ms] of one picture of everything, drawn again and again in the page."""
    page.evaluate("window.peristalsis.stats.spent = 0; window.peristalsis.stats.drawn = 0")
    page.focus("#scrub")
    for _ in range(60):
        page.keyboard.press("ArrowLeft")
        page.wait_for_timeout(5)
    found: float = page.evaluate("window.peristalsis.stats.spent / window.peristalsis.stats.drawn")
    return found


def live(page: Any, both: bool) -> tuple[float, float]:
    """Pictures drawn and frames received a second, while one run or two compute."""
    page.click("#run-both" if both else "#run")
    for slot in "ab" if both else "a":
        until(page, f"{STATE.format(slot=slot)} === 'computing'")
    before, begin = page.evaluate("({ ...window.peristalsis.stats })"), time.perf_counter()
    until(page, f"{STATE.format(slot='a')} !== 'computing'")
    after, seconds = page.evaluate("({ ...window.peristalsis.stats })"), time.perf_counter() - begin
    if both:
        until(page, f"{STATE.format(slot='b')} !== 'computing'")
    return tuple((after[key] - before[key]) / seconds for key in ("drawn", "received"))  # type: ignore[return-value]


def lags(page: Any, moves: int) -> list[float]:
    """Milliseconds from a slider's event to the first picture of a time after its change."""
    page.click("#run")
    until(page, f"{STATE.format(slot='a')} === 'computing'")
    page.focus("#control-circular_force")
    for k in range(moves):
        page.keyboard.press("ArrowRight" if k % 2 else "ArrowLeft")
        until(page, f"window.peristalsis.stats.lags.length > {k}")
    found: list[float] = page.evaluate("window.peristalsis.stats.lags")
    page.click("#stop")
    until(page, f"{STATE.format(slot='a')} === 'over'")
    return found


def first(page: Any, begin: float) -> None:
    """From the command to the first picture of a run."""
    page.click("#run")
    pressed = time.perf_counter()
    until(page, "window.peristalsis.stats.drawn > 1")
    print(f"first live picture after           {time.perf_counter() - begin:6.1f} s")
    print(f"  of which after pressing Run      {time.perf_counter() - pressed:6.1f} s")
    until(page, f"{STATE.format(slot='a')} === 'over'")


def grow(page: Any, process: int, runs: int) -> None:
    """Memory of the server and all its processes before and after so many runs."""
    print("memory before: {:.0f} MB in {} processes".format(*memory(process)))
    for k in range(runs):
        name = page.evaluate("window.peristalsis.shown.a")
        page.click("#run")
        until(page, f"window.peristalsis.shown.a !== {json.dumps(name)} && {STATE.format(slot='a')} === 'over'")
        if k % 10 == 9:
            page.wait_for_timeout(3000)
            print("after {} runs: {:.0f} MB in {} processes".format(k + 1, *memory(process)))


def pictures(browser: Any, address: str, folder: Path) -> None:
    """The page after a run at three sizes."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, (width, height) in SIZES.items():
        page = opened(browser, address, width, height, color_scheme="dark" if name == "projector" else "light")
        page.click("#run")
        until(page, f"{STATE.format(slot='a')} === 'over'")
        page.wait_for_timeout(300)
        page.screenshot(path=folder / f"{name}.png", full_page=name != "projector")
        page.context.close()


def main() -> None:
    """Measure and print."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--parts", default=",".join(PARTS), help="which of these, with commas between")
    words.add_argument("--runs", type=int, default=30)
    words.add_argument("--pictures", type=Path)
    options = words.parse_args()
    asked = options.parts.split(",")
    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if program is None:
        raise SystemExit("no Chromium is installed: apt-get install chromium")
    begin = time.perf_counter()
    command = [sys.executable, "-m", "peristalsis", "app", "--port", "0", "--no-browser"]
    environment = {**os.environ, "PYTHONUNBUFFERED": "1", "OMP_NUM_THREADS": "1"}
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    assert server.stdout is not None
    address = server.stdout.readline().split()[-1]
    print(f"load of the machine at the start: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    print(f"address printed after              {time.perf_counter() - begin:6.1f} s")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program, args=["--no-sandbox"])
        page = opened(browser, address, 1440, 900)
        print(f"page ready after                   {time.perf_counter() - begin:6.1f} s")
        if "first" in asked:
            first(page, begin)
        page.context.close()
        if "live" in asked:
            page = opened(browser, address, 1440, 900)
            for both in (False, True):
                drawn, received = live(page, both)
                print(f"{'two runs' if both else 'one run '}: pictures, frames a second {drawn:5.1f}, {received:5.1f}")
            print(f"one picture with all charts takes  {cost(page):6.1f} ms")
            page.context.close()
        if "lag" in asked:
            page = opened(browser, f"{address}#a.s.pacemaker=off&a.s.receptors=off&a.v.duration=60", 1440, 900)
            found = sorted(lags(page, 25))
            print(f"lag of a slider [ms]: median {statistics.median(found):.0f}, nine in ten below {found[22]:.0f}")
            page.context.close()
        if "memory" in asked:
            grow(opened(browser, f"{address}#a.grid=quick&a.v.duration=0.5", 1440, 900), server.pid, options.runs)
        if options.pictures:
            pictures(browser, address, options.pictures)
        browser.close()
    server.terminate()
    server.wait(30)


if __name__ == "__main__":
    main()
