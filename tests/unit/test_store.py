"""Stored runs survive: any operation may fail in any way, any byte may change, and no wrong result is ever accepted."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import time
from pathlib import Path

import numpy as np
import pytest
from faults import FAULTS, FaultyDisk, Killed

import peristalsis as ps
from peristalsis.errors import ConfigurationError, DamagedResult, PeristalsisError, WriteError
from peristalsis.results.result import Result
from peristalsis.running.runner import KeptRun
from peristalsis.running.simulation import Simulation
from peristalsis.storing import disk, environment, manifest, store
from peristalsis.storing.checkpoint import Checkpoints
from peristalsis.storing.disk import Disk
from peristalsis.storing.locks import Claim
from peristalsis.storing.manifest import Entry, Manifest
from peristalsis.storing.store import Workspace, quarantine, read_manifest, recover, verify
from verification.exact.runs import configured

FIXTURES = Path(__file__).parents[1] / "fixtures"
TINY = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 40,
    "grid.n_z_wall": 40,
    "run.duration": "0.02 s",
    "output.interval": "10 ms",
    "run.checkpoint": "8 ms",
}
FILES = ("result.nc", "summary.json", "config.toml", "manifest.json")


@pytest.fixture(scope="module")
def old() -> Result:
    """A result that may stand in the folder before."""
    return Simulation(configured(TINY, {"pellet.dry_friction": "5 mN"})).run()


@pytest.fixture(scope="module")
def new() -> Result:
    """The result to be stored."""
    return Simulation(configured(TINY)).run()


@pytest.fixture(scope="module")
def stored(new: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the result; not to be changed."""
    return new.save(tmp_path_factory.mktemp("stored") / "run")


@pytest.fixture
def copy(stored: Path, tmp_path: Path) -> Path:
    """A copy of that folder, to be spoilt."""
    return Path(shutil.copytree(stored, tmp_path / "run"))


def small(folder: Path, content: bytes = b"numbers", workspace: Workspace | None = None) -> Path:
    """Publish something small, without the cost of a result."""
    place = Workspace(folder) if workspace is None else workspace
    try:
        return place.publish({"summary.json": content, "config.toml": b"x = 1\n"}, "finished", {"about": 1})
    finally:
        place.close()


# --- what is stored ---------------------------------------------------------------------------------


def test_manifest_tells_everything(stored: Path, new: Result) -> None:
    found = verify(stored)
    assert set(found.files) == {"result.nc", "summary.json", "config.toml"}
    for name, entry in found.files.items():
        content = (stored / name).read_bytes()
        assert (entry.size, entry.sha256) == (len(content), hashlib.sha256(content).hexdigest())
    assert found.status == new.status
    about = found.about
    assert about["configuration_sha256"] == new.configuration.digest()
    assert about["fingerprint"] == new.fingerprint == ps.load(stored).fingerprint
    assert about["code"] == environment.code_version()
    assert {"numpy", "numba", "scipy"} <= about["versions"].keys()
    assert about["machine"]["processor"]


def test_machine_that_the_compiler_does_not_know(monkeypatch: pytest.MonkeyPatch) -> None:
    from llvmlite import binding

    def unknown() -> dict[str, bool]:
        raise RuntimeError

    monkeypatch.setattr(binding, "get_host_cpu_features", unknown)
    assert environment.machine.__wrapped__()["features"] == ""
    monkeypatch.setattr(environment, "LIBRARIES", ("no such library",))
    assert environment.versions()["no such library"] == "unknown"


def test_fingerprint_sees_numbers_and_not_the_clock(new: Result) -> None:
    from dataclasses import replace

    clock = replace(new, summary={**new.summary, "solver_wall_s": 99.0})
    assert clock.fingerprint == new.fingerprint
    nudged = new.arrays["radius"].copy()
    nudged[1, 3, 0] = np.nextafter(nudged[1, 3, 0], 2.0)
    assert replace(new, arrays={**new.arrays, "radius": nudged}).fingerprint != new.fingerprint
    assert replace(new, summary={**new.summary, "status": "expelled"}).fingerprint != new.fingerprint
    arrays = new.arrays.items()
    negative = {n: np.where(np.isnan(v), -np.abs(v), v) if v.dtype.kind == "f" else v for n, v in arrays}
    assert replace(new, arrays=negative).fingerprint == new.fingerprint, "a nan has no sign"


