"""Batches: planned before anything runs, equal whatever the workers and the order, taken up where they were cut."""

from __future__ import annotations

import csv
import os
import re
import shutil
import signal
from pathlib import Path

import pytest

import peristalsis as ps
from peristalsis.cli import main
from peristalsis.errors import ConfigurationError, DivergenceError, InterruptedRun, UnknownKeyError, WriteError
from peristalsis.inputs.config import Configuration
from peristalsis.many import batch as batches
from peristalsis.many.batch import Batch, batch
from peristalsis.many.plan import MOST_POINTS, Plan, read_plan
from peristalsis.many.rows import Point, Row, Step, key_of
from peristalsis.many.table import table as table_of
from peristalsis.running.simulation import Simulation
from peristalsis.storing import disk, store
from peristalsis.storing.checkpoint import Checkpoints
from verification.exact.runs import configured

TINY = """
[changes]
grid.n_z = 40
grid.n_z_wall = 40
step.wall = "2 ms"
step.conduction = "0.25 ms"
run.duration = "0.04 s"
output.interval = "20 ms"
"""
GRID = (
    TINY
    + """
[grid]
pellet.dry_friction = ["1 mN", "3 mN", "5 mN"]
"""
)
POINTS = (
    TINY
    + """
[[points]]
name = "thin"
pellet.viscous_friction = "20 mN*s/cm"
[[points]]
pellet.radius = "2 cm"
[[points]]
name = "same"
pellet.viscous_friction = "20 mN*s/cm"
[[points]]
name = "none"
scenario = "no_stimulation"
reading = "stretched"
"""
)


def contents(made: Batch) -> dict[str, str]:
    """Name and fingerprint of every run."""
    return {str(row.folder and row.folder.name): row.fingerprint for row in made.rows}


def table(made: Batch) -> list[dict[str, str]]:
    with made.table.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Batch:
    """The grid, carried out in one process."""
    return batch(read_plan(GRID), tmp_path_factory.mktemp("done"))


@pytest.fixture
def copied(done: Batch, tmp_path: Path) -> Path:
    """A folder with the same runs, to be spoilt."""
    return Path(shutil.copytree(done.table.parent, tmp_path / "copied"))


# --- plans ------------------------------------------------------------------------------------------


def test_a_grid_is_every_combination() -> None:
    axes = '[grid]\npellet.dry_friction = ["5 mN", "9 mN"]\npellet.viscous_friction = ["60 mN*s/cm", "230 mN*s/cm"]'
    plan = read_plan(TINY + axes)
    assert plan.keys == ("pellet.dry_friction", "pellet.viscous_friction")
    assert [tuple(point.values.values()) for point in plan.points] == [
        ("5 mN", "60 mN*s/cm"),
        ("5 mN", "230 mN*s/cm"),
        ("9 mN", "60 mN*s/cm"),
        ("9 mN", "230 mN*s/cm"),
    ]
    first = plan.points[0].configuration
    assert first is not None
    assert (first.pellet.dry_friction, first.pellet.viscous_friction, first.grid.n_z) == (5.0, 60.0, 40)
    assert len({key_of(point.configuration, "code") for point in plan.points}) == 4
    assert key_of(plan.points[0].configuration, "code") != key_of(plan.points[0].configuration, "other code")


