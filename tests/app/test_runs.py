"""Runs behind the page, over its WebSocket and without a browser: frames, changes, limits, what goes with the page."""

import contextlib
import json
import os
import struct
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from peristalsis import scenarios
from peristalsis.app.asked import read
from peristalsis.running.simulation import Simulation

from .conftest import QUICK, Live

LONG = {"grid": "quick", "values": {"duration": 60.0}, "switches": {"pacemaker": False, "receptors": False}}
"""A run that does not end while a test looks at it."""


def unpacked(messages: list[bytes]) -> np.ndarray:
    """All frames of a run, (frames, numbers), from what the page got; their numbers follow one another."""
    rows: list[np.ndarray] = []
    for message in messages:
        first, size = struct.unpack("<II", message[8:16])
        assert first == len(rows)
        rows += list(np.frombuffer(message[16:], "<f4").reshape(-1, size // 4))
    return np.array(rows)


@pytest.fixture(scope="module")
def alone() -> Any:
    """The same short run without any app."""
    return Simulation(read(QUICK).configuration()).run()


def test_frames_are_those_of_the_run(page: Any, alone: Any) -> None:
    """Every number of the last frame against the run made without the app, and the outcome against its summary."""
    own = page()
    name = own.start()
    header = own.word("header", run=name)["header"]
    ended = own.word("ended", run=name)["outcome"]
    frames = unpacked(own.frames[name])
    assert frames.shape[0] == 51, "one at the start and fifty a second"
    np.testing.assert_allclose(frames[:, 0], np.arange(51) * 0.02, rtol=1e-6)
    arrays, last = alone.arrays, frames[-1]
    scalars = [one["name"] for one in header["scalars"]]
    for place, scalar in enumerate(scalars, start=1):
        np.testing.assert_allclose(last[place], arrays[scalar][-1], rtol=1e-5, atol=1e-6)
    at = 1 + len(scalars) + sum(len(names) for names in header["currents"].values())
    nodes = np.unique(np.rint(np.linspace(0, 240, header["nodes"])).astype(int))
    for field in ("radius", "axial_position", "contact_pressure"):
        np.testing.assert_allclose(last[at : at + nodes.size], arrays[field][-1, nodes, 0], rtol=1e-5, atol=1e-6)
        at += nodes.size
    for layer in ("longitudinal", "circular"):
        cells = np.unique(np.rint(np.linspace(0, 199, header["cells"])).astype(int))
        potential = arrays[f"potential_{layer}"][-1, cells, 0]
        np.testing.assert_allclose(last[at : at + cells.size], potential, rtol=1e-5)
        at += cells.size
    assert at == last.size
    assert ended["status"] == alone.status
    told = {one["key"]: one["value"] for one in ended["numbers"]}
    assert told["travel_cm"] == pytest.approx(alone.summary["travel_cm"])


def test_currents_are_those_of_the_figure(page: Any) -> None:
    """Against the figure's own function, which reads the record of a run at a probe at the same place."""
    from peristalsis.plots.figures.currents import currents_at

    own = page()
    name = own.start()
    header = own.word("header", run=name)["header"]
    own.word("ended", run=name)
    frames = unpacked(own.frames[name])
    configuration = read(QUICK).configuration().with_changes({"output.probes": [f"{header['probe']} cm"]})
    alone = Simulation(configuration).run()
    at = 1 + len(header["scalars"])
    steps = np.rint(frames[:, 0] / (alone.arrays["time_step"][1])).astype(int)
    for layer, names in header["currents"].items():
        expected = currents_at(alone, layer)
        for channel in names:
            np.testing.assert_allclose(frames[:, at], expected[channel][steps], rtol=2e-4, atol=1e-5)
            at += 1


def test_a_change_on_the_way_is_the_one_of_the_library(page: Any) -> None:
    """Paused, changed at a known time, and on: the same end as `Simulation.set` at that time gives."""
    own = page()
    name = own.start()
    own.word("header", run=name)
    own.say("order", run=name, order="pause")
    own.word("paused", run=name, paused=True)
    own.say("set", run=name, number=7, change={"values": {"viscous_friction": 60, "circular_force": 50}})
    changed = own.word("changed", run=name, number=7)
    own.say("order", run=name, order="resume")
    own.word("ended", run=name)
    last = unpacked(own.frames[name])[-1]
    simulation = Simulation(read(QUICK).configuration())
    simulation.advance(f"{changed['time']:.9g} s") if changed["time"] else None
    simulation.set({"pellet.viscous_friction": "60 mN*s/cm", "circular.active": 0.5})
    result = simulation.run()
    assert last[1] == pytest.approx(result.arrays["pellet_position"][-1], rel=1e-6)


def test_pause_step_and_stop(page: Any) -> None:
    own = page()
    name = own.start(LONG)
    own.word("header", run=name)
    own.say("order", run=name, order="pause")
    own.word("paused", run=name, paused=True)
    own.say("words", asked={}, number=1)
    own.word("words", number=1)
    before = unpacked(own.frames.get(name, [])).shape[0]
    own.say("order", run=name, order="step")
    own.say("order", run=name, order="stop")
    outcome = own.word("ended", run=name)["outcome"]
    assert outcome["stopped"]
    frames = unpacked(own.frames[name])
    assert frames.shape[0] - before <= 2, "no more than one step, and one that was on its way"
    assert frames[-1, 0] < 60.0


def test_refusals_are_sentences(page: Any) -> None:
    own = page()
    for number, said in enumerate(
        (
            {"do": "start", "slot": "a", "asked": {"scenario": "nothing"}},
            {"do": "start", "slot": "c", "asked": {}},
            {"do": "start", "slot": "a", "asked": {"values": {"pellet_diameter": 2.4, "tube_diameter": 1.0}, "x": 1}},
            {"do": "set", "run": "nothing", "change": {}},
            {"do": "order", "run": "nothing", "order": "stop"},
            {"do": "order", "run": "nothing", "order": "rm -rf"},
            {"do": "export", "run": "nothing", "what": "result"},
            {"do": "export", "run": "nothing", "what": "../../etc/passwd"},
            {"do": "judge", "lesson": "nothing", "runs": []},
            {"do": "judge", "lesson": "wave", "runs": ["nothing"]},
            {"do": "__init__"},
            {"do": ["start"]},
            {},
        )
    ):
        own.socket.send(json.dumps({**said, "number": number}))
        word = own.word("refused", number=number)
        assert word["text"].strip()
        assert "Traceback" not in word["text"]


@pytest.mark.parametrize("text", ["", "no JSON", "[]", "1", "[" * 9000, '{"do": NaN}', "null"])
def test_what_is_no_order_is_answered(page: Any, text: str) -> None:
    own = page()
    own.socket.send(text)
    assert own.word("refused")["text"]


def test_long_messages_end_the_conversation(page: Any) -> None:
    from websockets.exceptions import ConnectionClosed

    own = page()
    own.socket.send('{"do": "' + "x" * 20_000 + '"}')
    with pytest.raises(ConnectionClosed):
        own.word("refused")


def test_runs_are_limited_in_number(page: Any) -> None:
    """A run of a slot takes the place of the one that computes there, also where the page has not heard of that yet."""
    own, other = page(), page("page-of-another-tab")
    second = own.start(LONG, "b")
    for _ in range(2):  # a second press before the answer to the first
        own.say("start", slot="a", asked=LONG)
    first, _ = (own.word("started")["run"] for _ in range(2))
    if not any(word["kind"] == "cut" for word in own.heard):
        own.word("cut", run=first)
    other.say("start", slot="a", asked=LONG)
    assert "the limit is 2" in other.word("refused")["text"]
    own.say("start", slot="a", asked=LONG)
    third = own.word("started")["run"]
    for name in (second, third):
        own.word("header", run=name) if not any(
            word["kind"] == "header" and word["run"] == name for word in own.heard
        ) else None
        own.say("order", run=name, order="stop")
        own.word("ended", run=name)


def test_a_page_that_comes_back_finds_its_run_and_no_other_page_does(page: Any) -> None:
    own = page("page-that-reloads-1")
    name = own.start()
    own.word("header", run=name)
    own.close()
    other = page("page-of-another-tab")
    other.say("attach", run=name)
    assert other.word("gone")["run"] == name
    again = page("page-that-reloads-1")
    again.say("attach", run=name)
    again.word("ended", run=name)
    assert unpacked(again.frames[name]).shape[0] == 51, "all of it, from the start"


def test_runs_end_when_their_page_has_gone(page: Any, live: Live) -> None:
    """Its process is no more, and its name unknown, once the page has been waited for."""
    own = page("page-that-goes-away")
    name = own.start(LONG)
    own.word("header", run=name)
    before = _children(live.process)
    own.close()
    end = time.monotonic() + 30.0
    gone = False
    while not gone and time.monotonic() < end:
        # What is waited for is a timer of the server; a spare process may have taken the place of one that ended.
        gone = bool(before - _children(live.process))
    assert gone
    again = page("page-that-goes-away")
    again.say("attach", run=name)
    assert again.word("gone")["run"] == name


def _children(process: int) -> set[str]:
    place = Path(f"/proc/{process}/task")
    if not place.is_dir():
        pytest.skip("there is no /proc to see processes in")
    found: set[str] = set()
    for thread in place.iterdir():
        # A thread may end between its being listed and its being read.
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):
            found |= set(thread.joinpath("children").read_text(encoding="ascii").split())
    return found


def test_a_process_that_is_killed_takes_nothing_along(page: Any, live: Live) -> None:
    own = page()
    before = _children(live.process)
    name = own.start(LONG)
    own.word("header", run=name)
    busy = max(_children(live.process), key=lambda child: _seconds(int(child)))
    assert before or busy
    os.kill(int(busy), 9)
    assert "ended from outside" in own.word("failed", run=name)["text"]
    again = own.start()
    own.word("ended", run=again)


def _seconds(process: int) -> int:
    """Processor time of a process, in ticks: the one that computes has used most, for a spare only waits."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    state = fields[0]
    return int(fields[11]) + int(fields[12]) + (10**9 if state == "R" else 0)


def test_files(page: Any, live: Live, tmp_path: Path) -> None:
    """The stored result is the one that the library loads; figure and film are what they are called."""
    import shutil

    import peristalsis as ps

    own = page()
    name = own.start()
    own.word("ended", run=name)
    for what, begins in (("result", b"PK"), ("figure", b"\x89PNG"), ("film", b"GIF8")):
        own.say("export", run=name, what=what)
        ready = own.until(lambda word: word["kind"] == "export" and word["state"] != "working")
        assert ready["state"] == "ready", ready
        status, headers, body = live.get(ready["link"])
        assert status == 200
        assert body.startswith(begins)
        assert "attachment" in headers["content-disposition"]
        if what == "result":
            file = tmp_path / "result.zip"
            file.write_bytes(body)
            shutil.unpack_archive(file, tmp_path)
            assert ps.load(tmp_path / "result").configuration.digest() == read(QUICK).configuration().digest()


@pytest.mark.parametrize("soon", [False, True], ids=["under way", "before its first picture"])
def test_a_result_can_be_saved_on_the_way(page: Any, live: Live, soon: bool) -> None:
    """Asked for at once it comes as soon as there is one: on a slow machine a run takes seconds to begin."""
    own = page()
    name = own.start(LONG)
    if not soon:
        own.word("header", run=name)
    own.say("export", run=name, what="result")
    assert own.until(lambda word: word["kind"] == "export" and word["state"] != "working")["state"] == "ready"
    own.say("order", run=name, order="stop")
    own.word("ended", run=name)


def test_configuration_as_text(page: Any) -> None:
    own = page()
    own.say("words", asked={"scenario": "fig3f"}, number=3)
    told = own.word("words", number=3)
    from peristalsis.inputs.config import Configuration

    assert Configuration.from_toml(told["toml"]).digest() == scenarios.configuration("fig3f").digest()
    assert "ps.run('fig3f'" in told["python"]