@pytest.mark.parametrize("name", sorted(path.name for path in FIXTURES.glob("result-*")))
def test_old_results_stay_readable(name: str) -> None:
    """D3: a stored result of every schema that was ever written."""
    result = ps.load(FIXTURES / name)
    assert result.status == "in_transit"
    assert result.summary["final_position_cm"] == 1.1999293420577086
    assert result.arrays["radius"].shape == (3, 41, 1)
    assert result.configuration.grid.n_z == 40
    assert list(result.arrays["event_kind"])


def test_choices_that_a_stored_run_did_not_have_are_what_its_version_did() -> None:
    old = ps.load(FIXTURES / "result-schema-1").configuration
    assert (old.tissue.front_correction, old.grid.exchange, old.trigger.timing) == ("none", "averages", "step")
    assert ps.Configuration().grid.exchange == "reconstructed"


def test_there_is_a_fixture_of_the_present_schema() -> None:
    found = read_manifest(FIXTURES / f"result-schema-{manifest.SCHEMA}")
    assert found is not None
    assert verify(FIXTURES / f"result-schema-{manifest.SCHEMA}").status == "in_transit"


def test_results_without_manifest_cannot_be_verified_and_say_so() -> None:
    with pytest.raises(ConfigurationError, match=r"no manifest\.json"):
        verify(FIXTURES / "result-without-manifest")


def test_loading_from_the_file_is_loading_from_its_folder(stored: Path, tmp_path: Path) -> None:
    assert ps.load(stored / "result.nc").fingerprint == ps.load(stored).fingerprint
    for name in ("result.nc", "renamed.nc"):
        alone = ps.load(shutil.copy(stored / "result.nc", tmp_path / name))
        assert alone.fingerprint == ps.load(stored).fingerprint
        assert "could not be checked" in alone.remarks[-1]
    folder = Path(shutil.copytree(stored, tmp_path / "run"))
    (folder / manifest.FILE).unlink()
    for place in (folder, folder / "result.nc"):
        with pytest.raises(DamagedResult, match=r"manifest\.json is missing"):
            ps.load(place)


# --- any operation may fail -------------------------------------------------------------------------


