"""Studies carried out: tables that do not depend on the workers, kept runs, extensions, maps of classes."""

from __future__ import annotations

import csv
import io
import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest
from matplotlib.container import ErrorbarContainer

import peristalsis as ps
from peristalsis.cli.dispatch import dispatch
from peristalsis.errors import ConfigurationError, WriteError
from peristalsis.inputs.config import Configuration
from peristalsis.many import kept
from peristalsis.many import sweep as engine_sweep
from peristalsis.many.kept import Store
from peristalsis.many.rows import Row, Step
from peristalsis.many.studies import pictures
from peristalsis.many.studies.study import read_study
from peristalsis.many.studies.sweep import sweep
from peristalsis.storing.locks import Claim

HEAD = """
outputs = ["transit_s", "final_position_cm"]
[changes]
grid.n_z = 50
grid.n_z_wall = 40
run.duration = "20 ms"
"""
DRAWN = """
[design]
kind = "sobol"
samples = {samples}
seed = 1
[parameters]
pellet.viscous_friction = {{ from = "60 mN*s/cm", to = "240 mN*s/cm", scale = "log" }}
pellet.dry_friction = {{ from = "10 mN", to = "100 mN" }}
"""
SHORT = HEAD + DRAWN.format(samples=4)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Replaces the run by a formula of the friction that notes its friction; the pellet stalls above 150 mN s/cm."""
    made: list[float] = []

    def run_one(configuration: Configuration, measure: object) -> Row:
        viscous, dry = configuration.pellet.viscous_friction, configuration.pellet.dry_friction
        made.append(viscous)
        if viscous > 200.0:
            return Row({"status": "diverged", "error": "too thick", "code": "x"})
        out = viscous + dry < 180.0
        status, transit = ("expelled", viscous / 60.0) if out else ("arrested", None)
        numbers = {"transit_s": transit, "final_position_cm": 1.0, "code": engine_sweep.CODE}
        return Row({"status": status, "error": None, **numbers}, {"pellet_position": np.arange(3.0)})

    monkeypatch.setattr(engine_sweep, "run_one", run_one)
    return made


def cells(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"))))


def test_the_table_does_not_depend_on_the_workers(tmp_path: Path) -> None:
    steps: list[Step] = []
    for workers in (1, 2):
        table = ps.sweep(read_study(SHORT), tmp_path / str(workers) / "s", workers=workers, progress=steps.append)
        assert table.status == "finished"
    one, two = ((tmp_path / name / "s" / "table.csv").read_bytes() for name in ("1", "2"))
    assert one == two
    assert len(one.splitlines()) == 5
    assert not any(step.kept for step in steps)


def test_every_point_is_a_row_whatever_became_of_it(tmp_path: Path, counted: list[float]) -> None:
    text = HEAD + '[parameters]\npellet.viscous_friction = ["-1 mN*s/cm", "60 mN*s/cm", "170 mN*s/cm", "220 mN*s/cm"]\n'
    table = sweep(read_study(text), tmp_path / "s")
    rows = cells(tmp_path / "s" / "table.csv")
    assert [row["status"] for row in rows] == ["refused", "expelled", "arrested", "diverged"]
    assert [row["transit_s"] for row in rows] == ["", "1.0", "", ""]
    assert rows[0]["pellet.viscous_friction [mN*s/cm]"] == "-1.0"
    assert "pellet.viscous_friction" in rows[0]["error"]
    assert rows[3]["error"] == "too thick"
    assert [bool(row["hash"]) for row in rows] == [False, True, True, True]
    assert table.status == "partly_failed"
    assert np.isnan(table.output("transit_s")).tolist() == [True, False, True, True]


def test_an_extended_study_runs_what_is_missing_and_says_what_changed(tmp_path: Path, counted: list[float]) -> None:
    said: list[str] = []
    sweep(read_study(SHORT), tmp_path / "s", say=said.append)
    assert (len(counted), said) == (4, [])
    sweep(read_study(HEAD + DRAWN.format(samples=6)), tmp_path / "s", say=said.append)
    assert len(counted) == 6
    assert said == ["the study has changed: design: samples is another (4 before, 6 now)"]
    said.clear()
    more = SHORT.replace('outputs = ["transit_s"', 'outputs = ["stops", "transit_s"')
    sweep(read_study(more), tmp_path / "s", say=said.append)
    assert len(counted) == 6, "one more output needs no run"
    assert "the study has changed: outputs: stops is new" in said


def test_two_studies_share_their_runs(tmp_path: Path, counted: list[float]) -> None:
    sweep(read_study(SHORT), tmp_path / "one")
    sweep(read_study(SHORT), tmp_path / "two")
    assert len(counted) == 4
    sweep(read_study(SHORT), tmp_path / "three", kept=tmp_path / "elsewhere")
    assert len(counted) == 8


def test_a_folder_in_use_is_refused_before_anything_is_run(tmp_path: Path, counted: list[float]) -> None:
    claim = Claim(tmp_path / "s")
    try:
        with pytest.raises(WriteError, match="another process"):
            sweep(read_study(SHORT), tmp_path / "s")
    finally:
        claim.release()
    assert counted == []


def test_a_kept_run_that_does_not_agree_with_its_hash_is_made_again(tmp_path: Path, counted: list[float]) -> None:
    sweep(read_study(SHORT), tmp_path / "s")
    first, second = sorted((tmp_path / "kept").glob("*.npz"))[:2]
    content = bytearray(first.read_bytes())
    content[len(content) // 2] ^= 1
    first.write_bytes(bytes(content))
    second.write_bytes(sorted((tmp_path / "kept").glob("*.npz"))[2].read_bytes())  # whole, but of another run
    sweep(read_study(SHORT), tmp_path / "s")
    assert len(counted) == 6


def test_kept_runs_are_counted_and_cleaned(tmp_path: Path, counted: list[float]) -> None:
    sweep(read_study(SHORT), tmp_path / "s")
    folder = tmp_path / "kept"
    names = [path.name.removesuffix(".npz") for path in sorted(folder.glob("*.npz"))]
    Store(folder).save(names[0], Row({"status": "finished", "code": "another"}))
    (folder / f"{names[1]}.npz").write_bytes(b"nothing")
    (folder / "notes.txt").write_text("mine", encoding="utf-8")
    found = kept.count(folder)
    assert {name: one.number for name, one in found.items() if one.number} == {
        kept.CURRENT: 2, kept.STALE: 1, kept.DAMAGED: 1,
    }  # fmt: skip
    assert kept.clean_up(folder, "stale")[kept.STALE].number == 1
    assert kept.clean_up(folder, "damaged")[kept.DAMAGED].number == 1
    assert kept.clean_up(folder, "all")[kept.CURRENT].number == 2
    assert [path.name for path in folder.iterdir()] == ["notes.txt"]
    with pytest.raises(ConfigurationError, match="no folder of kept runs"):
        kept.count(tmp_path / "nowhere")


def dies(configuration: Configuration, measure: object) -> Row:
    """The run of a worker that is killed by one point of four."""
    if configuration.pellet.viscous_friction == 120.0:
        os.kill(os.getpid(), signal.SIGKILL)
    return Row({"status": "expelled", "error": None, "transit_s": 1.0})


class Dying(engine_sweep.Measured):
    def work(self):
        from functools import partial

        return partial(dies, measure=self.measure)


def test_a_point_that_kills_its_worker_twice_is_a_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from peristalsis.many.studies import runs

    monkeypatch.setattr(runs, "Measured", Dying)
    values = ", ".join(f'"{one} mN*s/cm"' for one in (60, 120, 180))
    table = sweep(read_study(f"{HEAD}[parameters]\npellet.viscous_friction = [{values}]\n"), tmp_path / "s", workers=2)
    assert [row.status for row in table.rows] == ["expelled", "failed", "expelled"]
    assert "SIGKILL" in table.rows[1].summary["error"]
    assert "2 times" in table.rows[1].summary["error"]
    assert len(list((tmp_path / "kept").glob("*.npz"))) == 2, "it is tried again by the next call"


def test_parquet_has_the_types_of_the_table(tmp_path: Path, counted: list[float]) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    text = HEAD + '[parameters]\npellet.viscous_friction = ["60 mN*s/cm", "220 mN*s/cm"]\nreading = ["tight"]\n'
    sweep(read_study(text), tmp_path / "s", parquet=True)
    found = parquet.read_table(tmp_path / "s" / "table.parquet").to_pydict()
    assert found["pellet.viscous_friction [mN*s/cm]"] == [60.0, 220.0]
    assert found["transit_s"] == [1.0, None]
    assert found["reading"] == ["tight", "tight"]
    assert found["error"] == [None, "too thick"]


MAP = """
outputs = ["transit_s"]
[map]
nodes = 17
coarse = 5
[parameters]
pellet.viscous_friction = { from = "50 mN*s/cm", to = "190 mN*s/cm" }
pellet.dry_friction = { from = "10 mN", to = "90 mN" }
"""


def test_a_map_is_that_of_the_full_grid_with_fewer_runs(tmp_path: Path, counted: list[float]) -> None:
    study = read_study(MAP, ("map",), ("grid",))
    found = ps.stall_map(study, tmp_path / "m")
    for i, viscous in enumerate(found.levels[0]):
        for j, dry in enumerate(found.levels[1]):
            assert found.refined.classes[i][j] == ("expelled" if viscous + dry < 180.0 else "not expelled")
    assert len(counted) == found.runs < found.nodes / 2
    rows = cells(tmp_path / "m" / "map.csv")
    assert len(rows) == 17 * 17
    assert sum(row["known by"] == "run" for row in rows) == found.runs
    for row in cells(tmp_path / "m" / "boundary.csv"):
        place = sum(float(row[name]) for name in list(row)[:2])
        assert abs(place - 180.0) < 10.0
    ps.stall_map(study, tmp_path / "m")
    assert len(counted) == found.runs, "a second call runs nothing"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("nodes = 17", "nodes = 18", "do not divide"),
        ("nodes = 17", 'classes = "colour"', "no such classes"),
        ("nodes = 17", "node = 17", "did you mean nodes"),
        ('dry_friction = { from = "10 mN", to = "90 mN" }', 'dry_friction = ["10 mN", "90 mN"]', "two parameters"),
    ],
)
def test_maps_that_are_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(ConfigurationError, match=said):
        ps.stall_map(read_study(MAP.replace(old, new), ("map",), ("grid",)), tmp_path / "m")


def test_commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text(SHORT, encoding="utf-8")
    assert dispatch(["sweep", "s.toml", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["status"], said["runs"]) == ("finished", {"in_transit": 4})
    assert sorted(path.name for path in Path("out/s").iterdir()) == [
        "effects.png", "pairs.png", "study.json", "table.csv", "times.csv", "times.png",
    ]  # fmt: skip
    assert dispatch(["kept", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["kept"]["of this version"]["runs"] == 4
    for words in (["sweep", "s.toml", "--workers", "0"], ["sweep", "s.toml", "--scheduler", "here"], ["kept", "no"]):
        assert dispatch(words) == 2


def test_the_map_command_draws(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, counted: list[float]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.toml").write_text(MAP, encoding="utf-8")
    assert dispatch(["stall-map", "m.toml"]) == 0
    assert Path("out/m/map.png").is_file()


def test_another_reading_by_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, counted: list[float]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.toml").write_text(MAP, encoding="utf-8")
    tables = []
    for reading in ("tight", "edge"):
        words = ["stall-map", "m.toml", "--reading", reading, "--out", f"out/{reading}", "--no-plots"]
        assert dispatch(words) == 0
        assert json.loads(Path(f"out/{reading}/study.json").read_text(encoding="utf-8"))["base"]["reading"] == reading
        tables.append([row["hash"] for row in cells(Path(f"out/{reading}/table.csv"))])
    assert not set(tables[0]) & set(tables[1]), "other experiments, though the values of the study are the same"
    assert dispatch(["stall-map", "m.toml", "--reading", "no such"]) == 2


def test_main_effects_are_means_of_five_points_or_more(tmp_path: Path, counted: list[float]) -> None:
    table = sweep(read_study(HEAD + DRAWN.format(samples=12)), tmp_path / "s")
    figure = pictures.effects(table)
    for axes, output in zip(figure.axes[::2], table.study.outputs, strict=True):
        (means,) = (one for one in axes.containers if isinstance(one, ErrorbarContainer))
        assert len(means.lines[0].get_xdata()) == np.isfinite(table.output(output)).sum() // 5
