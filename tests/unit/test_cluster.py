"""Runs handed to a Dask scheduler with two workers, on this machine: the same table, lost workers survived."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from peristalsis.errors import ConfigurationError, WriteError
from peristalsis.many.studies.study import read_study
from peristalsis.many.studies.sweep import sweep
from peristalsis.running.pool import Failure, carry_out, engine_of

pytest.importorskip("distributed")

STUDY = """
outputs = ["transit_s", "final_position_cm", "max_axial_force_mN"]
[changes]
grid.n_z = 50
grid.n_z_wall = 40
run.duration = "50 ms"
[design]
kind = "sobol"
samples = 6
seed = 1
[parameters]
pellet.viscous_friction = { from = "60 mN*s/cm", to = "240 mN*s/cm" }
"""

PROGRAM = "from distributed.cli.{0} import main; main()"
PATIENCE = 120.0


def start(kind: str, *words: str) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    command = [sys.executable, "-c", PROGRAM.format(f"dask_{kind}"), *words]
    return subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def wait_for(file: Path) -> str:
    """The address that a scheduler writes into its file."""
    import json

    last = time.monotonic() + PATIENCE
    while time.monotonic() < last:
        if file.is_file() and file.read_text(encoding="utf-8").strip().endswith("}"):
            address: str = json.loads(file.read_text(encoding="utf-8"))["address"]
            return address
        os.sched_yield()
    raise AssertionError("the scheduler did not start")


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a scheduler with two workers, each a process with a nanny that replaces it; all end with the tests."""
    from distributed import Client

    place = tmp_path_factory.mktemp("dask")
    file = place / "scheduler.json"
    ends = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
    processes = [start("scheduler", *ends)]
    try:
        address = wait_for(file)
        for _ in range(2):
            words = (address, "--host", "127.0.0.1", "--nthreads", "1", "--no-dashboard")
            processes.append(start("worker", *words, "--local-directory", str(place)))
        with Client(address, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=PATIENCE)
        yield address
    finally:
        for process in reversed(processes):
            process.send_signal(signal.SIGTERM)
        for process in processes:
            try:
                process.wait(20.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def squared(number: int) -> int:
    return number * number


def breaks(number: int) -> int:
    raise WriteError("the disk is full") if number == 2 else ValueError("poison")


def kills_once(task: tuple[str, int]) -> int:
    """Kills its worker the first time."""
    folder, number = task
    mark = Path(folder, str(number))
    if number == 1 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def kills(number: int) -> int:
    if number == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def test_the_same_table_as_here(scheduler: str, tmp_path: Path) -> None:
    sweep(read_study(STUDY), tmp_path / "here" / "s")
    sweep(read_study(STUDY), tmp_path / "there" / "s", workers=scheduler)
    assert (tmp_path / "here/s/table.csv").read_bytes() == (tmp_path / "there/s/table.csv").read_bytes()


def test_an_engine_stays_open_for_several_rounds(scheduler: str) -> None:
    with engine_of(scheduler) as engine:
        for start_ in (0, 10):
            tasks = {str(number): number for number in range(start_, start_ + 5)}
            found = {done.key: done.value for done in carry_out(tasks, squared, engine)}
            assert found == {key: number * number for key, number in tasks.items()}


def test_what_raises_is_a_failure_and_what_cannot_go_on_ends_all(scheduler: str) -> None:
    (done,) = carry_out({"a": 1}, breaks, scheduler)
    assert done.value == Failure("ValueError: poison")
    with pytest.raises(WriteError, match="the disk is full"):
        list(carry_out({"a": 2}, breaks, scheduler))


def test_a_lost_worker_is_survived(scheduler: str, tmp_path: Path) -> None:
    tasks = {str(number): (str(tmp_path), number) for number in range(4)}
    assert {done.key: done.value for done in carry_out(tasks, kills_once, scheduler)} == {
        str(number): number for number in range(4)
    }


def test_a_piece_that_kills_every_worker_is_a_failure(scheduler: str) -> None:
    found = {done.key: done.value for done in carry_out({str(n): n for n in range(3)}, kills, scheduler)}
    assert found["1"] == Failure("its process died, 4 times"), "the same words each time: they stand in tables"
    assert (found["0"], found["2"]) == (0, 2)


def test_an_address_where_nothing_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    from peristalsis.running import cluster

    monkeypatch.setattr(cluster, "CONNECT", 1.0)
    for address in ("tcp://127.0.0.1:9", "nonsense://here"):
        with pytest.raises(ConfigurationError, match="dask scheduler"), engine_of(address):
            pass