@pytest.mark.parametrize("before", [False, True], ids=["new", "replacing"])
@pytest.mark.parametrize("fault", FAULTS)
def test_every_operation_may_fail(fault: str, before: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """R2: fail the n-th operation for n = 0, 1, ... until none is left. After each: old, new, or nothing; never
    anything else, never an old result lost, and a second try succeeds."""
    number = 0
    while True:
        target = tmp_path / str(number) / "run"
        if before:
            small(target, b"old")
        faulty = FaultyDisk(number, fault)
        with monkeypatch.context() as patched:
            patched.setattr(disk, "DISK", faulty)
            try:
                small(target, b"new")
                survived = True
            except (WriteError, Killed):
                survived = False
        recover(target)
        if target.exists():
            verify(target)
            content = (target / "summary.json").read_bytes()
            assert content == b"new" if survived or not before else content in (b"old", b"new")
        else:
            assert not before
            assert not survived
        small(target, b"third")
        assert verify(target).status == "finished"
        assert (target / "summary.json").read_bytes() == b"third"
        if not faulty.reached:
            break
        number += 1
    assert number > 8


@pytest.mark.parametrize(
    ("fault", "every"),
    [("power", 9), *(pytest.param(fault, 3, marks=pytest.mark.slow) for fault in FAULTS)],
)
def test_any_operation_of_a_run_may_fail_and_it_is_resumed_to_the_same_bits(
    fault: str, every: int, new: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """R2, R9: a run with checkpoints, spoilt at one operation after the other, ends with the bits it should have."""
    configuration = new.configuration
    reached, number = True, 0
    while reached:
        target = tmp_path / str(number) / "run"
        faulty = FaultyDisk(number, fault)
        with monkeypatch.context() as patched:
            patched.setattr(disk, "DISK", faulty)
            kept = None
            try:
                kept = KeptRun(configuration, target)
                with kept:
                    kept.save(kept.begin().run())
            except (PeristalsisError, Killed):
                pass
            finally:
                if kept is not None:
                    kept.workspace.close()  # the lock of a process ends with it
        again = KeptRun(configuration, target, resume=True)
        if again.finished is None:
            with again:
                again.save(again.begin().run())
        assert ps.load(target).fingerprint == new.fingerprint
        assert [path.name for path in target.parent.iterdir()] == ["run"]
        reached, number = faulty.reached, number + every
    assert number > 30


def test_an_old_result_comes_back_if_the_new_one_cannot_take_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = small(tmp_path / "run", b"old")
    rename = Disk.rename
    refused: list[Path] = []

    def once(self: Disk, one: Path, other: Path) -> None:
        if other == target and not refused:
            refused.append(one)
            raise OSError(1, "Operation not permitted")
        rename(self, one, other)

    monkeypatch.setattr(Disk, "rename", once)
    with pytest.raises(WriteError, match="not permitted"):
        small(target, b"new")
    assert (target / "summary.json").read_bytes() == b"old"


def test_a_crash_between_two_renames_loses_neither(tmp_path: Path) -> None:
    """The old result has its hidden name, the new one not yet its own: the new one is completed, else the old is."""
    target = small(tmp_path / "run", b"old")
    aside = store._hidden(target, "old")
    target.rename(aside)
    with pytest.raises(ConfigurationError, match="missing"):
        ps.load(tmp_path / "other")
    recover(target)
    assert (target / "summary.json").read_bytes() == b"old"
    target.rename(aside)
    whole = small(tmp_path / "elsewhere", b"new")
    whole.rename(store._hidden(target, "tmp"))
    recover(target)
    assert (target / "summary.json").read_bytes() == b"new"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_recovering_leaves_alone_what_is_not_whole_or_not_free(tmp_path: Path) -> None:
    target = tmp_path / "run"
    small(tmp_path / "elsewhere").rename(store._hidden(target, "tmp"))
    (hidden,) = store.unfinished(target)
    busy = Workspace(target, hidden)
    busy.open()
    recover(target)
    assert not target.exists()
    busy.close()
    (hidden / "summary.json").write_bytes(b"changed")
    (tmp_path / ".old-run-0123456789abcdef").mkdir()
    recover(target)
    assert not target.exists()
    (hidden / manifest.FILE).unlink()
    recover(target)
    assert not target.exists()


def test_leftovers_that_cannot_be_removed_are_no_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = small(tmp_path / "run", b"old")

    def refused(self: Disk, path: Path) -> None:
        raise PermissionError(13, "Permission denied")

    with monkeypatch.context() as patched:
        patched.setattr(Disk, "remove_folder", refused)
        small(target, b"new")
        left = Workspace(target)
        left.open()
        left.discard()
    assert (target / "summary.json").read_bytes() == b"new"
    small(target, b"third")
    assert sorted(path.name for path in tmp_path.iterdir() if path.name.startswith(".old")) == []


def test_a_folder_that_cannot_be_locked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise OSError(37, "No locks available")

    monkeypatch.setattr(store.fcntl, "flock", refused)
    with pytest.raises(WriteError, match="No locks"):
        small(tmp_path / "run")


def test_a_disk_that_cannot_synchronise_folders_is_no_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(descriptor: int) -> None:
        raise OSError(22, "Invalid argument")

    monkeypatch.setattr(disk.os, "fsync", refused)
    assert verify(small(tmp_path / "run")).status == "finished"


def test_a_file_that_cannot_be_synchronised_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(descriptor: int) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(disk.os, "fsync", refused)
    with pytest.raises(WriteError, match="Input/output error"):
        small(tmp_path / "run")


def test_places_that_cannot_be(new: Result, tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    for place in (tmp_path / "file", tmp_path / "file" / "run"):
        with pytest.raises(WriteError):
            new.save(place, overwrite=True)
    assert (tmp_path / "file").read_bytes() == b""


def test_pictures_are_stored_with_a_result_and_not_listed(tmp_path: Path) -> None:
    target = tmp_path / "run"
    workspace = Workspace(target)
    workspace.publish(
        {"summary.json": b"{}", "config.toml": b""},
        "finished",
        {},
        lambda folder: (folder / "a.png").write_bytes(b"") and None,
    )
    workspace.close()
    assert (target / "a.png").exists()
    assert set(verify(target).files) == {"summary.json", "config.toml"}


def test_links_in_a_hidden_folder_are_removed_and_not_followed(tmp_path: Path) -> None:
    (tmp_path / "precious").mkdir()
    (tmp_path / "precious" / "thesis.txt").write_text("years of work", encoding="utf-8")
    workspace = Workspace(tmp_path / "run")
    folder = workspace.open()
    (folder / "inside").mkdir()
    (folder / "inside" / "link").symlink_to(tmp_path / "precious")
    assert workspace.open() == folder
    workspace.discard()
    assert not folder.exists()
    assert (tmp_path / "precious" / "thesis.txt").exists()


# --- any byte may change ----------------------------------------------------------------------------


def sweep_of_corruption(folder: Path, flips: int, cuts: int, seed: int) -> int:
    """Change bytes and lengths of every file of a result; every one must be noticed. The number of changes made."""
    random = np.random.default_rng(seed)
    whole = {name: (folder / name).read_bytes() for name in FILES}
    sizes = np.array([len(whole[name]) for name in FILES])
    made = 0

    def refused(name: str, content: bytes) -> None:
        (folder / name).write_bytes(content)
        for read in (ps.load, verify):
            with pytest.raises((DamagedResult, ConfigurationError)):
                read(folder)

    for kind, count in (("flip", flips), ("cut", cuts)):
        for k in range(count):
            # Half of them in proportion to size, half in the small files, which would be met too seldom.
            name = FILES[int(random.choice(4, p=sizes / sizes.sum()) if k % 2 else random.integers(4))]
            content = bytearray(whole[name])
            place = int(random.integers(len(content)))
            if kind == "flip":
                content[place] ^= 1 << int(random.integers(8))
            else:
                del content[place:]
            refused(name, bytes(content))
            (folder / name).write_bytes(whole[name])
            made += 1
    assert ps.load(folder).status == "in_transit"
    return made


def test_changed_bytes_are_noticed(copy: Path) -> None:
    """R3 in short: 100 flips, 40 lengths."""
    assert sweep_of_corruption(copy, 100, 40, seed=3) == 140


@pytest.mark.slow
def test_every_changed_byte_is_noticed(copy: Path) -> None:
    """R3: 1000 flips, 200 lengths, all noticed."""
    assert sweep_of_corruption(copy, 1000, 200, seed=4) == 1200


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("what", ["missing", "empty", "longer", "a folder", "a pipe", "a link", "another's"])
def test_altered_files_are_refused(name: str, what: str, copy: Path, old: Result, tmp_path: Path) -> None:
    file = copy / name
    content = file.read_bytes()
    if what == "longer":
        file.write_bytes(content + b"\n")
    elif what == "another's":
        if name == "summary.json":
            file.write_bytes(content.replace(b"in_transit", b"in_transiu"))
        else:
            shutil.copy(old.save(tmp_path / "other") / name, file)
    else:
        file.unlink()
        if what == "empty":
            file.touch()
        elif what == "a folder":
            file.mkdir()
        elif what == "a pipe":
            os.mkfifo(file)
        elif what == "a link":
            (tmp_path / "real").write_bytes(content)
            file.symlink_to(tmp_path / "real")
    begin = time.monotonic()
    with pytest.raises(ConfigurationError):
        ps.load(copy)
    with pytest.raises(ConfigurationError):
        verify(copy)
    assert time.monotonic() - begin < 5.0, "a pipe must not be waited for"


def test_exchanged_numbers_of_two_runs_are_noticed(copy: Path, old: Result, tmp_path: Path) -> None:
    other = old.save(tmp_path / "other")
    one, two = (copy / "result.nc").read_bytes(), (other / "result.nc").read_bytes()
    (copy / "result.nc").write_bytes(two)
    (other / "result.nc").write_bytes(one)
    for folder in (copy, other):
        with pytest.raises(DamagedResult, match=r"hash|bytes"):
            ps.load(folder)


def test_quarantine_moves_and_deletes_nothing(copy: Path) -> None:
    before = {path.name: path.read_bytes() for path in copy.iterdir()}
    aside = quarantine(copy)
    assert not copy.exists()
    assert aside.name.startswith("run.damaged-")
    assert {path.name: path.read_bytes() for path in aside.iterdir()} == before
    assert ps.load(aside).status == "in_transit", "it is only moved"


def test_a_manifest_that_lies_about_its_content(copy: Path) -> None:
    """Hashes agree and the content is none of ours: one sentence, no traceback."""
    for content in (b"", b"not a NetCDF file", b"\x89HDF\r\n\x1a\n" + b"\0" * 200):
        files = {**read_manifest(copy).files, "result.nc": Entry.of(content)}
        (copy / "result.nc").write_bytes(content)
        (copy / manifest.FILE).write_bytes(Manifest("finished", files).encode())
        assert verify(copy).status == "finished"
        with pytest.raises(DamagedResult):
            ps.load(copy)


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"null",
        b"[]",
        b"{}",
        b"\xff\xfe",
        b"[" * 100_000,
        b'{"a":' * 50_000,
        b"1" * 5000,
        b'{"files": NaN}',
        Manifest("", {}).encode(),
        Manifest("finished; rm -rf", {}).encode(),
        Manifest("finished", {"../../etc/passwd": Entry.of(b"")}).encode(),
        Manifest("finished", {"/etc/passwd": Entry.of(b"")}).encode(),
        Manifest("finished", {".hidden": Entry.of(b"")}).encode(),
        Manifest("finished", {"a/b": Entry.of(b"")}).encode(),
        Manifest("finished", {"a\0b": Entry.of(b"")}).encode(),
        Manifest("finished", {"manifest.json": Entry.of(b"")}).encode(),
        Manifest("finished", {"result.nc": Entry(-1, "0" * 64)}).encode(),
        Manifest("finished", {"result.nc": Entry(10**30, "0")}).encode(),
        Manifest("finished", {"result.nc": Entry(True, "0" * 64)}).encode(),
        Manifest("finished", {}, [1]).encode(),  # type: ignore[arg-type]
    ],
)
def test_hostile_manifests_are_refused(text: bytes, copy: Path) -> None:
    """S3, S6: no path out of the folder, no nesting, no size that is not one."""
    (copy / manifest.FILE).write_bytes(text)
    for read in (ps.load, verify):
        with pytest.raises(DamagedResult):
            read(copy)


def test_other_schemas_and_entries_are_refused(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patched:
        patched.setattr(manifest, "SCHEMA", 99)
        later = Manifest("finished", {}).encode()
    with pytest.raises(ValueError, match="schema 99"):
        manifest.decode(later)
    for files in ([1], {"result.nc": 7}, {"result.nc": {"size": 1}}):
        content = {"format": manifest.FORMAT, "schema": manifest.SCHEMA, "status": "finished", "files": files}
        content["about"] = {}
        signed = manifest._canonical({**content, "sha256": manifest._hash(content)})
        with pytest.raises(ValueError, match="it"):
            manifest.decode(signed)
    (copy / manifest.FILE).write_bytes(b" " * (manifest.LARGEST + 1))
    with pytest.raises(DamagedResult, match="more than"):
        verify(copy)


# --- where it is stored -----------------------------------------------------------------------------


def test_a_link_is_neither_followed_nor_replaced(new: Result, tmp_path: Path) -> None:
    """S3: a symbolic link in the place of the result, dangling or not."""
    (tmp_path / "precious").mkdir()
    for goal in (tmp_path / "precious", tmp_path / "nowhere"):
        link = tmp_path / f"link to {goal.name}"
        link.symlink_to(goal)
        for overwrite in (False, True):
            with pytest.raises(WriteError, match="symbolic link"):
                new.save(link, overwrite=overwrite)
    assert list((tmp_path / "precious").iterdir()) == []


@pytest.mark.parametrize("name", ["", "..", "x" * 300, "x" * 250, "a\0b", "é" * 120])
def test_names_that_cannot_be(name: str, new: Result, tmp_path: Path) -> None:
    before = sorted(tmp_path.parent.iterdir())
    with pytest.raises(WriteError):
        new.save(f"{tmp_path}/{name}" if name else "/", overwrite=True)
    assert list(tmp_path.iterdir()) == []
    assert sorted(tmp_path.parent.iterdir()) == before


@pytest.mark.parametrize("name", ["x" * 230, "with space", "ünï", "-rf", "a\nb", ".hidden", "run.tmp-1"])
def test_names_that_can_be(name: str, tmp_path: Path) -> None:
    target = small(tmp_path / name, b"old")
    small(target, b"new")
    assert (target / "summary.json").read_bytes() == b"new"
    assert len(list(tmp_path.iterdir())) == 1


def test_hidden_folders_belong_to_one_name(tmp_path: Path) -> None:
    for name in ("a", "a-b", "a.c"):
        Workspace(tmp_path / name).open()
    (tmp_path / ".tmp-a-0123456789abcdef").symlink_to(tmp_path)
    assert len(store.unfinished(tmp_path / "a")) == 1
    assert store.unfinished(tmp_path / "nowhere" / "a") == []


def test_what_a_killed_writer_left_is_cleaned(tmp_path: Path) -> None:
    workspace = Workspace(tmp_path / "run")
    folder = workspace.open()
    (folder / ".new-checkpoint-b.bin").write_bytes(b"half")
    (folder / "csv").mkdir()
    Checkpoints(workspace).write(0.0, b"whole")
    assert workspace.has_checkpoints()
    target = small(tmp_path / "run", workspace=workspace)
    assert {path.name for path in target.iterdir()} == {"summary.json", "config.toml", "manifest.json", "csv"}


def test_pickled_objects_are_never_read(copy: Path, tmp_path: Path) -> None:
    """S4: a checkpoint or a kept run with an object in it is refused before it is made."""
    import io

    from peristalsis.many.kept import Store
    from peristalsis.storing import packing
    from peristalsis.storing.checkpoint import newest

    class Bomb:
        def __reduce__(self) -> tuple[object, tuple[str]]:
            return os.mkdir, (str(tmp_path / "exploded"),)

    image = io.BytesIO()
    np.savez(image, structure=np.array([Bomb()], dtype=object), numbers=np.array([Bomb()], dtype=object))
    payload = image.getvalue()
    signed = packing.HEAD + hashlib.sha256(payload).hexdigest().encode() + b"\n" + payload
    (copy / store.CHECKPOINTS[0]).write_bytes(signed)
    assert newest(copy) is None
    (tmp_path / "key.npz").write_bytes(payload)
    assert Store(tmp_path).load("key") is None
    assert not (tmp_path / "exploded").exists()


def test_no_source_reads_code_from_data() -> None:
    """S4: neither pickle nor eval stands anywhere in the package."""
    package = Path(ps.__file__).parent
    for file in package.rglob("*.py"):
        if file.parent == package / "cells":  # carries out the description that its user names, as a plug-in is
            continue
        if file == package / "numerics" / "kept.py":  # kernels in the cache, which holds machine code anyway
            continue
        text = file.read_text(encoding="utf-8")
        for word in ("import pickle", "import marshal", "import shelve", "joblib", "yaml", "allow_pickle=True"):
            assert word not in text, f"{file.name}: {word}"
        for word in (" eval(", " exec(", "__import__("):
            assert word not in text, f"{file.name}: {word}"


def test_all_writes_of_results_go_through_one_door() -> None:
    """A fault that is injected at the door is then one that every write can meet."""
    package = Path(ps.__file__).parent
    for name in (
        "storing/store.py",
        "storing/manifest.py",
        "storing/checkpoint.py",
        "storing/packing.py",
        "results/result.py",
        "running/runner.py",
        "many/batch.py",
    ):
        text = (package / name).read_text(encoding="utf-8")
        for word in ("write_bytes", "write_text", "os.replace", "os.rename", "shutil", ".unlink(", '"wb"', '"w"'):
            assert word not in text, f"{name}: {word}"


def test_json_of_a_summary_has_no_nan(stored: Path) -> None:
    def refuse(word: str) -> None:
        raise AssertionError(word)

    json.loads((stored / "summary.json").read_text(encoding="utf-8"), parse_constant=refuse)


def test_a_file_that_did_not_fit_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The part that was written would fill a disk that is full already."""

    class Full(Disk):
        def put(self, descriptor: int, content: memoryview) -> int:
            if os.fstat(descriptor).st_size:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            return super().put(descriptor, content[:3])

    (tmp_path / "name").write_bytes(b"before")
    monkeypatch.setattr(disk, "DISK", Full())
    with pytest.raises(OSError, match="No space"):
        disk.replace_file(tmp_path / "name", b"content")
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [("name", b"before")]


def test_a_folder_that_takes_no_files_is_not_said_to_be_in_use() -> None:
    """Such as one of /proc, whose folders exist and have no room for a lock."""
    if not Path("/proc/self").is_dir():
        pytest.skip("no such folder here")
    with pytest.raises(WriteError, match="could not write '/proc/name': No such file or directory; choose another"):
        Claim(Path("/proc/name"))
