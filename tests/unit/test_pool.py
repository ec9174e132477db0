"""Work in processes: what dies or raises harms nothing else, and what was asked for is done once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from peristalsis.errors import WriteError
from peristalsis.running.pool import Done, Failure, carry_out


def poisoned(task: tuple[str, int]) -> int:
    """Square of a number; every fifth process is killed, every seventh task raises."""
    _, number = task
    if number % 5 == 4:
        os.kill(os.getpid(), signal.SIGKILL)
    if number % 7 == 6:
        raise ValueError("poison")
    return number * number


def dies_twice(task: tuple[str, int]) -> int:
    """Done at the third attempt; every attempt leaves a mark."""
    folder, number = task
    attempt = len(list(Path(folder).glob(f"{number}-*")))
    Path(folder, f"{number}-{attempt}").touch()
    if attempt < 2:
        os._exit(3)
    return number


def fails_to_write(task: tuple[str, int]) -> int:
    """What a full disk does to the third task."""
    if task[1] == 2:
        raise WriteError("the disk is full")
    return task[1]


def raises(task: tuple[str, int]) -> int:
    raise ValueError("poison")


def says_who(task: tuple[str, int]) -> int:
    return os.getpid()


def tasks(count: int, folder: object = "") -> dict[str, tuple[str, int]]:
    return {f"task {number}": (str(folder), number) for number in range(count)}


def test_failures_do_not_spread() -> None:
    """R8: of 20 tasks the poisoned ones fail with their reason, and all others have their value."""
    found = {done.key: done.value for done in carry_out(tasks(20), poisoned, workers=2, retries=0)}
    assert len(found) == 20
    for number in range(20):
        value = found[f"task {number}"]
        if number % 5 == 4:
            assert isinstance(value, Failure)
            assert "SIGKILL" in value.error
        elif number % 7 == 6:
            assert value == Failure("ValueError: poison")
        else:
            assert value == number * number


def test_a_process_that_dies_is_tried_again(tmp_path: Path) -> None:
    found = list(carry_out(tasks(2, tmp_path), dies_twice, workers=2, retries=2))
    assert sorted(found, key=lambda done: done.key) == [Done("task 0", 0), Done("task 1", 1)]
    assert len(list(tmp_path.iterdir())) == 6


def test_one_that_always_dies_is_a_failure(tmp_path: Path) -> None:
    found = list(carry_out(tasks(2, tmp_path), dies_twice, workers=2))
    assert all(done.value == Failure("its process ended by itself with exit code 3, 2 times") for done in found)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_full_disk_ends_everything(workers: int) -> None:
    with pytest.raises(WriteError, match="the disk is full"):
        list(carry_out(tasks(20), fails_to_write, workers=workers))


def test_one_worker_works_here() -> None:
    assert [done.value for done in carry_out(tasks(3), says_who)] == [os.getpid()] * 3
    (done,) = carry_out(tasks(1), raises, workers=8)
    assert done.value == Failure("ValueError: poison")


def test_stopping_half_way_leaves_no_process() -> None:
    made = carry_out(tasks(6), says_who, workers=2)
    first = next(made)
    made.close()
    assert isinstance(first.value, int)
    with pytest.raises(ProcessLookupError):
        os.kill(first.value, 0)


ORPHANS = """
import os, sys, time
from peristalsis.running.pool import carry_out
def work(task):
    os.write(1, b"%d;" % os.getpid())
    time.sleep(60)
if __name__ == "__main__":
    list(carry_out({"a": 1, "b": 2}, work, workers=2))
"""


def test_processes_end_with_the_one_that_started_them(tmp_path: Path) -> None:
    """A parent that is killed leaves nobody behind who writes into its folders."""
    program = tmp_path / "orphans.py"
    program.write_text(ORPHANS, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    command = [sys.executable, str(program)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as parent:
        assert parent.stdout is not None
        said = ""
        while said.count(";") < 2:
            said += parent.stdout.read(1)
        children = [int(child) for child in said.split(";")[:2]]
        parent.kill()
        parent.communicate(timeout=30)  # returns when the last holder of the pipe, the children among them, is gone
    deadline = time.monotonic() + 10.0
    while any(Path(f"/proc/{child}/status").exists() for child in children) and time.monotonic() < deadline:
        os.sched_yield()
    assert not any(Path(f"/proc/{child}/status").exists() for child in children)
    assert parent.returncode == -signal.SIGKILL


UNGUARDED = """
from peristalsis.running.pool import carry_out
def own(task):
    return task
print([done.value for done in carry_out({{"a": 1, "b": 2}}, {work}, workers=2)])
"""


@pytest.mark.parametrize("source", ["file", "standard input"])
@pytest.mark.parametrize("work", ["abs", "own"])
def test_a_program_without_a_guard(work: str, source: str, tmp_path: Path) -> None:
    """Neither work of a module nor that of the program itself needs one: the program is not read again."""
    text = UNGUARDED.format(work=work)
    program = tmp_path / "program.py"
    program.write_text(text, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    words = [sys.executable, str(program) if source == "file" else "-"]
    done = subprocess.run(
        words, input=text if source != "file" else "", capture_output=True, text=True, env=environment, check=False
    )
    assert (done.returncode, done.stdout) in ((0, "[1, 2]\n"), (0, "[2, 1]\n"))
    assert done.stderr == ""
