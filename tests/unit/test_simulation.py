"""A run in pieces and in one, its status, its observers, and how it breaks off."""

from pathlib import Path

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.errors import ConfigurationError, DivergenceError
from peristalsis.inputs.config import Configuration
from peristalsis.running.simulation import Simulation
from verification.exact.runs import configured

COARSE = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 200,
    "grid.n_z_wall": 100,
    "run.duration": "0.2 s",
}


def coarse(**changes: object) -> Configuration:
    return configured(COARSE, changes)


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    """Equal values, nan with nan; texts (the kinds of events) are compared as texts."""
    return np.array_equal(a, b, equal_nan=a.dtype.kind == "f")


def test_pieces_give_the_same_bits_as_one_run() -> None:
    """R1: 0.2 s at once, and in uneven pieces that end inside of steps."""
    whole = Simulation(coarse())
    whole.run()
    pieces = Simulation(coarse())
    for piece in ("1 ms", "50 ms", "0.0305 s", "3 ms", "0.1155 s"):
        pieces.advance(piece)
    assert pieces.time == whole.time == pytest.approx(0.2)
    one, other = whole.result(), pieces.result()
    assert one.arrays.keys() == other.arrays.keys()
    for name in one.arrays:
        assert same_bits(one.arrays[name], other.arrays[name]), name


def test_two_runs_give_the_same_bits() -> None:
    """D1: nothing depends on what ran before in the process."""
    first, second = Simulation(coarse()).run(), Simulation(coarse()).run()
    for name in first.arrays:
        assert same_bits(first.arrays[name], second.arrays[name]), name


def test_output_cadence_does_not_change_the_run() -> None:
    often, seldom = (Simulation(configured(COARSE, {"output.interval": t})).run() for t in ("2 ms", "0.05 s"))
    assert np.array_equal(often.arrays["pellet_position"], seldom.arrays["pellet_position"])
    assert often.arrays["time"].size > seldom.arrays["time"].size


@pytest.mark.parametrize("bad", ["0 s", "-1 s", "soon"])
def test_time_must_go_forward(bad: str) -> None:
    with pytest.raises(ConfigurationError):
        Simulation(coarse()).advance(bad)


def test_progress_sees_every_step() -> None:
    seen: list[tuple[float, float]] = []
    run = Simulation(coarse(), progress=lambda t, z: seen.append((t, z)))
    run.advance("0.02 s")
    assert [t for t, _ in seen] == pytest.approx(np.arange(11) * 0.002)
    assert seen[-1][1] == run.pellet.position


def test_observer_can_stop_a_run() -> None:
    class Third:
        def start(self, model: object, state: object) -> None:
            pass

        def see(self, model: object, before: object, after: object, report: object) -> str | None:
            return "enough" if after.step == 3 else None  # type: ignore[attr-defined]

    run = Simulation(coarse(), observers=(Third(),))
    result = run.run()
    assert run.stopped == "enough"
    assert result.arrays["time_step"].size == 4


def test_run_that_breaks_off_keeps_its_history() -> None:
    """R5: status, a sentence, and every step up to the last good one, none of it nan."""
    run = Simulation(configured(COARSE, {"pacemaker.onset": "0.02 s", "pacemaker.intensity": "1000 uA/cm^2"}))
    result = run.run()
    assert result.status == "diverged"
    assert isinstance(run.failure, DivergenceError)
    assert result.error is not None
    assert "longitudinal potential" in result.error
    assert 10 <= result.arrays["time_step"].size < 100
    assert np.all(np.isfinite(result.arrays["pellet_position"]))


@pytest.mark.parametrize(
    ("changes", "status"),
    [({"pellet.enabled": False}, "finished"), ({"pellet.dry_friction": "1e5 mN"}, "arrested"), ({}, "in_transit")],
)
def test_status_says_what_became_of_the_pellet(changes: dict[str, object], status: str) -> None:
    assert Simulation(configured(COARSE, {"run.duration": "1.1 s"}, changes)).run().status == status


def test_expulsion_is_timed_within_the_step() -> None:
    """A short tube is left at once: the run stops, and transit is not a multiple of the step."""
    short = {
        "wall.length": "2.5 cm",
        "grid.n_z": 100,
        "grid.n_z_wall": 100,
        "run.duration": "2 s",
        "output.probes": ["1 cm"],
    }
    result = Simulation(configured(short)).run()
    assert result.status == "expelled"
    transit = float(result.summary["transit_s"])
    times, places = result.arrays["time_step"], result.arrays["pellet_position"]
    assert times[-2] < transit <= times[-1]
    assert places[-2] < 2.5 - 0.9 <= places[-1]


def test_no_file_is_written_by_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Simulation(coarse()).advance("4 ms")
    assert list(tmp_path.iterdir()) == []


def test_tables_of_gates_move_no_potential_of_a_run() -> None:
    """By at most 1e-4 mV; a front that came a step late would show as tens of millivolts."""
    changes = {"grid.n_z": 600, "grid.n_z_wall": 300, "run.duration": "0.8 s"}
    by_table, exact = (ps.run("baseline", changes | {"solver.exact_kinetics": e}) for e in (False, True))
    for name in ("potential_longitudinal", "potential_circular"):
        assert np.abs(by_table.arrays[name] - exact.arrays[name]).max() <= 1e-4
    assert np.abs(exact.arrays["potential_circular"]).min() < 1.0  # a front did pass
