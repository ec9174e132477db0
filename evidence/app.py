"""What the app costs on this machine: first picture, pictures a second, lag of a slider, memory after thirty runs.

    python evidence/app.py [--parts processor,first,live,lag,memory] [--runs 30] [--pictures FOLDER]

Needs the extras `app` and `browser` and the system's Chromium. Each part that is measured replaces its figures in
docs/evidence/app.json, and docs/evidence/app.md is written from them; with --pictures, the page as pictures.
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

from common import wrapped
from playwright.sync_api import sync_playwright

PARTS = ("processor", "first", "live", "lag", "memory")
KEPT = Path(__file__).resolve().parents[1] / "docs" / "evidence" / "app.json"
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


def first(page: Any, begin: float, ready: tuple[float, float]) -> dict[str, str]:
    """From the command to the address, to the page and to the first picture of a run; `ready`: the first two [s]."""
    page.click("#run")
    pressed = time.perf_counter()
    until(page, "window.peristalsis.stats.drawn > 1")
    seen = time.perf_counter()
    until(page, f"{STATE.format(slot='a')} === 'over'")
    return {
        "from the command to the printed address": f"{ready[0]:.1f} s",
        "to the page, ready to be used": f"{ready[1]:.1f} s",
        "to the first live picture": f"{seen - begin:.1f} s, of which {seen - pressed:.1f} s after pressing *Run*",
    }


def grow(page: Any, process: int, runs: int) -> dict[str, str]:
    """Memory of the server and all its processes before and after so many runs."""
    found = {"before the first of them": "{:.0f} MB in {} processes".format(*memory(process))}
    for k in range(runs):
        name = page.evaluate("window.peristalsis.shown.a")
        page.click("#run")
        until(page, f"window.peristalsis.shown.a !== {json.dumps(name)} && {STATE.format(slot='a')} === 'over'")
        if k % 10 == 9:
            page.wait_for_timeout(5000)
            found[f"after {k + 1} runs"] = "{:.0f} MB in {} processes".format(*memory(process))
            print(f"{k + 1} runs: {found[f'after {k + 1} runs']}", file=sys.stderr, flush=True)
    return found


def processor(pieces: int = 60) -> dict[str, str]:
    """Milliseconds of the processor for what a run in the app is made of, medians of many; no browser, no server."""
    import peristalsis as ps
    from peristalsis.app.frames import Camera
    from peristalsis.app.worker import PIECE

    simulation = ps.Simulation(ps.configuration("baseline"))
    camera = Camera.of(simulation)
    spent: dict[str, list[float]] = {"advance": [], "set": [], "take": []}

    def timed(what: str, call: Any) -> None:
        begin = time.process_time()
        call()
        spent[what].append(1000.0 * (time.process_time() - begin))

    simulation.advance("0.3 s")
    for k in range(pieces):
        timed("advance", lambda: simulation.advance(f"{PIECE} s"))
        timed("take", lambda: camera.take(simulation))
        if k % 4 == 0:
            pressure = f"{0.1 + 0.001 * k} kPa"
            timed("set", lambda pressure=pressure: simulation.set({"lumen.pressure": pressure}))
    middle = {what: statistics.median(times) for what, times in spent.items()}
    return {
        "20 ms of the run, shipped grid": f"{middle['advance']:.1f} ms",
        "a change of an input between two steps (`Simulation.set`)": f"{middle['set']:.1f} ms",
        "taking a frame": f"{middle['take']:.2f} ms",
    }


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


def browsed(browser: Any, address: str, process: int, asked: list[str], runs: int) -> dict[str, dict[str, str]]:
    """The figures of the parts that need the page, but for the first picture."""
    found: dict[str, dict[str, str]] = {}
    if "live" in asked:
        page = opened(browser, address, 1440, 900)
        rows = {}
        for both in (False, True):
            drawn, received = live(page, both)
            rows[f"pictures and frames a second, {'two runs' if both else 'one run'}"] = (
                f"{drawn:.1f} and {received:.1f}"
            )
        rows["drawing everything once"] = f"{cost(page):.1f} ms"
        found["live"] = with_load(rows)
        page.context.close()
    if "lag" in asked:
        page = opened(browser, f"{address}#a.s.pacemaker=off&a.s.receptors=off&a.v.duration=60", 1440, 900)
        times = sorted(lags(page, 25))
        said = f"{statistics.median(times):.0f} ms; nine in ten below {times[22]:.0f} ms"
        found["lag"] = with_load({"from a slider to its picture, median of 25": said})
        page.context.close()
    if "memory" in asked:
        page = opened(browser, f"{address}#a.grid=quick&a.v.duration=0.5", 1440, 900)
        found["memory"] = with_load(grow(page, process, runs))
        page.context.close()
    return found


def with_load(rows: dict[str, str]) -> dict[str, str]:
    """Figures with the load of the machine while they were measured."""
    return {**rows, "load": f"{os.getloadavg()[0]:.0f} on {os.cpu_count()} cores"}


HEAD = """# What the app costs

