"""Runs that are cut short anywhere and taken up again end with the bits of one that was not."""

from __future__ import annotations

import os
import signal
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest
from numpy.typing import NDArray
from typing_extensions import TypeAliasType

import peristalsis as ps
from peristalsis.errors import ConfigurationError, DamagedResult, WriteError
from peristalsis.inputs.config import Configuration
from peristalsis.results.result import CLOCK, Result
from peristalsis.running.observers import Callback
from peristalsis.running.runner import KeptRun
from peristalsis.running.simulation import Simulation
from peristalsis.storing import checkpoint, disk, environment
from peristalsis.storing.checkpoint import Checkpoints, Head, newest, newest_of
from peristalsis.storing.packing import pack, packable, unpack
from peristalsis.storing.store import CHECKPOINTS, Workspace, unfinished
from verification.exact.runs import configured

COARSE = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 60,
    "grid.n_z_wall": 40,
    "run.duration": "0.2 s",
    "output.interval": "20 ms",
}
KINDS: Mapping[str, Mapping[str, object]] = {
    "baseline": {},
    "wall inertia and moving friction": {"wall.inertia": True, "pellet.friction_frame": "wall"},
    "pacemaker cell": {"pacemaker.kind": "cell", "trigger.rule": "delay"},
    "protocols": {
        "protocols": [
            "lumen.pressure: ramp 0.1 kPa at 0 s, 0.3 kPa at 0.1 s",
            "longitudinal.slow_calcium: step 0.004 mS/cm^2 at 0 s, 0.006 mS/cm^2 at 0.05 s",
        ]
    },
    "pacemaker that changes": {
        "pacemaker.kind": "periodic",
        "pacemaker.period": "0.08 s",
        "trigger.rule": "pacemaker",
        "trigger.delay": "0.02 s",
        "protocols": [
            "pacemaker.period: ramp 0.08 s at 0 s, 0.055 s at 0.15 s",
            "trigger.duration: step 0.05 s at 0 s, 0.03 s at 0.09 s",
        ],
    },
    "gated trigger": {
        "trigger.gate": "stretch",
        "trigger.gate_delay": "0.05 s",
        "trigger.gate_duration": "0.02 s",
        "pellet.start_gap": "1 mm",
    },
    "finer ways": {"tissue.front_correction": "measured", "grid.exchange": "reconstructed"},
    "no pellet": {"pellet.enabled": False},
}


def coarse(changes: Mapping[str, object] | None = None) -> Configuration:
    return configured(COARSE, changes or {})


def same(one: Result, other: Result) -> None:
    """Every array, the summary but for the clock, and the fingerprint made of both."""
    assert one.arrays.keys() == other.arrays.keys()
    for name, values in one.arrays.items():
        assert np.array_equal(values, other.arrays[name], equal_nan=values.dtype.kind == "f"), name
    assert {k: v for k, v in one.summary.items() if k not in CLOCK} == {
        k: v for k, v in other.summary.items() if k not in CLOCK
    }
    assert one.fingerprint == other.fingerprint


def cut(configuration: Configuration, step: int, folder: Path) -> None:
    """A run that leaves nothing but its checkpoint at a step."""
    run = Simulation(configuration)
    run.advance(f"{step * run.model.dt_wall!r} s")
    assert run.state.step == step
    workspace = Workspace(folder, folder)
    Checkpoints(workspace).write(run.time, run.checkpoint())
    workspace.close()


# --- exactness --------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_a_resumed_run_is_the_uninterrupted_one_to_the_bit(kind: str, tmp_path: Path) -> None:
    """R1 at random steps; nothing of a checkpoint survives but the file."""
    configuration = coarse(KINDS[kind])
    whole = Simulation(configuration).run()
    steps = np.random.default_rng(list(KINDS).index(kind)).integers(1, 100, 3)
    for step in steps:
        folder = tmp_path / str(step)
        cut(configuration, int(step), folder)
        again = Simulation.resume(folder)
        assert again.state.step == step
        same(again.run(), whole)


