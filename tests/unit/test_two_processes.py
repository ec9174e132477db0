"""Two at once in one place: nothing that was computed is lost, and nothing that stands is replaced unasked."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import peristalsis as ps
from peristalsis.cli import main
from peristalsis.errors import WriteError
from peristalsis.many.batch import batch
from peristalsis.many.plan import read_plan
from peristalsis.running.runner import KeptRun
from peristalsis.storing import store
from peristalsis.storing.disk import Disk
from peristalsis.storing.locks import Claim
from peristalsis.storing.store import Workspace, verify
from verification.exact.runs import configured

TINY = {"grid.n_z": 40, "grid.n_z_wall": 40, "run.duration": "0.02 s", "output.interval": "10 ms"}
HOLDER = """
import sys
from pathlib import Path
from peristalsis.storing.locks import Claim
claim = Claim(Path(sys.argv[1]))
print("taken", flush=True)
sys.stdin.read()
"""


def files(content: bytes) -> dict[str, bytes]:
    return {"summary.json": content, "config.toml": b"x = 1\n"}


def publish(target: Path, content: bytes, overwrite: bool) -> Path:
    workspace = Workspace(target)
    try:
        return workspace.publish(files(content), "finished", {}, overwrite=overwrite)
    finally:
        workspace.close()


def test_who_is_put_in_place_at_the_last_moment_is_not_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The race itself, forced: another result appears between the last look and the rename, by who knows no locks."""
    target = tmp_path / "run"
    rename = Disk.rename
    raced: list[Path] = []

    def late(self: Disk, old: Path, new: Path) -> None:
        if new == target and not raced:
            raced.append(old)
            target.mkdir()
            (target / "summary.json").write_bytes(b"theirs")
        rename(self, old, new)

    monkeypatch.setattr(Disk, "rename", late)
    with pytest.raises(WriteError, match="not replaced; this result is kept in"):
        publish(target, b"ours", overwrite=False)
    assert (target / "summary.json").read_bytes() == b"theirs"
    (kept,) = tmp_path.glob("run.kept-*")
    assert verify(kept).status == "finished"
    assert (kept / "summary.json").read_bytes() == b"ours"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run", kept.name]


def test_overwriting_the_last_one_wins_whole(tmp_path: Path) -> None:
    """Many threads overwrite one result at once: one of them stands, whole, and nothing is left beside it."""
    target = publish(tmp_path / "run", b"first", overwrite=True)
    contents = [str(number).encode() for number in range(12)]
    threads = [threading.Thread(target=publish, args=(target, content, True)) for content in contents]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    verify(target)
    assert (target / "summary.json").read_bytes() in contents
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_one_of_many_wins_and_the_others_are_kept(tmp_path: Path) -> None:
    """Without overwriting, every result is somewhere."""
    target = tmp_path / "run"
    refused: list[WriteError] = []

    def one(content: bytes) -> None:
        try:
            publish(target, content, overwrite=False)
        except WriteError as error:
            refused.append(error)

    contents = [str(number).encode() for number in range(8)]
    threads = [threading.Thread(target=one, args=(content,)) for content in contents]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(refused) == 7
    found = [(folder / "summary.json").read_bytes() for folder in tmp_path.iterdir()]
    assert sorted(found) == contents


def test_the_later_run_is_refused_before_it_computes(tmp_path: Path) -> None:
    with KeptRun(configured(TINY), tmp_path / "run") as first:
        for options in ({}, {"resume": True}, {"overwrite": True}):
            with pytest.raises(WriteError, match="another process"):
                KeptRun(configured(TINY), tmp_path / "run", **options)
        with pytest.raises(WriteError, match="another process"):
            first.begin().result().save(tmp_path / "run")
        first.save(first.begin().run())
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_who_may_all_overwrite_let_one_another_in(tmp_path: Path) -> None:
    one = KeptRun(configured(TINY), tmp_path / "run", overwrite=True)
    other = KeptRun(configured(TINY, {"pellet.dry_friction": "5 mN"}), tmp_path / "run", overwrite=True)
    for kept in (other, one):
        with kept:
            kept.save(kept.begin().run())
    assert ps.load(tmp_path / "run").configuration == one.configuration
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_a_name_is_free_again_when_its_process_is_gone(tmp_path: Path) -> None:
    """Held by another process, refused here; that one is killed, and nothing has to be cleaned."""
    target = tmp_path / "new" / "run"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    command = [sys.executable, "-c", HOLDER, str(target)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "taken\n"
        for alone in (True, False):
            with pytest.raises(WriteError, match="another process"):
                Claim(target, alone=alone)
        process.kill()
        process.communicate()
    claim = Claim(target)
    claim.release()
    assert (target.parent / ".lock-run").exists() is False
    assert [path.name for path in tmp_path.iterdir()] in (["new"], [])


def test_a_claim_leaves_nothing_behind(tmp_path: Path) -> None:
    claim = Claim(tmp_path / "a" / "b" / "run")
    claim.release()
    claim.release()
    assert list(tmp_path.iterdir()) == []


def test_a_reader_does_not_disturb_who_puts_in_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between the two renames of a writer, a reader waits; before, it finished the writer's work under its hands."""
    target = publish(tmp_path / "run", b"old", overwrite=True)
    rename = Disk.rename
    readers: list[threading.Thread] = []

    def seen(self: Disk, old: Path, new: Path) -> None:
        if new == target and not readers:
            readers.append(threading.Thread(target=store.recover, args=(target,)))
            readers[0].start()
        rename(self, old, new)

    monkeypatch.setattr(Disk, "rename", seen)
    publish(target, b"new", overwrite=True)
    readers[0].join()
    assert (target / "summary.json").read_bytes() == b"new"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_two_batches_do_not_work_in_one_folder(tmp_path: Path) -> None:
    plan = read_plan("[changes]\ngrid.n_z = 40\ngrid.n_z_wall = 40\nrun.duration = '10 ms'\n[[points]]\nname = 'a'")
    claim = Claim(tmp_path / "out")
    with pytest.raises(WriteError, match="another process"):
        batch(plan, tmp_path / "out")
    claim.release()
    assert batch(plan, tmp_path / "out").status == "finished"


def test_pictures_and_tables_are_not_written_over_one_another(tmp_path: Path) -> None:
    ps.run("baseline", TINY, out=tmp_path / "run")
    ps.run("baseline", {**TINY, "pellet.dry_friction": "5 mN"}, out=tmp_path / "other")
    claim = Claim(tmp_path / "made")
    words = ["compare", str(tmp_path / "run"), str(tmp_path / "other"), "--out", str(tmp_path / "made")]
    assert main(words) == 4
    assert main(["export", str(tmp_path / "run"), "--out", str(tmp_path / "made")]) == 4
    claim.release()
    assert not (tmp_path / "made").exists()
    assert main(words) == 0
    assert main(words) == 4
