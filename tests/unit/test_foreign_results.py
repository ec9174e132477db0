"""Results that others made or changed: manifest and hashes fit, contents do not; and results that are read-only."""

from __future__ import annotations

import json
import os
import pickle
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import peristalsis as ps
from peristalsis.cli import main
from peristalsis.errors import ConfigurationError, DamagedResult
from peristalsis.names import COORDINATES
from peristalsis.results.result import Result, check
from peristalsis.running.simulation import Simulation
from peristalsis.storing import manifest
from peristalsis.storing.manifest import Entry, Manifest
from peristalsis.storing.store import read_manifest
from verification.exact.runs import configured

TINY = {"grid.n_z": 40, "grid.n_z_wall": 40, "run.duration": "0.02 s", "output.interval": "10 ms"}
TEXT = h5py.string_dtype()


@pytest.fixture(scope="module")
def new() -> Result:
    return Simulation(configured(TINY)).run()


@pytest.fixture(scope="module")
def stored(new: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return new.save(tmp_path_factory.mktemp("stored") / "run")


@pytest.fixture
def copy(stored: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(stored, tmp_path / "run"))


def sign(folder: Path) -> None:
    """A manifest that fits whatever is there."""
    found = read_manifest(folder)
    assert found is not None
    files = {name: Entry.of((folder / name).read_bytes()) for name in found.files}
    (folder / manifest.FILE).write_bytes(Manifest(found.status, files, found.about).encode())


def with_summary(text: str) -> Callable[[h5py.File], None]:
    def spoil(file: h5py.File) -> None:
        file.attrs["summary"] = text

    return spoil


def with_variable(name: str, data: Any, **more: Any) -> Callable[[h5py.File], None]:
    def spoil(file: h5py.File) -> None:
        del file[name]
        if data is not None:
            file.create_dataset(name, data=data, **more)

    return spoil


def with_number(name: str, number: float) -> Callable[[h5py.File], None]:
    def spoil(file: h5py.File) -> None:
        values = file[name][...]
        values.flat[values.size // 2] = number
        file[name][...] = values

    return spoil


def huge(file: h5py.File) -> None:
    """80 TB that take no room in the file."""
    scales = [file[name] for name in ("time", "z", "theta")]
    del file["radius"]
    made = file.create_dataset("radius", shape=(10**7, 10**3, 10**3), chunks=(100, 100, 100), dtype="f8")
    for place, scale in enumerate(scales):
        made.dims[place].attach_scale(scale)


def summary_without(key: str) -> Callable[[h5py.File], None]:
    def spoil(file: h5py.File) -> None:
        summary = json.loads(file.attrs["summary"])
        del summary[key]
        file.attrs["summary"] = json.dumps(summary)

    return spoil


SPOILT: dict[str, Callable[[h5py.File], None]] = {
    **{f"summary {text or 'of nothing'}": with_summary(text) for text in ("null", "[]", "{}", '"x"', "7", "{", "")},
    **{f"summary without {key}": summary_without(key) for key in ("status", "transit_s", "steps", "wave_speed_cm_s")},
    "summary of 1e400": with_summary('{"scenario": 1e400}'),
    **{
        f"{name} {number}": with_number(name, number)
        for name in ("radius", "time", "pellet_position", "axial_force")
        for number in (np.nan, np.inf, 1e300)
    },
    "text": with_variable("radius", np.array(["a", "b"], dtype=object), dtype=TEXT),
    "scalar": with_variable("axial_force", 3.0),
    "short": with_variable("axial_force", np.zeros(2)),
    "complex": with_variable("axial_force", np.zeros(11, dtype=complex)),
    "numbers for words": with_variable("event_kind", np.zeros(3)),
    "no radius": with_variable("radius", None),
    "no events": with_variable("event_time", None),
    "huge": huge,
    "configuration of another": lambda file: file.attrs.__setitem__(
        "configuration", ps.configuration("resting").to_toml()
    ),
    "no configuration": lambda file: file.attrs.__delitem__("configuration"),
}


@pytest.mark.parametrize("kind", SPOILT)
def test_one_sentence_for_whatever_is_in_it(kind: str, copy: Path, recwarn: pytest.WarningsRecorder) -> None:
    with h5py.File(copy / "result.nc", "a") as file:
        SPOILT[kind](file)
    sign(copy)
    for read in (ps.load, check):
        with pytest.raises(DamagedResult, match="is not a whole result of peristalsis"):
            read(copy)
    assert not recwarn.list


def test_commands_say_it(
    copy: Path, stored: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "300")
    with h5py.File(copy / "result.nc", "a") as file:
        file.attrs["summary"] = "null"
    sign(copy)
    for words in (["compare", str(copy), str(stored)], ["plot", str(copy)], ["film", str(copy)], ["export", str(copy)]):
        assert main(words) == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert "its summary is" in said
    assert main(["check", str(copy)]) == 1
    assert "damaged" in capsys.readouterr().out


def test_manifests_that_list_too_little_or_too_much(copy: Path) -> None:
    found = read_manifest(copy)
    assert found is not None
    whole = found.files["result.nc"]
    for files in (
        {},
        {"result.nc": whole},
        {name: entry for name, entry in found.files.items() if name != "result.nc"},
        {**found.files, "result.nc": Entry(2**62, whole.sha256)},
        {**found.files, "result.nc": Entry(10**30, whole.sha256)},
    ):
        (copy / manifest.FILE).write_bytes(Manifest(found.status, files, found.about).encode())
        with pytest.raises(DamagedResult):
            check(copy)
    (copy / manifest.FILE).write_bytes(Manifest("expelled", found.files, found.about).encode())
    with pytest.raises(DamagedResult, match="manifest"):
        ps.load(copy)


# --- other programs -----------------------------------------------------------------------------------


def test_a_file_is_of_the_classic_model(new: Result, tmp_path: Path) -> None:
    """No texts of variable length, no 64-bit integers, no unlimited dimension, no fill value of a coordinate."""
    quiet = Simulation(configured({**TINY, "pacemaker.intensity": "0 uA/cm^2", "output.probes": []}))
    for number, result in enumerate((new, quiet.run())):
        folder = result.save(tmp_path / str(number))
        with h5py.File(folder / "result.nc") as file:
            things = {"": file, **file}
            for name, thing in things.items():
                for key in thing.attrs:
                    kind = thing.attrs.get_id(key).dtype
                    if key in ("DIMENSION_LIST", "REFERENCE_LIST"):
                        continue
                    assert h5py.check_string_dtype(kind) is None or kind.kind == "S", (name, key)
                    assert kind != np.int64, (name, key)
            for name in file:
                assert h5py.check_string_dtype(file[name].dtype) is None or file[name].dtype == "S1", name
                assert None not in file[name].maxshape, name
            for output in COORDINATES:
                assert output.name not in file or "_FillValue" not in file[output.name].attrs
        back = ps.load(folder)
        assert back.fingerprint == result.fingerprint
        assert {n: (v.shape, v.dtype) for n, v in back.arrays.items()} == {
            n: (v.shape, v.dtype) for n, v in result.arrays.items()
        }
        assert list(back.arrays["event_words"]) == list(result.arrays["event_words"])


@pytest.mark.skipif(shutil.which("nccopy") is None, reason="the tools of netCDF are not there")
def test_nccopy_makes_a_classic_file_of_it(stored: Path, tmp_path: Path) -> None:
    subprocess.run(["nccopy", "-k", "classic", str(stored / "result.nc"), str(tmp_path / "c.nc")], check=True)


# --- nothing of a result can be changed -------------------------------------------------------------


def test_results_are_read_only(new: Result, tmp_path: Path) -> None:
    """What is stored is what was computed."""
    before = new.fingerprint
    for change in (
        lambda: new.dataset.radius.__setitem__(slice(None), 1.0),
        lambda: new.arrays["radius"].fill(1.0),
        lambda: new.arrays.__setitem__("radius", 1.0),  # type: ignore[attr-defined]
        lambda: new.summary.update(status="expelled"),  # type: ignore[attr-defined]
        lambda: new.summary["wave_speed_cm_s"].update(longitudinal=1.0),
        lambda: new.summary.pop("status"),  # type: ignore[attr-defined]
    ):
        with pytest.raises((TypeError, ValueError), match=r"read-only|view"):
            change()
    mine = new.dataset
    mine["radius"] = 2.0 * mine.radius
    mine.attrs["title"] = "mine"
    assert new.dataset.attrs["title"] != "mine"
    back = ps.load(new.save(tmp_path / "run"))
    with pytest.raises(ValueError, match="read-only"):
        back.arrays["radius"].fill(1.0)
    assert before == back.fingerprint == pickle.loads(pickle.dumps(new)).fingerprint
    assert json.loads(json.dumps(new.summary)) == new.summary


def test_reading_a_run_leaves_it_as_it_is(new: Result) -> None:
    """No frame, event or number of a run depends on who looked at it on the way."""
    run = Simulation(configured(TINY))
    for piece in ("6 ms", "2 ms", "8 ms"):
        run.advance(piece)
        for _ in range(2):
            seen = run.result()
        assert run.result().fingerprint == seen.fingerprint
        run.events()
        run.checkpoint()
        run.last_state()
    assert run.run().fingerprint == new.fingerprint == run.run().fingerprint


# --- what is read -------------------------------------------------------------------------------------


def test_only_regular_files_are_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A pipe that nobody writes to, or a device without end, is not waited for."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for place in (pipe, Path("/dev/zero")):
        for words in (
            ["validate", str(place)],
            ["batch", str(place)],
            ["run", "--config", str(place)],
            ["show", "baseline", "--set", f"protocols=lumen.pressure: table {place}"],
            ["show", "baseline", "--set", f"regions=[{{name='a',shape='map',file='{place}',quantities=['active']}}]"],
        ):
            assert main(words) == 2
            assert "not a regular file" in capsys.readouterr().err
    real = tmp_path / "real.toml"
    real.write_text("scenario = 'baseline'\n", encoding="utf-8")
    (tmp_path / "link.toml").symlink_to(real)
    assert main(["validate", str(tmp_path / "link.toml")]) == 0


def test_a_working_folder_that_is_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    for words in (["compare", "a", "b"], ["batch", "a.toml"], ["plot", "a"], ["run", "baseline"]):
        assert main(words) == 2
        assert capsys.readouterr().err.startswith("error: the working folder is gone")


def test_quarantine_of_the_working_folder(
    copy: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (copy / "summary.json").write_bytes(b"{}")
    monkeypatch.chdir(copy)
    assert main(["check", ".", "--quarantine"]) == 1
    assert "moved to" in capsys.readouterr().out.replace("\n", " ")
    (aside,) = copy.parent.glob("run.damaged-*")
    assert (aside / "result.nc").exists()


def test_a_record_without_numbers_is_whole_only_if_it_says_why(tmp_path: Path) -> None:
    from peristalsis.storing.store import Workspace

    workspace = Workspace(tmp_path / "run")
    files = {"summary.json": b'{"status": "failed", "error": "it died"}', "config.toml": b""}
    workspace.publish(files, "failed", {})
    assert check(tmp_path / "run").status == "failed"
    with pytest.raises(ConfigurationError, match="has no numbers"):
        ps.load(tmp_path / "run")
    workspace = Workspace(tmp_path / "other")
    workspace.publish({**files, "summary.json": b"null"}, "failed", {})
    with pytest.raises(DamagedResult, match="does not say how it ended"):
        check(tmp_path / "other")