@pytest.mark.slow
def test_exact_at_every_tenth_step_and_through_many_restarts(tmp_path: Path) -> None:
    """R1 through every phase of a whole passage, and through 40 restarts in one run."""
    changes = {
        "step.wall": "2 ms",
        "step.conduction": "0.25 ms",
        "grid.n_z": 200,
        "grid.n_z_wall": 100,
        "run.duration": "2 s",
        "run.stop_when_expelled": False,
    }
    configuration = configured(changes)
    whole = Simulation(configuration).run()
    for step in range(7, 1000, 100):
        cut(configuration, step, tmp_path / str(step))
        same(Simulation.resume(tmp_path / str(step)).run(), whole)
    run = Simulation(configuration)
    writer = Checkpoints(Workspace(tmp_path / "many", tmp_path / "many"))
    for _ in range(40):
        run.advance("0.05 s")
        writer.write(run.time, run.checkpoint())
        run = Simulation.resume(tmp_path / "many")
    same(run.run(), whole)


def test_changes_made_on_the_way_are_kept(tmp_path: Path) -> None:
    def advanced(run: Simulation) -> Simulation:
        run.set({"lumen.pressure": "0.2 kPa", "pellet.dry_friction": "5 mN"})
        run.advance("0.021 s")  # ends inside of a step: what is left of it belongs to the next piece
        return run

    def finished(run: Simulation) -> Result:
        run.advance("0.0305 s")
        return run.result()

    run = advanced(Simulation(coarse()))
    Checkpoints(Workspace(tmp_path, tmp_path)).write(run.time, run.checkpoint())
    again = Simulation.resume(tmp_path)
    assert again.configuration == run.configuration
    same(finished(again), finished(run))


@dataclass
class Highest:
    """An observer of plain data: the highest pressure so far."""

    pressure: float = 0.0
    seen: list[int] = field(default_factory=list)

    def start(self, model: object, state: object) -> None:
        self.seen.append(0)

    def see(self, model: object, before: object, after: object, report: object) -> str | None:
        self.pressure = max(self.pressure, after.pressure)  # type: ignore[attr-defined]
        self.seen.append(after.step)  # type: ignore[attr-defined]
        return "enough" if after.step == 30 else None  # type: ignore[attr-defined]


def test_observers_of_plain_data_go_on(tmp_path: Path) -> None:
    run = Simulation(coarse(), observers=(Highest(),))
    run.advance("0.02 s")
    Checkpoints(Workspace(tmp_path, tmp_path)).write(run.time, run.checkpoint())
    observer = Highest()
    again = Simulation.resume(tmp_path, observers=(observer,), progress=lambda time, place: None)
    again.run()
    assert observer.seen == list(range(31))
    assert again.stopped == "enough"
    with pytest.raises(ConfigurationError, match="cannot be taken up"):
        Simulation.resume(tmp_path, observers=(Highest(), Highest()))


def test_no_recorder_of_the_package_is_left_out() -> None:
    """One that could not be packed would begin anew unseen."""
    run = Simulation(coarse())
    assert len(run._kept_observers()) == len(run._observers) == 7


def test_a_run_that_had_stopped_stays_stopped(tmp_path: Path) -> None:
    run = Simulation(coarse(), observers=(Highest(),))
    run.run()
    Checkpoints(Workspace(tmp_path, tmp_path)).write(run.time, run.checkpoint())
    again = Simulation.resume(tmp_path, observers=(Highest(),))
    again.run()
    assert again.state.step == 30


# --- which checkpoint -------------------------------------------------------------------------------


