"""Events and stop conditions: what happened when, and why a run ended."""

from __future__ import annotations

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.running.events import KINDS

COARSE = {"grid.n_z": 400, "grid.n_z_wall": 200, "output.interval": "50 ms"}


@pytest.fixture(scope="module")
def run() -> ps.Result:
    return ps.run("baseline", {**COARSE, "run.duration": "0.5 s"})


def events(result: ps.Result, kind: str) -> np.ndarray:
    return result.arrays["event_time"][result.arrays["event_kind"] == kind]


def test_kinds_are_known_and_times_are_in_order(run: ps.Result) -> None:
    assert set(run.arrays["event_kind"]) <= set(KINDS)
    assert (np.diff(run.arrays["event_time"]) >= 0.0).all()


def test_pacemaker_trigger_and_receptors(run: ps.Result) -> None:
    assert events(run, "pacemaker").tolist() == [0.0]
    assert 0.0 < events(run, "trigger")[0] < 0.1
    assert events(run, "receptors")[0] == pytest.approx(0.005)


def test_sticking_is_where_the_velocity_is_zero(run: ps.Result) -> None:
    """Between a stick and the next slip every velocity is exactly zero, and outside none is."""
    time, velocity = run.arrays["time_step"], run.arrays["pellet_velocity"]
    changes = sorted([(t, 1) for t in events(run, "slip")] + [(t, 0) for t in events(run, "stick")])
    assert changes
    slides = 0
    expected = np.zeros(time.size, bool)
    for k, t in enumerate(time):
        while changes and changes[0][0] <= t + 1e-9:
            slides = changes.pop(0)[1]
        expected[k] = bool(slides)
    assert np.array_equal(velocity != 0.0, expected)


def test_expelled_event_has_the_transit_time() -> None:
    short = {**COARSE, "wall.length": "3 cm", "grid.n_z": 200, "grid.n_z_wall": 100, "output.probes": ["1 cm"]}
    result = ps.run("baseline", {**short, "lumen.pressure": "0.1 kPa", "run.duration": "3 s"})
    assert result.status == "expelled"
    assert events(result, "expelled").tolist() == [result.summary["transit_s"]]


def test_stop_at_a_position() -> None:
    result = ps.run("baseline", {**COARSE, "run.stop_position": "1.3 cm", "run.duration": "2 s"})
    assert result.arrays["pellet_position"][-1] == pytest.approx(1.3, abs=0.01)
    assert result.status == "in_transit"
    assert "reached 1.3 cm" in result.arrays["event_words"][-1]


def test_events_survive_saving(run: ps.Result, tmp_path: object) -> None:
    loaded = ps.load(run.save(f"{tmp_path}/run"))
    for name in ("event_time", "event_kind", "event_words"):
        assert list(loaded.arrays[name]) == list(run.arrays[name])
