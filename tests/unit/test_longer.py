"""A finished run made longer has the bits of one long run, and what has ended otherwise is refused in a sentence."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

import peristalsis as ps
from peristalsis.errors import ConfigurationError, WriteError
from peristalsis.inputs.config import ENDS
from peristalsis.results.result import Result
from peristalsis.running.simulation import Simulation
from peristalsis.storing.checkpoint import newest_of
from peristalsis.storing.store import LAST_STATE
from verification.exact.runs import configured

TINY: Mapping[str, object] = {
    "grid.n_z": 50,
    "grid.n_z_wall": 40,
    "step.wall": "4 ms",
    "step.conduction": "0.5 ms",
    "output.interval": "28 ms",
}
SHORT = {**TINY, "run.duration": "0.1 s"}  # no multiple of the interval: the end of it has a frame of its own
LONG = {**TINY, "run.duration": "0.24 s"}


@pytest.fixture(scope="module")
def long() -> Result:
    """The run that was never short."""
    return ps.run("baseline", LONG)


def test_a_finished_run_goes_on_to_the_same_bits(long: Result, tmp_path: Path) -> None:
    target = tmp_path / "run"
    short = ps.run("baseline", SHORT, out=target)
    assert short.arrays["time"][-1] == pytest.approx(0.1)
    steps: list[float] = []
    longer = ps.run("baseline", LONG, out=target, resume=True, progress=lambda time, place: steps.append(time))
    assert min(steps[1:]) > 0.1, "nothing is computed twice"
    assert longer.fingerprint == long.fingerprint
    assert ps.load(target).fingerprint == long.fingerprint
    assert ps.load(target).configuration.run.duration == 0.24
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
    assert (target / LAST_STATE).stat().st_size < 100_000, "what the result holds is not stored twice"


@pytest.mark.parametrize("kind", ["no pellet", "inertia", "protocol", "fields"])
def test_of_every_kind(kind: str, tmp_path: Path) -> None:
    more: Mapping[str, object] = {
        "no pellet": {"pellet.enabled": False, "output.probes": []},
        "inertia": {"wall.inertia": True, "run.stop_when_arrested": True},
        "protocol": {"protocols": ["lumen.pressure: ramp 0.1 kPa at 0 s, 0.3 kPa at 0.2 s"]},
        "fields": {"output.fields": ["potential_circular"]},
    }[kind]
    ps.run("baseline", {**SHORT, **more}, out=tmp_path / "run")
    longer = ps.run("baseline", {**LONG, **more}, out=tmp_path / "run", resume=True)
    assert longer.fingerprint == ps.run("baseline", {**LONG, **more}).fingerprint


def test_from_python_by_hand(long: Result, tmp_path: Path) -> None:
    ps.run("baseline", SHORT, out=tmp_path / "run")
    simulation = Simulation.resume(tmp_path / "run", changes={"run.duration": "0.24 s"})
    assert simulation.run().fingerprint == long.fingerprint
    with pytest.raises(ConfigurationError, match=r"only run\.duration, .* can change"):
        Simulation.resume(tmp_path / "run", changes={"lumen.pressure": "0.2 kPa"})
    with pytest.raises(ConfigurationError, match="not made shorter"):
        Simulation.resume(tmp_path / "run", changes={"run.duration": "0.05 s"})
    again = Simulation(ps.configuration("baseline", changes=SHORT))
    again.run()
    again.advance("0.14 s")  # advance goes on from where run ended
    assert again.time == pytest.approx(0.24)


def test_an_arrested_run_and_its_stop(tmp_path: Path) -> None:
    """One that lay still goes on; a stop condition taken away leaves no event behind, one that had held is refused."""
    target = tmp_path / "run"
    place = {"run.stop_position": "1.21 cm", "run.duration": "3 s"}
    stopped = ps.run("baseline", {**TINY, **place}, out=target)
    assert stopped.arrays["event_kind"][-1] == "stopped"
    until = stopped.summary["simulated_s"]
    assert until < 2.0
    on = {**TINY, "run.duration": f"{until + 0.1} s"}
    longer = ps.run("baseline", on, out=target, resume=True)
    assert longer.fingerprint == ps.run("baseline", on).fingerprint
    assert "stopped" not in longer.arrays["event_kind"]
    with pytest.raises(ConfigurationError, match="would have ended at t = "):
        ps.run("baseline", {**on, "run.stop_position": "1.205 cm"}, out=target, resume=True)
    still = ps.run("no_stimulation", {**TINY, "run.duration": "1.1 s"}, out=tmp_path / "still")
    assert still.status == "arrested"
    more = {**TINY, "run.duration": "1.2 s"}
    longer = ps.run("no_stimulation", more, out=tmp_path / "still", resume=True)
    assert longer.fingerprint == ps.run("no_stimulation", more).fingerprint


def test_what_cannot_be_made_longer_says_why(tmp_path: Path) -> None:
    target = tmp_path / "run"
    ps.run("baseline", SHORT, out=target)
    with pytest.raises(ConfigurationError, match=r"has come to t = 0\.1 s and is not made shorter"):
        ps.run("baseline", {**TINY, "run.duration": "0.04 s"}, out=target, resume=True)
    with pytest.raises(WriteError, match="another configuration"):
        ps.run("baseline", {**LONG, "lumen.pressure": "0.2 kPa"}, out=target, resume=True)
    content = bytearray((target / LAST_STATE).read_bytes())
    content[len(content) // 2] ^= 1
    (target / LAST_STATE).write_bytes(content)
    with pytest.raises(WriteError, match=r"without a usable last state .*--overwrite"):
        ps.run("baseline", LONG, out=target, resume=True)
    (target / LAST_STATE).unlink()
    assert ps.load(target).status == "in_transit", "it may be removed to save room"
    with pytest.raises(WriteError, match="without a usable last state"):
        ps.run("baseline", LONG, out=target, resume=True)
    assert ps.load(target).configuration.run.duration == 0.1


def test_a_last_state_of_another_result_is_refused(tmp_path: Path) -> None:
    ps.run("baseline", SHORT, out=tmp_path / "one")
    ps.run("baseline", {**TINY, "run.duration": "0.06 s"}, out=tmp_path / "other")
    (tmp_path / "one" / LAST_STATE).write_bytes((tmp_path / "other" / LAST_STATE).read_bytes())
    with pytest.raises(ConfigurationError, match="not of the result beside it"):
        ps.run("baseline", LONG, out=tmp_path / "one", resume=True)


def test_ends_are_parameters_and_change_nothing_else() -> None:
    one = configured(TINY)
    for key, value in zip(ENDS, ("7 s", False, True, "3 cm"), strict=True):
        other = one.with_changes({key: value})
        assert other.digest() != one.digest()
        assert other.digest(ends=False) == one.digest(ends=False)
    assert one.with_changes({"lumen.pressure": "0.2 kPa"}).digest(ends=False) != one.digest(ends=False)


def test_where_a_finished_run_stands(tmp_path: Path) -> None:
    ps.run("baseline", SHORT, out=tmp_path / "run")
    assert newest_of(tmp_path / "run").head.time == pytest.approx(0.1)