def test_points_have_names_and_may_be_of_any_scenario_and_reading() -> None:
    plan = read_plan(POINTS)
    thin, refused, same, none = plan.points
    assert thin.name == "thin"
    assert refused.configuration is None
    assert "the tube cannot hold this pellet" in str(refused.refusal)
    assert same.configuration == thin.configuration
    assert none.configuration is not None
    assert (none.configuration.scenario, none.configuration.reading) == ("no_stimulation", "stretched")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[grid]", "no parameter is varied"),
        ("grid = 1", "grid: 1 is not a table"),
        ("[grid]\npellet = 1", "'pellet' is not a parameter"),
        ("[grid]\nlumen.pressure = '0.1 kPa'", "give a list of its values"),
        ("[grid]\nlumen.pressure = []", "give a list of its values"),
        ("[grid]\nlumen.presure = ['0.1 kPa']", "did you mean lumen.pressure"),
        ("[grid]\nlumen.pressure = ['0.1 kPa']\n[[points]]\nname = 'a'", "give one of the two"),
        ("scenario = 'baseline'", "give one of the two"),
        ("points = []", "not a list of tables"),
        ("points = [1]", "points, number 1: 1 is not a table"),
        ("[[points]]\nname = '../up'", "a name has lower-case letters"),
        ("[[points]]\nname = 1", "a name has lower-case letters"),
        ("[[points]]\nname = 'a'\n[[points]]\nname = 'a'", "given twice"),
        ("[points]\nname = 'a'", "not a list of tables"),
        ("workers = 2\n[grid]\nrun.duration = ['1 s']", "'workers' is no part of a batch"),
        ("scenario = 'basline'\n[[points]]\nname = 'a'", "did you mean baseline"),
        ("reading = 'tihgt'\n[[points]]\nname = 'a'", "did you mean tight"),
        ("[grid]\nreading = [1]", "give a name as text"),
        ("[changes]\n'run.duration' = '1 s'\nrun.duration = '2 s'\n[[points]]\nname = 'a'", "given twice"),
        ("[grid]\npellet.radius = ['2 cm', '-1 cm']", "every point of the batch is refused, the first one: pellet"),
        ("changes = 3\n[[points]]\nname = 'a'", "changes: 3 is not a table"),
        ("grid = {" + "a = {" * 3000, "not valid TOML"),
        ("# " + "x" * 2_000_000, "more than"),
    ],
)
def test_a_bad_file_is_refused_before_anything_runs(text: str, said: str) -> None:
    with pytest.raises(ConfigurationError, match=re.escape(said)):
        read_plan(text)


def test_too_many_points_are_refused_before_they_are_made() -> None:
    """S6: a million points cost nothing."""
    values = ", ".join(f'"{number} mN"' for number in range(1000))
    with pytest.raises(ConfigurationError, match=f"1000000 points, more than {MOST_POINTS}"):
        read_plan(f"[grid]\npellet.dry_friction = [{values}]\npellet.viscous_friction = [{values}]")
    many = "\n".join("[[points]]" for _ in range(MOST_POINTS + 1))
    with pytest.raises(ConfigurationError, match="10001 points"):
        read_plan(many)


def test_an_unknown_name_of_one_point_spoils_the_file() -> None:
    with pytest.raises(UnknownKeyError):
        read_plan("[[points]]\nname = 'a'\n[[points]]\nlumen.presure = '1 kPa'")


# --- runs -------------------------------------------------------------------------------------------


def test_a_batch_is_run_once_and_tabled(tmp_path: Path) -> None:
    plan = tmp_path / "friction.toml"
    plan.write_text(POINTS, encoding="utf-8")
    steps: list[Step] = []
    made = batch(plan, tmp_path / "out", progress=steps.append)
    assert [row.status for row in made.rows] == ["in_transit", "refused", "in_transit", "in_transit"]
    assert made.rows[0].folder == made.rows[2].folder
    assert [(step.done, step.count, step.kept) for step in steps] == [(n, 4, False) for n in range(1, 5)]
    rows = table(made)
    assert [row["name"] for row in rows] == ["thin", "run", "same", "none"]
    assert rows[0]["pellet.viscous_friction"] == "20 mN*s/cm"
    assert rows[1]["status"] == "refused"
    assert "cannot hold this pellet" in rows[1]["error"]
    assert float(rows[0]["final_position_cm"]) == made.rows[0].summary["final_position_cm"]
    assert not {"solver_wall_s", "compile_wall_s"} & rows[0].keys()
    stored = ps.load(made.table.parent / rows[0]["folder"])
    assert stored.fingerprint == rows[0]["fingerprint"]
    assert rows[0]["remarks"] == " | ".join(stored.remarks)
    assert "are coarse for a wave" in rows[0]["remarks"]
    before = made.table.read_bytes()
    steps.clear()
    again = batch(plan, tmp_path / "out", progress=steps.append)
    assert [step.kept for step in steps if step.row.folder] == [True] * 3
    assert again.table.read_bytes() == before


