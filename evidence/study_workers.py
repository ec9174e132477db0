"""What `studies` measures of who runs: the same table from any workers, what they cost, what their death does."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from study_commands import environment, rows_of, start, tree, watched

RUNS = 200
STUDY = """scenario = "baseline"
outputs = ["transit_s", "mean_velocity_cm_s", "max_axial_force_mN", "final_position_cm", "stops"]
[changes]
grid.n_z = 80
grid.n_z_wall = 60
step.wall = "10 ms"
run.duration = "3 s"
[design]
kind = "sobol"
samples = {samples}
seed = 7
[parameters.pellet]
viscous_friction = {{ from = "60 mN*s/cm", to = "480 mN*s/cm", scale = "log" }}
dry_friction = {{ from = "10 mN", to = "400 mN", scale = "log" }}
[parameters.muscle]
keys = ["longitudinal.active", "circular.active"]
relative = true
from = 0.5
to = 1.0
"""
"""On a coarse grid with long steps: a run takes a quarter to a third of a second."""
WAYS = ("1 worker", "2 workers", "Dask, 2 workers")
REPEATS = 3
KILLS, SEED = 5, 3
PATIENCE = 120.0
POISON = """
import os, signal
from peristalsis.running.simulation import Simulation
run = Simulation.run
def poisoned(self, *given, **named):
    if abs(self.configuration.pellet.viscous_friction - {friction!r}) < 1e-9:
        os.kill(os.getpid(), signal.SIGKILL)
    return run(self, *given, **named)
Simulation.run = poisoned
"""
"""A file of a user that kills the process at one point, each time."""
POISONED = 8
"""The point that does so."""


def study(folder: Path, samples: int = RUNS) -> Path:
    """The study's file, in a folder of its own."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "study.toml"
    file.write_text(STUDY.format(samples=samples), encoding="utf-8")
    return file


def words_of(folder: Path, *more: str, samples: int = RUNS) -> tuple[str, ...]:
    """The command that carries the study out, with its tables and its kept runs below a folder."""
    return ("sweep", str(study(folder, samples)), "--out", str(folder / "study"), "--no-plots", *more)


def digest(folder: Path) -> str:
    """Of the table, to the bit."""
    return hashlib.sha256((folder / "study" / "table.csv").read_bytes()).hexdigest()


def done(folder: Path) -> int:
    """Runs that are kept."""
    place = folder / "kept"
    return sum(one.name.endswith(".npz") and not one.name.startswith(".") for one in os.scandir(place)) if (
        place.is_dir()
    ) else 0  # fmt: skip


def empty(folder: Path) -> Path:
    """A folder without what an earlier call left."""
    import shutil

    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


