"""The page in a real browser: run, change, compare, learn, with the mouse and with the keyboard alone."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from .conftest import Live
from .visiting import IDLE, QUICK, Visit

pytestmark = pytest.mark.browser

FRAMES = "p.records.get(p.shown.a).frames.length"


def test_a_run_is_seen_while_it_computes(visit: Callable[..., Visit]) -> None:
    own = visit()
    page = own.open("a.grid=quick&a.v.duration=4")
    page.click("#run")
    own.state("a", "computing")
    first = own.number(FRAMES)
    pixels = "document.querySelector('#tubes canvas').toDataURL()"
    before = page.evaluate(pixels)
    own.until(f"window.peristalsis.records.get(window.peristalsis.shown.a).frames.length > {first + 10}")
    assert page.evaluate(pixels) != before
    own.state("a", "over")
    assert "left at the anal end" in page.inner_text("#status") or "on its way" in page.inner_text("#status")
    assert page.inner_text("#problem") == ""
    assert "Transit" in page.inner_text("#numbers") or "Travel of the pellet" in page.inner_text("#numbers")


def test_play_pause_step_and_scrub(visit: Callable[..., Visit]) -> None:
    own = visit()
    page = own.open(QUICK + IDLE)
    page.click("#run")
    own.state("a", "computing")
    page.click("#play")
    own.until("document.getElementById('play').textContent === 'Continue'")
    count = own.number(FRAMES)
    page.wait_for_timeout(300)
    assert own.number(FRAMES) == count, "nothing is computed while it is paused"
    page.click("#forward")
    own.until(f"window.peristalsis.records.get(window.peristalsis.shown.a).frames.length === {count + 1}")
    page.click("#back")
    own.until(f"Math.abs(document.getElementById('scrub').value - {0.02 * (count - 1):.2f}) < 1e-6")
    page.focus("#scrub")
    page.keyboard.press("Home")
    own.until("document.getElementById('clock').textContent === '0.00 s'")
    page.click("#live")
    page.click("#play")
    own.until(f"window.peristalsis.records.get(window.peristalsis.shown.a).frames.length > {count + 5}")
    page.click("#stop")
    own.state("a", "over")
    assert "stopped at" in page.inner_text("#status")
    page.click("#play")
    own.until("Number(document.getElementById('scrub').value) > 0.05")


def test_a_control_moved_on_the_way_is_felt(visit: Callable[..., Visit]) -> None:
    own = visit()
    page = own.open("a.grid=quick&a.v.duration=60&a.v.viscous_friction=1500&a.v.dry_friction=1000")
    page.click("#run")
    own.state("a", "computing")
    own.slide("pressure", "ArrowRight", 20)
    own.until("window.peristalsis.records.get(window.peristalsis.shown.a).changes.length > 0")
    own.until("window.peristalsis.stats.lags.length > 0")
    record = "p.records.get(p.shown.a)"
    own.until(
        "(() => { const r = window.peristalsis.records.get(window.peristalsis.shown.a);"
        " return r.scalar(r.frames.at(-1), 'lumen_pressure') > 0.8 })()"
    )
    assert own.number(f"{record}.scalar({record}.frames[0], 'lumen_pressure')") < 0.2
    page.click("#stop")
    own.state("a", "over")


def test_two_runs_and_the_ghost_of_the_last(visit: Callable[..., Visit]) -> None:
    own = visit()
    page = own.open(QUICK)
    page.check("input[name=slot][value=b]", force=True)
    page.fill("#control-viscous_friction + input", "900")
    page.press("#control-viscous_friction + input", "Enter")
    page.click("#run-both")
    own.state("a", "over")
    own.state("b", "over")
    assert page.locator("#tubes canvas").count() == 2
    assert page.locator("#maps canvas").count() == 2
    ends = [own.number(f"p.records.get(p.shown.{slot}).frames.at(-1)[1]") for slot in "ab"]
    assert ends[0] > ends[1] + 0.05, "the slippery pellet is ahead"
    page.click("#run")
    own.until("window.peristalsis.shown.ghostB !== null")
    own.state("b", "over")
    pixels = "[...document.querySelectorAll('#tubes canvas')].map((one) => one.toDataURL()).join()"
    shown = page.evaluate(pixels)
    page.uncheck("#ghost")
    own.until(f"{pixels} !== {shown!r}")


def test_a_run_pressed_away_at_once_is_no_ghost(visit: Callable[..., Visit]) -> None:
    own = visit()
    page = own.open(QUICK)
    page.click("#run")
    own.state("a", "over")
    first = page.evaluate("window.peristalsis.shown.a")
    for whole in (True, False):
        before = page.evaluate("window.peristalsis.shown.a")
        if not whole:  # as if it had been pressed away after two pictures
            page.evaluate("window.peristalsis.records.get(window.peristalsis.shown.a).frames.length = 2")
        page.click("#run")
        own.until(f"window.peristalsis.shown.a !== {before!r}")
        own.state("a", "over")
        assert page.evaluate("window.peristalsis.shown.ghostA") == first


def test_a_lesson(visit: Callable[..., Visit]) -> None:
    own = visit()
    page = own.open("")
    page.click("#open-lessons")
    assert page.locator("#lesson-list button").count() == 6
    page.click("#lesson-list li:nth-child(5) button")
    assert page.is_disabled("#lesson-run"), "a prediction comes first"
    page.check("input[name=guess][value=both]")
    page.click("#lesson-run")
    own.until("document.getElementById('lesson-answer').textContent.includes('predicted')", seconds=240)
    assert "Only with receptors" in page.inner_text("#lesson-answer")
    assert page.inner_text("#lesson-answer").startswith("Not as you predicted")


def test_by_the_keyboard_alone(visit: Callable[..., Visit]) -> None:
    """From the top of the page: choose a diameter, run, pause, look at the table."""
    own = visit()
    page = own.open(QUICK + IDLE)

    def tab_to(selector: str, most: int = 80) -> None:
        for _ in range(most):
            page.keyboard.press("Tab")
            if page.evaluate(f"document.activeElement.matches({selector!r})"):
                outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
                assert outline != "none", "where the focus is can be seen"
                return
        pytest.fail(f"{selector} is not reached by Tab")

    tab_to("#run")
    tab_to("#control-pellet_diameter")
    page.keyboard.press("ArrowRight")
    assert page.get_attribute("#control-pellet_diameter", "aria-valuetext") == "1.82 centimetres"
    page.keyboard.press("Enter")
    own.state("a", "computing")
    page.keyboard.press("Home")
    tab_to("#play")
    page.keyboard.press("Enter")
    own.until("document.getElementById('play').textContent === 'Continue'")
    tab_to("summary")
    page.keyboard.press("Enter")
    own.until("document.querySelectorAll('details.table td').length > 10")
    page.keyboard.press("Shift+Tab")
    assert own.number("p.records.get(p.shown.a).header.pellet_radius") == pytest.approx(0.91)
    page.click("#stop")
    own.state("a", "over")


def test_a_reload_keeps_the_run_and_another_tab_has_its_own(visit: Callable[..., Visit]) -> None:
    own = visit()
    page = own.open(QUICK + IDLE + "&a.v.pressure=0.3")
    page.click("#run")
    own.state("a", "computing")
    name = page.evaluate("window.peristalsis.shown.a")
    page.reload()
    page.wait_for_selector("html[data-ready]")
    own.state("a", "computing")
    assert page.evaluate("window.peristalsis.shown.a") == name
    assert page.input_value("#control-pressure + input") == "0.3", "the address keeps the controls"
    assert own.number("p.records.get(p.shown.a).frames[0][0]") == 0.0, "with all of its pictures"
    other = own.open(QUICK, own.tab())
    assert other.evaluate("window.peristalsis.records.size") == 0
    other.click("#run")
    own.state("a", "over", other)
    assert page.evaluate("window.peristalsis.shown.a") == name
    page.click("#stop")
    own.state("a", "over")


def test_errors_are_the_packages_own_sentences(visit: Callable[..., Visit]) -> None:
    own = visit()
    page = own.open(QUICK)
    page.fill("#control-pressure + input", "99")
    page.press("#control-pressure + input", "Enter")
    assert page.inner_text("#problem") == "Pressure in the lumen = 99: give a number from 0 to 5 kPa"
    assert page.get_attribute("#control-pressure + input", "aria-invalid") == "true"
    page.fill("#control-pressure + input", "1")
    page.press("#control-pressure + input", "Enter")
    assert page.inner_text("#problem") == ""


@pytest.mark.parametrize("width", [360, 1280, 1920])
@pytest.mark.parametrize("colours", ["light", "dark"])
def test_it_fits_and_can_be_read(visit: Callable[..., Visit], width: int, colours: str) -> None:
    """Nothing wider than the window; text against its paper as WCAG asks, 4.5 to 1; every control has a name."""
    own = visit(viewport={"width": width, "height": 800}, color_scheme=colours)
    page = own.open(QUICK)
    page.click("#run")
    own.state("a", "over")
    page.click("#open-lessons")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate("document.documentElement.dataset.theme") == colours
    assert page.evaluate((Path(__file__).parent / "accessible.js").read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    "state",
    [
        "a.scenario=<img src=x onerror=alert(1)>",
        "a.scenario=__proto__",
        "__proto__.v.pressure=1",
        "constructor.scenario=baseline",
        "a.v.pressure=1e999",
        "a.v.pressure=<script>alert(1)</script>",
        "a.s.pacemaker=javascript:alert(1)",
        "a.v.__proto__=1",
        "a.grid=../../etc/passwd",
        "%00%ff&&==&a",
        "a.v.pressure=1&" + "x" * 5000,
    ],
)
def test_a_hostile_permalink_does_nothing(visit: Callable[..., Visit], state: str) -> None:
    own = visit()
    own.page.on("dialog", lambda dialog: own.complaints.append(f"a dialog: {dialog.message}"))
    page = own.open(state)
    assert page.input_value("#scenario") == "baseline"
    assert page.evaluate("({}).v === undefined && ({}).scenario === undefined")
    assert page.locator("main img, main script").count() == 0


PAYLOADS = [
    f"{before}{core}{after}"
    for core in (
        "<img src=x onerror=hacked()>",
        "<script>hacked()</script>",
        "<svg/onload=hacked()>",
        "<a href=javascript:hacked()>x</a>",
        "<iframe srcdoc='<script>parent.hacked()</script>'></iframe>",
    )
    for before, after in (
        ("", ""),
        ('">', ""),
        ("'>", ""),
        ("</td>", "<td>"),
        ("</script>", ""),
        ("<!--", "-->"),
        ("${", "}"),
        ("{{", "}}"),
        ("\\u003c", ""),
        ("&lt;", "&gt;"),
    )
]


def test_words_of_the_server_are_text(visit: Callable[..., Visit]) -> None:
    """Fifty payloads as remark, note, error, name and label of what the server says: none is carried out."""
    assert len(PAYLOADS) == 50
    own = visit()
    page = own.open(QUICK)
    page.evaluate("void (window.hacked = () => { window.was = true })")
    page.click("#run")
    own.state("a", "over")
    for text in PAYLOADS:
        page.evaluate(
            """(text) => { const p = window.peristalsis; const r = p.records.get(p.shown.a);
            r.remarks = [text]; r.header.scenario = text; r.header.scalars[0].label = text;
            r.header.currents.circular[0] = text; r.outcome.words = text;
            p.hear({ kind: "refused", text }); p.hear({ kind: "words", toml: text, python: text });
            p.hear({ kind: "export", what: text, state: "failed", text }); }""",
            text,
        )
    page.wait_for_timeout(300)
    assert PAYLOADS[-1] in page.inner_text("#problem")
    assert not page.evaluate("window.was === true")
    assert page.locator("main img, main script, main iframe, main a[href^=javascript]").count() == 0


def test_another_page_gets_nothing(visit: Callable[..., Visit], live: Live, browser: Any) -> None:
    """A page of another origin in the same browser, with the cookie: no answer to read, no socket, no frame."""
    import http.server
    import threading

    class Evil(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!doctype html><title>x</title>")

        def log_message(self, *words: object) -> None:
            """Says nothing."""

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Evil) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        context = browser.new_context()
        page = context.new_page()
        page.goto(live.address)
        for host in ("127.0.0.1", "localhost"):
            page.goto(f"http://{host}:{server.server_address[1]}/")
            found = page.evaluate(
                """async ([own, token]) => {
                const tried = {};
                const say = async (name, call) => {
                  try { tried[name] = await call(); } catch { tried[name] = "refused"; } };
                const all = { credentials: "include" };
                await say("fetch", async () => (await fetch(`http://${own}/catalogue`, all)).status);
                const post = { method: "POST", body: "x" };
                await say("post", async () => (await fetch(`http://${own}/`, post)).status);
                await say("blind", async () => (await fetch(`http://${own}/catalogue`, { mode: "no-cors" })).type);
                await say("socket", () => new Promise((done) => {
                  const words = ["peristalsis.1", `token.${token}`];
                  const chat = new WebSocket(`ws://${own}/talk?page=page-of-the-tests-1`, words);
                  chat.onopen = () => done("open"); chat.onerror = () => done("refused"); }));
                await say("script", () => new Promise((done) => {
                  const made = document.createElement("script"); made.src = `http://${own}/assets/main.js`;
                  made.onload = () => done("loaded"); made.onerror = () => done("refused");
                  document.body.append(made); }));
                return tried; }""",
                [live.host, live.token],
            )
            assert found == dict.fromkeys(("fetch", "post", "blind", "socket", "script"), "refused")
        context.close()
        server.shutdown()


def test_no_network_is_needed(visit: Callable[..., Visit]) -> None:
    """With every other address cut off the page is the same; the fixture sees that none was asked for."""
    own = visit()
    own.context.route(lambda url: own.live.host not in url, lambda route: route.abort())
    page = own.open(QUICK)
    page.click("#run")
    own.state("a", "over")
    page.click("#python")
    own.until("document.getElementById('words').textContent.startsWith('import peristalsis as ps')")
    page.click("#toml")
    own.until("document.getElementById('words').textContent.includes('[grid]')")
    with page.expect_download(timeout=180_000) as waiting:
        page.click("[data-file=figure]")
    assert Path(waiting.value.path()).read_bytes().startswith(b"\x89PNG")