def test_neither_workers_nor_order_change_a_bit(done: Batch, tmp_path: Path) -> None:
    """D1: one process, and two processes with the points the other way round."""
    plan = read_plan(GRID)
    back = batch(Plan(plan.points[::-1], plan.keys), tmp_path, workers=2)
    assert contents(done) == contents(back)
    assert len(set(contents(done).values())) == 3
    assert sorted(done.table.read_bytes().splitlines()) == sorted(back.table.read_bytes().splitlines())


def test_what_was_cut_short_goes_on_from_its_checkpoint(
    done: Batch, copied: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = read_plan(GRID)
    for point in plan.points[1:]:
        shutil.rmtree(copied / "runs" / key_of(point.configuration))
    folder = copied / "runs" / key_of(plan.points[1].configuration)
    configuration = plan.points[1].configuration
    assert configuration is not None
    run = Simulation(configuration)
    run.advance("0.03 s")
    workspace = store.Workspace(folder)
    Checkpoints(workspace).write(run.time, run.checkpoint())
    workspace.close()
    steps: list[int] = []
    seen = Simulation._step
    monkeypatch.setattr(Simulation, "_step", lambda self: (steps.append(self.state.step), seen(self))[1])
    assert contents(batch(plan, copied)) == contents(done)
    assert steps.count(15) == 2
    assert steps.count(14) == 1, "the steps before the checkpoint are not made again"
    assert not list((copied / "runs").glob(".tmp-*"))


def test_a_damaged_run_is_moved_aside_and_run_again(done: Batch, copied: Path) -> None:
    plan = read_plan(GRID)
    folder = copied / "runs" / key_of(plan.points[2].configuration)
    content = bytearray((folder / "result.nc").read_bytes())
    content[1000] ^= 4
    (folder / "result.nc").write_bytes(content)
    said: list[str] = []
    steps: list[Step] = []
    again = batch(plan, copied, progress=steps.append, say=said.append)
    assert contents(again) == contents(done)
    assert [step.kept for step in steps] == [True, True, False]
    assert "its hash is not that of manifest.json" in said[0]
    (aside,) = folder.parent.glob("*.damaged-*")
    assert (aside / "result.nc").read_bytes() == content, "nothing is deleted"


def test_failures_are_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that diverges on the way, one that cannot begin, one whose process dies: each is stored, and kept."""
    points = (
        TINY
        + """
[[points]]
name = "diverges"
pacemaker.intensity = "1000 uA/cm^2"
[[points]]
name = "bursts"
lumen.pressure = "0.05 kPa"
[[points]]
name = "dies"
lumen.pressure = "0.06 kPa"
"""
    )
    begin = batches.KeptRun.begin

    def begun(kept: batches.KeptRun, progress: object = None) -> Simulation:
        pressure = kept.configuration.lumen.pressure
        if pressure == 0.05:
            raise DivergenceError("the tube bursts at t = 0 s; lower lumen.pressure")
        if pressure == 0.06:
            raise MemoryError
        return begin(kept)

    monkeypatch.setattr(batches.KeptRun, "begin", begun)
    made = batch(read_plan(points), tmp_path)
    assert [row.status for row in made.rows] == ["diverged", "diverged", "failed"]
    assert made.rows[2].summary["error"] == "MemoryError:"
    assert "the tube bursts" in table(made)[1]["error"]
    for row in made.rows[1:]:
        assert row.folder is not None
        assert store.verify(row.folder).status == row.status
        with pytest.raises(ConfigurationError, match="has no numbers"):
            ps.load(row.folder)
    assert made.status == "failed"
    steps: list[Step] = []
    said: list[str] = []
    again = batch(read_plan(points), tmp_path, progress=steps.append, say=said.append)
    assert [step.kept for step in steps] == [True, True, False]
    assert "had failed (MemoryError:): it is tried again" in said[0]
    assert again.rows[2].status == "failed"
    monkeypatch.undo()
    undisturbed = batch(read_plan(points), tmp_path)
    assert [row.status for row in undisturbed.rows] == ["diverged", "diverged", "in_transit"]
    assert undisturbed.status == "partly_failed"
    assert ps.load(undisturbed.rows[2].folder or "").status == "in_transit"


def test_a_table_of_another_batch_is_kept(tmp_path: Path) -> None:
    """A second batch file into the same folder costs no row; one that has all the runs of the first replaces it."""
    one, two = (TINY + f"[grid]\npellet.dry_friction = {values}" for values in ("['1 mN']", "['3 mN']"))
    both = TINY + "[grid]\npellet.dry_friction = ['1 mN', '3 mN']"
    said: list[str] = []
    first = batch(read_plan(one), tmp_path, say=said.append).table.read_bytes()
    batch(read_plan(two), tmp_path, say=said.append)
    (kept,) = tmp_path.glob("table-*.csv")
    assert kept.read_bytes() == first
    assert len(said) == 1
    assert kept.name in said[0]
    made = batch(read_plan(both), tmp_path, say=said.append)
    assert len(table(made)) == 2
    assert len(list(tmp_path.glob("table*.csv"))) == 2


def test_a_batch_with_points_without_result_is_not_finished(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "some.toml").write_text(POINTS, encoding="utf-8")
    assert main(["batch", str(tmp_path / "some.toml"), "--out", str(tmp_path / "out"), "--json"]) == 3
    said = capsys.readouterr()
    assert '"status": "partly_failed"' in said.out
    assert "1 of 4 points have no result" in said.err


def test_an_interrupted_batch_goes_on(done: Batch, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = read_plan(GRID)
    seen = Simulation._step
    steps: list[int] = []

    def step(simulation: Simulation) -> None:
        seen(simulation)
        steps.append(simulation.state.step)
        if len(steps) == 30:
            os.kill(os.getpid(), signal.SIGINT)

    with monkeypatch.context() as patched:
        patched.setattr(Simulation, "_step", step)
        with pytest.raises(InterruptedRun, match="the same call goes on"):
            batch(plan, tmp_path)
    assert len(steps) == 30
    assert len([path for path in (tmp_path / "runs").iterdir() if not path.name.startswith(".")]) == 1
    assert contents(batch(plan, tmp_path)) == contents(done)


def test_an_interrupted_result_is_not_a_finished_run(tmp_path: Path) -> None:
    """A folder that somebody's Ctrl-C of `run` left is gone on from, not tabled."""
    configuration = configured({"grid.n_z": 40, "grid.n_z_wall": 40, "run.duration": "0.04 s"})
    point = Point("one", {}, configuration)
    whole = Simulation(configuration).run()
    run = Simulation(configuration)
    run.advance("0.02 s")
    run.failure = InterruptedRun("interrupted")
    folder = tmp_path / "runs" / key_of(point.configuration)
    workspace = store.Workspace(folder)
    Checkpoints(workspace).write(run.time, run.checkpoint())
    run.result().save(folder, workspace=workspace)
    assert ps.load(folder).status == "interrupted"
    made = batch(Plan((point,)), tmp_path)
    assert made.rows[0].fingerprint == whole.fingerprint
    assert batches.run_one(batches._Task(configuration, folder, 10.0)) == whole.status


def test_what_cannot_be_stored_ends_a_batch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """R9: the disk fills up at the second run; the first one stays, and a later call does the rest."""
    plan = read_plan(GRID)
    put = disk.DISK.put
    with monkeypatch.context() as patched:
        written: list[int] = []

        def full(descriptor: int, content: memoryview) -> int:
            written.append(1)
            if len(written) > 6:
                raise OSError(28, "No space left on device")
            return put(descriptor, content)

        patched.setattr(disk.DISK, "put", full)
        with pytest.raises(WriteError, match="No space left"):
            batch(plan, tmp_path)
    steps: list[Step] = []
    batch(plan, tmp_path, progress=steps.append)
    assert [step.kept for step in steps] == [True, False, False]


def test_a_table_and_a_folder_that_cannot_be_written(copied: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = read_plan(GRID)

    def refused(*_: object) -> None:
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(batches.disk, "replace_file", refused)
    with pytest.raises(WriteError, match="Read-only"):
        batch(plan, copied)
    (copied / "runs" / key_of(plan.points[0].configuration) / "manifest.json").write_bytes(b"{}")
    monkeypatch.setattr(disk.DISK, "rename", refused)
    with pytest.raises(WriteError, match="aside"):
        batch(plan, copied)


def test_a_run_that_vanishes_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batches, "run_one", lambda task: "finished")
    with pytest.raises(WriteError, match="cannot be read again"):
        batch(read_plan(GRID), tmp_path)


def test_cells_are_no_formulas(tmp_path: Path) -> None:
    summary = {"status": "failed", "error": "=1+1", "number": -1.5, "nothing": None, "speeds": {"l": 1.0}}
    rows = (Row(summary, point=Point("run", {"lumen.pressure": "-1 kPa", "output.probes": ["1 cm"]})),)
    text = table_of(("lumen.pressure", "output.probes", "reading"), rows, tmp_path).decode()
    assert text.splitlines()[1] == 'run,-1 kPa,"[""1 cm""]",,failed,\'=1+1,-1.5,,1.0,,,'


@pytest.mark.parametrize(
    ("value", "cell"),
    [
        ("-50 mV", "-50 mV"),
        ("-0.05 V", "-0.05 V"),
        ("+5e1 mV", "+5e1 mV"),
        ("-50 mV+A1", "'-50 mV+A1"),
        ("-50 cm", "'-50 cm"),
        ("=cmd|' /C calc'!A0", "'=cmd|' /C calc'!A0"),
        ("-A1", "'-A1"),
    ],
)
def test_numbers_with_units_are_no_formulas(tmp_path: Path, value: str, cell: str) -> None:
    """What is no quantity of its own parameter stays guarded, and so do names."""
    rows = (Row({"status": "refused"}, point=Point("-run", {"longitudinal.threshold": value})),)
    lines = table_of(("longitudinal.threshold",), rows, tmp_path).decode().splitlines()
    assert next(csv.reader(lines[1:]))[:2] == ["'-run", cell]


# --- the command ------------------------------------------------------------------------------------


def test_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.toml").write_text(TINY + "[grid]\npellet.dry_friction = ['5 mN', '1 mN']", encoding="utf-8")
    assert main(["batch", "two.toml"]) == 0
    said = capsys.readouterr()
    assert "in transit" in said.out
    assert "written: out/two/table.csv" in said.out
    assert "2/2 " in said.err
    assert main(["batch", "two.toml", "--json"]) == 0
    assert '"in_transit": 2' in capsys.readouterr().out
    assert main(["batch", "two.toml", "--workers", "0"]) == 2
    folders = sorted(str(path) for path in Path("out/two/runs").iterdir())
    assert main(["check", *folders]) == 0
    Path(folders[0], "summary.json").write_bytes(b"{}")
    capsys.readouterr()
    assert main(["check", *folders, "elsewhere"]) == 1
    said = capsys.readouterr()
    assert "damaged" in said.out
    assert "not verified" in said.out
    assert main(["check", *folders, "--quarantine", "--json"]) == 1
    assert ".damaged-" in capsys.readouterr().out
    assert not Path(folders[0]).exists()
    assert main(["batch", "two.toml"]) == 0
    assert main(["check", *folders]) == 0


def test_quarantine_that_fails_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "manifest.json").write_bytes(b"{}")

    def refused(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(disk.DISK, "rename", refused)
    assert main(["check", str(tmp_path / "run"), "--quarantine"]) == 4


def test_plans_are_of_configurations() -> None:
    assert isinstance(read_plan(GRID).points[0].configuration, Configuration)


def test_points_of_a_grid_are_named_by_their_values() -> None:
    plan = read_plan('[grid]\n"pellet.radius" = ["8 mm", "9 mm"]\n"grid.n_z" = [60]\n')
    assert [point.name for point in plan.points] == ["radius = 8 mm, n_z = 60", "radius = 9 mm, n_z = 60"]
    twice = read_plan('[grid]\n"longitudinal.active" = [1.0]\n"circular.active" = [0.5]\n')
    assert twice.points[0].name == "longitudinal.active = 1.0, circular.active = 0.5"


def test_section_grid_and_table_grid_are_told_apart() -> None:
    """[grid] of a batch is what varies, not the grid of the model."""
    with pytest.raises(ConfigurationError, match=r'"grid.n_z" = \[...\], or in \[changes\]'):
        read_plan("[grid]\nn_z = 400\n")