@contextmanager
def dask(folder: Path) -> Iterator[tuple[str, list[int]]]:
    """Address of a scheduler with two worker processes on this machine, and the processes; all end with this."""
    file = folder / "scheduler.json"
    file.unlink(missing_ok=True)
    here = ("--host", "127.0.0.1", "--no-dashboard")
    words = (*here, "--port", "0", "--scheduler-file", str(file))
    processes = [start(*words, module="distributed.cli.dask_scheduler", log=folder / "dask.log")]
    try:
        last = time.monotonic() + PATIENCE
        while not (file.is_file() and file.read_text().strip().endswith("}")):
            if time.monotonic() > last:
                raise TimeoutError("the scheduler did not start")
            time.sleep(0.1)
        address = str(json.loads(file.read_text())["address"])
        for _ in range(2):
            more = (address, *here, "--nthreads", "1", "--local-directory", str(folder))
            processes.append(start(*more, module="distributed.cli.dask_worker", log=folder / "dask.log"))
        from distributed import Client

        with Client(address, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=PATIENCE)
        yield address, [one.pid for one in processes]
    finally:
        for process in reversed(processes):
            process.send_signal(signal.SIGTERM)
        for process in processes:
            try:
                process.wait(30.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def timed(folder: Path, way: str) -> dict[str, Any]:
    """The whole study once, nothing kept before: clock, processor time, memory, table."""
    empty(folder)
    if way.startswith("Dask"):
        with dask(folder) as (address, processes):
            return _timed(folder, ("--scheduler", address), processes)
    return _timed(folder, ("--workers", way.split()[0]), ())


def _timed(folder: Path, who: Sequence[str], beside: Sequence[int]) -> dict[str, Any]:
    process = start(*words_of(folder, *who), log=folder / "said.log")
    with watched(process.pid, *beside) as seen:
        code = process.wait()
    memory = {one: seen.memory[one] for one in seen.memory if one != process.pid}
    return {
        "code": code,
        "clock": seen.clock,
        "processor": sum(seen.processor.values()),
        "parent_memory": seen.memory[process.pid],
        "worker_memory": sorted((round(one, 1) for one in memory.values()), reverse=True)[:2],
        "table": digest(folder),
        "rows": len(rows_of(folder / "study" / "table.csv")),
    }


def workers_below(process: int) -> list[int]:
    """Processes of loky, or of Dask's nannies, that carry runs out: those that have used most processor time."""
    found: dict[int, float] = {}
    for one in tree([process])[1:]:
        try:
            line = Path(f"/proc/{one}/cmdline").read_bytes()
            stat = Path(f"/proc/{one}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if b"resource_tracker" not in line:
            found[one] = float(stat[11])
    return sorted(found, key=lambda one: -found[one])


def killed(folder: Path) -> dict[str, Any]:
    """The study, killed five times at moments drawn by a seed, the one who began it or a worker, and gone on with."""
    empty(folder)
    random = np.random.default_rng(SEED)
    moments = sorted(int(one) for one in random.choice(np.arange(10, RUNS - 10), KILLS, replace=False))
    victims = ["parent", "parent", "parent", "worker", "worker"]
    random.shuffle(victims)
    delays = random.uniform(0.0, 0.3, KILLS)
    words = words_of(folder, "--workers", "2")
    process = start(*words, log=folder / "said.log")
    told: list[dict[str, Any]] = []
    for moment, victim, delay in zip(moments, victims, delays, strict=True):
        while done(folder) < moment and process.poll() is None:
            time.sleep(0.02)
        time.sleep(float(delay))
        below = workers_below(process.pid)
        chosen = process.pid if victim == "parent" else below[int(random.integers(0, min(len(below), 2)))]
        before = done(folder)
        os.kill(chosen, signal.SIGKILL)
        if victim == "parent":
            process.wait()
            begin = time.monotonic()
            while any(Path(f"/proc/{one}").exists() for one in below) and time.monotonic() - begin < 20.0:
                time.sleep(0.02)
            told.append({"victim": victim, "kept": before, "workers_gone": time.monotonic() - begin})
            process = start(*words, log=folder / "said.log")
        else:
            told.append({"victim": victim, "kept": before})
    code = process.wait()
    return {"kills": told, "code": code, "table": digest(folder), "left": _left(folder)}


def _left(folder: Path) -> int:
    """Files among the kept runs that are none."""
    return sum(one.name.startswith(".") for one in os.scandir(folder / "kept"))


def poisoned(folder: Path, way: str) -> dict[str, Any]:
    """Twenty points of the study, one of which kills whoever carries it out, each time; then again without that."""
    empty(folder)
    samples = 20
    clean = empty(folder / "clean")
    start(*words_of(clean, samples=samples), log=clean / "said.log").wait()
    expected = rows_of(clean / "study" / "table.csv")
    friction = float(expected[POISONED - 1]["pellet.viscous_friction [mN*s/cm]"])
    file = folder / "poison.py"
    file.write_text(POISON.format(friction=friction), encoding="utf-8")
    os.environ["PERISTALSIS_PLUGIN_CODE"] = str(file)
    try:
        if way.startswith("Dask"):
            with dask(folder) as (address, _):
                code = start(*words_of(folder, "--scheduler", address, samples=samples), log=folder / "said.log").wait()
        else:
            code = start(*words_of(folder, "--workers", "2", samples=samples), log=folder / "said.log").wait()
    finally:
        del os.environ["PERISTALSIS_PLUGIN_CODE"]
    found = rows_of(folder / "study" / "table.csv")
    row = found[POISONED - 1]
    others = [one == two for k, (one, two) in enumerate(zip(found, expected, strict=True), 1) if k != POISONED]
    again = start(*words_of(folder, samples=samples), log=folder / "said.log").wait()
    return {
        "code": code,
        "others_equal": sum(others),
        "others": len(others),
        "status": row["status"],
        "error": row["error"],
        "again_code": again,
        "again_equal": digest(folder) == digest(clean),
    }


JOBQUEUE = """
import peristalsis as ps
from dask_jobqueue.local import LocalCluster

with LocalCluster(cores=1, processes=1, memory="2GB", worker_extra_args=["--no-dashboard"]) as cluster:
    cluster.scale(jobs=2)
    ps.sweep({file!r}, {out!r}, workers=cluster.scheduler_address)
"""


def jobqueue(folder: Path) -> dict[str, Any]:
    """Twenty points by the recipe of docs/studies.md, with the class of dask-jobqueue whose jobs run here."""
    try:
        import dask_jobqueue
    except ImportError:
        return {"version": None}
    empty(folder)
    clean = empty(folder / "clean")
    start(*words_of(clean, samples=20), log=clean / "said.log").wait()
    program = JOBQUEUE.format(file=str(study(folder, 20)), out=str(folder / "study"))
    command = [sys.executable, "-c", program]
    ended = subprocess.run(command, cwd=folder, env=environment(), capture_output=True, text=True, timeout=500.0)
    return {
        "version": dask_jobqueue.__version__,
        "code": ended.returncode,
        "said": ended.stderr[-2000:],
        "equal": (folder / "study" / "table.csv").is_file() and digest(folder) == digest(clean),
    }