Measured by [`evidence/app.py`](../../evidence/app.py) in the system's Chromium, without a graphics
processor. Times on the clock hold for the load beside them: how many processes wanted a core, on the
mean of the minute before, the browser and the server among them. Times of the processor hold for any.
"""
TAIL = """
A slider waits for at most 30 ms to be sent, for the piece under way, for the change, and for the next
piece. Where the lag above is longer than their sum, the rest is the wait for a core.

The server keeps the frames of four runs a page (5 kB each, fifty a second of simulated time) and no
more, so its memory stays once these are there. A process that waits for the next run, or still stores
its result, is one more or less.

Hostile requests: 54 variants of host and origin, as requests and as WebSockets, all refused
(`tests/app/test_safety.py`). Accessibility: `tests/app/accessible.js` looks at every text for a
contrast of 4.5 to 1, every control for a name, a value and 24 pixels, headings, tables and references,
at 360, 1280 and 1920 pixels, light and dark: no finding.
"""
TITLES = {
    "first": "Beginning, on the clock",
    "live": "Pictures, on the clock",
    "lag": "Sliders, on the clock",
    "processor": "Times of the processor, medians",
    "memory": "Memory of the server and its processes, after runs of 0.5 s one after another",
}


def page_of(kept: dict[str, dict[str, str]]) -> str:
    """The page of all that was measured, in this and in earlier calls."""
    parts = [HEAD]
    for part, title in TITLES.items():
        if part in kept:
            load = kept[part].get("load", "")
            rows = [f"| {what} | {value} |" for what, value in kept[part].items() if what != "load"]
            parts += ["\n".join(["", f"| {title} | {f'load {load}' if load else ''} |", "|---|---|", *rows, ""])]
    return "".join([*parts, TAIL])


def main() -> None:
    """Measure, keep, write the page."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--parts", default=",".join(PARTS), help="which of these, with commas between")
    words.add_argument("--runs", type=int, default=30)
    words.add_argument("--pictures", type=Path)
    options = words.parse_args()
    asked = [part for part in options.parts.split(",") if part]
    program = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if program is None:
        raise SystemExit("no Chromium is installed: apt-get install chromium")
    found = {"processor": processor()} if "processor" in asked else {}
    begin = time.perf_counter()
    command = [sys.executable, "-m", "peristalsis", "app", "--port", "0", "--no-browser"]
    environment = {**os.environ, "PYTHONUNBUFFERED": "1", "OMP_NUM_THREADS": "1"}
    with (
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as server,
        sync_playwright() as driver,
    ):
        assert server.stdout is not None
        try:
            address = server.stdout.readline().split()[-1]
            printed = time.perf_counter() - begin
            browser = driver.chromium.launch(executable_path=program, args=["--no-sandbox"])
            page = opened(browser, address, 1440, 900)
            if "first" in asked:
                found["first"] = with_load(first(page, begin, (printed, time.perf_counter() - begin)))
            page.context.close()
            found |= browsed(browser, address, server.pid, asked, options.runs)
            if options.pictures:
                pictures(browser, address, options.pictures)
            browser.close()
        finally:
            server.terminate()
    kept = {**(json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}), **found}
    KEPT.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    KEPT.with_suffix(".md").write_text(wrapped(page_of(kept)), encoding="utf-8")
    print(page_of(found))


if __name__ == "__main__":
    main()