def test_the_newest_counts_and_the_older_one_stands_in(tmp_path: Path) -> None:
    """R2: a damaged checkpoint costs one interval and is named; two damaged ones cost the run."""
    run = Simulation(coarse())
    writer = Checkpoints(Workspace(tmp_path, tmp_path))
    for _ in range(3):
        run.advance("0.02 s")
        writer.write(run.time, run.checkpoint())
    found = newest(tmp_path)
    assert found is not None
    assert (found.head.step, found.file.name, found.remarks) == (30, CHECKPOINTS[0], ())
    content = bytearray(found.content)
    content[len(content) // 2] ^= 1
    found.file.write_bytes(content)
    older = newest(tmp_path)
    assert older is not None
    assert older.head.step == 20
    assert "damaged" in older.remarks[0]
    again = Simulation.resume(tmp_path)
    assert older.remarks[0] in again.remarks
    (tmp_path / CHECKPOINTS[1]).write_bytes(b"")
    with pytest.raises(ConfigurationError, match="no whole checkpoint"):
        newest_of(tmp_path)


def test_every_changed_byte_of_a_checkpoint_is_noticed(tmp_path: Path) -> None:
    cut(coarse(), 3, tmp_path)
    file = tmp_path / CHECKPOINTS[0]
    whole = file.read_bytes()
    random = np.random.default_rng(1)
    for place in random.integers(0, len(whole), 200):
        changed = bytearray(whole)
        changed[place] ^= 1 << random.integers(8)
        file.write_bytes(changed)
        assert newest(tmp_path) is None
    for length in random.integers(0, len(whole), 50):
        file.write_bytes(whole[:length])
        assert newest(tmp_path) is None


def test_a_checkpoint_of_another_run_or_code_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cut(coarse(), 3, tmp_path)
    with pytest.raises(ConfigurationError, match="another configuration"):
        Simulation(coarse({"pellet.dry_friction": "5 mN"})).restore(newest_of(tmp_path))
    monkeypatch.setattr("peristalsis.running.simulation.code_version", lambda: "0.0.1-elsewhere")
    with pytest.raises(ConfigurationError, match=r"0\.0\.1-elsewhere"):
        Simulation.resume(tmp_path)


def test_another_machine_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cut(coarse(), 3, tmp_path)
    monkeypatch.setattr("peristalsis.running.simulation._hash_of_start", lambda model, state: "other bits")
    assert "another machine" in Simulation.resume(tmp_path).remarks[-1]


def test_when_checkpoints_are_due(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(checkpoint.time, "monotonic", lambda: now[0])
    by_time = Checkpoints(Workspace(tmp_path, tmp_path), simulated=0.1)
    assert [by_time.due(t) for t in (0.05, 0.0998, 0.1)] == [False, False, True]
    by_time.write(0.1, b"")
    assert [by_time.due(t) for t in (0.1, 0.1998, 0.2)] == [False, False, True]
    by_clock = Checkpoints(Workspace(tmp_path, tmp_path), every=10.0)
    now[0] = 9.9
    assert not by_clock.due(5.0)
    now[0] = 10.0
    assert by_clock.due(5.0)

    def slow(name: str, content: bytes) -> None:
        now[0] += 2.0

    monkeypatch.setattr(by_clock.workspace, "write", slow)
    by_clock.write(5.0, b"")
    now[0] += 39.9
    assert not by_clock.due(6.0), "two seconds of writing are a twentieth of forty"
    now[0] += 0.2
    assert by_clock.due(6.0)


# --- runs kept in a folder --------------------------------------------------------------------------


def test_run_with_out_and_resume(tmp_path: Path) -> None:
    """Stored, taken up again from what was left, and not run a second time when finished."""
    target = tmp_path / "out" / "run"
    changes = {**COARSE, "run.checkpoint": "0.03 s"}
    whole = ps.run("baseline", changes)
    kept = KeptRun(ps.configuration("baseline", changes=changes), target)
    begun = kept.begin()
    begun._advance_to(0.11)  # and the process is killed here
    kept.workspace.close()
    (left,) = unfinished(target)
    assert {path.name for path in left.iterdir()} == {"lock", *CHECKPOINTS}
    said: list[str] = []
    seen: list[float] = []
    again = KeptRun(ps.configuration("baseline", changes=changes), target, resume=True, say=said.append)
    with again:
        result = again.begin(lambda time, place: seen.append(time)).run()
        again.save(result)
    assert said[0].startswith("resumed at t = 0.09 s")
    assert min(seen[1:]) > 0.09
    same(result, whole)
    assert [path.name for path in target.parent.iterdir()] == ["run"], "nothing hidden may stay"
    assert not any((target / name).exists() for name in CHECKPOINTS)
    same(ps.run("baseline", changes, out=target, resume=True), whole)
    with pytest.raises(WriteError, match="exists"):
        ps.run("baseline", changes, out=target)
    with pytest.raises(WriteError, match="another configuration"):
        ps.run("baseline", {**changes, "pellet.dry_friction": "5 mN"}, out=target, resume=True)


def test_an_interrupted_result_is_taken_up_from_its_own_checkpoint(tmp_path: Path) -> None:
    """Ctrl-C stores the history; --resume goes on from the very step."""
    configuration = coarse()
    whole = Simulation(configuration).run()
    with KeptRun(configuration, tmp_path / "run") as kept:
        simulation = kept.begin()

        def stop(time: float, place: float) -> None:
            if simulation.state.step == 37:
                os.kill(os.getpid(), signal.SIGINT)

        simulation._observers.append(Callback(stop))
        result = simulation.run()
        kept.save(result)
    assert result.status == "interrupted"
    assert ps.load(tmp_path / "run").status == "interrupted"
    assert (tmp_path / "run" / CHECKPOINTS[0]).exists()
    said: list[str] = []
    with KeptRun(configuration, tmp_path / "run", resume=True, say=said.append) as kept:
        again = kept.begin().run()
        kept.save(again)
    assert said[0].startswith("resumed at t = 0.074 s")
    same(again, whole)
    same(ps.load(tmp_path / "run"), whole)


def test_nothing_to_resume_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    run = KeptRun(coarse(), tmp_path / "run", resume=True, say=said.append)
    assert said[0].startswith("nothing to resume")
    assert run.finished is None
    run.workspace.close()
    cut(coarse(), 3, tmp_path / ".tmp-run-0123456789abcdef")
    monkeypatch.setattr("peristalsis.running.runner.code_version", lambda: "0.0.1-elsewhere")
    KeptRun(coarse(), tmp_path / "run", resume=True, say=said.append)
    assert "is not used" in said[1]


def test_two_processes_do_not_work_in_one_folder(tmp_path: Path) -> None:
    """Who resumes a run that is still going is refused, and disturbs nothing."""
    cut(coarse(), 3, tmp_path / ".tmp-run-0123456789abcdef")
    first = KeptRun(coarse(), tmp_path / "run", resume=True)
    with pytest.raises(WriteError, match="another process"):
        KeptRun(coarse(), tmp_path / "run", resume=True)
    with first:
        first.save(first.begin().run())
    assert ps.load(tmp_path / "run").summary["steps"] == 100


def test_what_others_left_is_removed_only_if_it_is_worth_nothing(tmp_path: Path) -> None:
    cut(coarse(), 3, tmp_path / ".tmp-run-000000000000000a")  # of the same run: the result holds all of it
    cut(coarse({"pellet.dry_friction": "5 mN"}), 3, tmp_path / ".tmp-run-000000000000000b")  # of another
    cut(coarse(), 3, tmp_path / ".tmp-run-000000000000000c")  # somebody works here
    busy = Workspace(tmp_path / "run", tmp_path / ".tmp-run-000000000000000c")
    busy.open()
    with KeptRun(coarse(), tmp_path / "run") as kept:
        kept.save(kept.begin().run())
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == [".tmp-run-000000000000000b", ".tmp-run-000000000000000c", "run"]
    busy.close()


def test_a_checkpoint_that_cannot_be_written_costs_no_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """R9: said once; the run goes on, and is stored when there is room again."""

    def full(path: Path, content: bytes) -> None:
        raise OSError(28, "No space left on device")

    said: list[str] = []
    configuration = coarse({"run.checkpoint": "0.02 s"})
    with KeptRun(configuration, tmp_path / "run", say=said.append) as kept:
        with monkeypatch.context() as patched:
            patched.setattr(disk.DISK, "write", full)
            result = kept.begin().run()
        kept.save(result)
    assert len(said) == 1
    assert "No space left" in said[0]
    assert "the run goes on" in said[0]
    same(ps.load(tmp_path / "run"), Simulation(configuration).run())


def test_a_damaged_result_is_not_resumed_over(tmp_path: Path) -> None:
    ps.run("baseline", COARSE, out=tmp_path / "run")
    (tmp_path / "run" / "result.nc").write_bytes(b"")
    with pytest.raises(DamagedResult, match="quarantine"):
        ps.run("baseline", COARSE, out=tmp_path / "run", resume=True)


# --- packing ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Everything:
    """One field of every kind that can be packed."""

    number: float
    count: int
    switch: bool
    text: str
    maybe: float | None
    never: str | None
    pair: tuple[int, str]
    many: tuple[float, ...]
    rows: list[tuple[float, ...]]
    uneven: list[tuple[float, ...]]
    table: dict[str, list[np.ndarray]]
    array: np.ndarray
    empty: list[int]
    flags: np.ndarray


def test_every_kind_comes_back_to_the_bit() -> None:
    value = Everything(
        number=-0.0,
        count=10**15,
        switch=True,
        text="λ = 'one'\n",
        maybe=float("inf"),
        never=None,
        pair=(3, "three"),
        many=(0.1, float("nan"), 5e-324),
        rows=[(1.0, 0.1), (2.0, float("-inf"))],
        uneven=[(1.0,), (2.0, 3.0)],
        table={"a": [np.arange(3.0), np.ones(3)], "b": [np.zeros((2, 0)), np.arange(2)], "c": []},
        array=np.array([[np.nan, -0.0], [1e-320, 1.0]]),
        empty=[],
        flags=np.array([True, False]),
    )
    back = unpack(pack({"it": (value, Everything)}), {"it": Everything})["it"]
    assert repr(back) == repr(value)
    assert back.array.tobytes() == value.array.tobytes()
    assert np.signbit(back.number)
    assert pack({"it": (back, Everything)}) == pack({"it": (value, Everything)})


@dataclass(frozen=True)
class Lost:
    """Its type is named and nowhere to be found."""

    number: Nowhere  # type: ignore[name-defined]  # noqa: F821


@pytest.mark.parametrize("kind", [object, list, dict[int, float], float | int, tuple[object, ...], "Missing", Lost])
def test_other_kinds_are_refused(kind: object) -> None:
    assert not packable(kind)
    with pytest.raises(TypeError):
        pack({"it": (1.0, kind)})


Item = TypeVar("Item")
Other = TypeVar("Other")
Shorthand = TypeAliasType("Shorthand", np.ndarray[tuple[int, ...], np.dtype[Item]], type_params=(Item,))
Doubly = TypeAliasType("Doubly", Shorthand[np.float64])
Swapped = TypeAliasType("Swapped", tuple[Other, Item], type_params=(Item, Other))


@dataclass
class Named:
    """Annotated as numpy annotates arrays from release 2.5 on: by aliases that have a name of their own."""

    array: Shorthand[np.float64]
    plain: Doubly
    several: list[Shorthand[np.float64]]
    perhaps: Shorthand[np.int64] | None
    pair: Swapped[int, str]


def test_named_aliases_are_what_they_name() -> None:
    """numpy 2.5 made NDArray such an alias, and no state could be packed; this holds on any release of it."""
    rows = [np.arange(3.0), np.arange(3.0) + 1.0]
    whole = Named(rows[0], rows[1], rows, None, ("a", 1))
    assert packable(Named)
    back = unpack(pack({"it": (whole, Named)}), {"it": Named})["it"]
    assert back.pair == ("a", 1)
    assert back.perhaps is None
    assert np.array_equal([back.array, back.plain, *back.several], [*rows, *rows])


@pytest.mark.parametrize("kind", [NDArray[np.float64], NDArray[Any], NDArray, np.ndarray])
def test_arrays_are_packable_however_annotated(kind: Any) -> None:
    assert packable(kind)


def test_aliases_of_other_things_are_not_packable() -> None:
    assert not packable(TypeAliasType("Wrong", object))


def test_objects_are_never_packed_and_never_made() -> None:
    """S4: no array of objects goes in; types come from the reader alone."""
    with pytest.raises(TypeError, match="objects"):
        pack({"it": (np.array([object()]), np.ndarray)})
    content = pack(
        {"it": (1.0, float), "text": ("x", str), "pair": ((1, "a"), tuple[int, str]), "point": (Highest(), Highest)}
    )
    for hints in (
        {"point": Everything},
        {"other": float},
        {"it": int},
        {"text": int},
        {"text": Everything},
        {"pair": tuple[int, str, int]},
    ):
        with pytest.raises(ValueError):  # noqa: PT011
            unpack(content, hints)


def test_the_code_is_named_by_version_and_sources() -> None:
    assert environment.code_version().startswith(f"{ps.__version__}-")


def test_a_checkpoint_of_a_version_without_tables_is_named(tmp_path: Path) -> None:
    """It holds no tables, which is no reason for a traceback: its version is."""
    head = replace(Simulation(coarse())._parts()["head"][0], code="an older one")
    (tmp_path / CHECKPOINTS[0]).write_bytes(pack({"head": (head, Head)}))
    with pytest.raises(ConfigurationError, match="written by version an older one"):
        Simulation.resume(tmp_path)
