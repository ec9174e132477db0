"""A run to look through in a notebook: its numbers are the run's, and its slider moves what is shown."""

import html
import json
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.errors import ConfigurationError
from peristalsis.results.result import Result

COARSE = {"grid.n_z": 60, "grid.n_z_wall": 60, "step.wall": "10 ms", "run.duration": "0.5 s"}


@pytest.fixture(scope="module")
def result() -> Result:
    return ps.run("baseline", COARSE)


def content(text: str) -> Any:
    """What stands in the attribute of an explorer."""
    found = re.search(r'data-run="([^"]*)"', text)
    assert found is not None
    return json.loads(html.unescape(found[1]))


def test_numbers_are_those_of_the_run(result: Result) -> None:
    shown = result.plot.explore(frames=5)
    assert shown.frames == 5
    found = content(shown._repr_html_())
    times = np.array(found["time"])
    frames = [int(np.argmin(np.abs(result.arrays["time"] - time))) for time in times]
    radius = result.arrays["radius"][frames, :, 0]
    assert np.array(found["across"][0]) / 1000.0 == pytest.approx(radius, abs=6e-4)
    assert len(found["across"]) == 1, "one column is the same on both sides"
    places = np.interp(times, result.arrays["time_step"], result.arrays["pellet_position"])
    assert np.array(found["centre"]) / 1000.0 == pytest.approx(places, abs=6e-4)
    (push,) = (one for one in found["numbers"] if one["unit"] == "mN")
    assert push["values"] == pytest.approx(
        np.interp(times, result.arrays["time_step"], result.arrays["axial_force"]), rel=1e-3
    )


def test_it_asks_nothing_of_anyone(result: Result) -> None:
    """No address, no module, no kernel: it is the same in a notebook, on a page and without a network."""
    text = result.plot.explore()._repr_html_()
    assert not re.search(r"https?:|import |fetch\(|src=", text)
    assert len(text) < 80_000


def test_words_of_a_run_are_text(result: Result) -> None:
    """A scenario of a plugin may have any name."""
    named = replace(result, configuration=result.configuration.model_copy(update={"scenario": "<script>x</script>"}))
    assert "<script>x" not in named.plot.explore(frames=2)._repr_html_()


@pytest.mark.parametrize("frames", [0, -1, 401])
def test_frames_beyond_reason_are_refused(result: Result, frames: int) -> None:
    with pytest.raises(ConfigurationError, match="give 1 to 400"):
        result.plot.explore(frames=frames)


@pytest.mark.browser
def test_the_slider_moves_what_is_shown(result: Result, browser: Any) -> None:
    page = browser.new_page()
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.set_content(f"<!doctype html><body>{2 * result.plot.explore(frames=11)._repr_html_()}</body>")
    assert page.locator(".peristalsis-explorer[data-on]").count() == 2, "several on a page, each its own"
    pictures = "[...document.querySelectorAll('canvas')].map((one) => one.toDataURL())"
    before = page.evaluate(pictures)
    page.focus("input >> nth=0")
    page.keyboard.press("End")
    assert page.inner_text("output >> nth=0") == "0.50 s"
    assert page.get_attribute("input >> nth=0", "aria-valuetext") == "0.50 seconds"
    after = page.evaluate(pictures)
    assert [one != other for one, other in zip(before, after, strict=True)] == [True, True, False, False]
    last = f"{result.arrays['pellet_position'][-1]:.4g}"
    assert page.inner_text("table >> nth=0").split("\t")[1] == last
    page.click("canvas >> nth=1", position={"x": 50, "y": 2})
    assert page.inner_text("output >> nth=0") == "0.00 s"
    assert complaints == []
    page.close()
