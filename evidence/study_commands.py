"""Commands of the package as processes: what they cost, and what was measured kept as JSON, for `studies`."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from common import ROOT

LOOK = 0.1
"""Seconds between two looks at the processes."""
TICKS = os.sysconf("SC_CLK_TCK")


def measured(folder: Path, name: str, make: Callable[[], Any]) -> Any:
    """What FOLDER/NAME.json has, made and written first where it is missing."""
    file = folder / f"{name}.json"
    if not file.is_file():
        print(f"measuring {name} ...", file=sys.stderr, flush=True)
        found = make()
        folder.mkdir(parents=True, exist_ok=True)
        file.with_suffix(".part").write_text(json.dumps(found, indent=1), encoding="utf-8")
        file.with_suffix(".part").replace(file)
    return json.loads(file.read_text(encoding="utf-8"))


def rows_of(file: Path) -> list[dict[str, str]]:
    """The rows of a CSV table."""
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def environment() -> dict[str, str]:
    """That of the processes: this package, one thread each."""
    path = os.pathsep.join([str(ROOT / "src"), *(one for one in sys.path if one)])
    return {**os.environ, "PYTHONPATH": path, "MPLBACKEND": "Agg", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def start(*words: str, module: str = "peristalsis", log: Path | None = None) -> subprocess.Popen[bytes]:
    """A process of a module of Python; what it says goes to a file or nowhere."""
    if log is None:
        return _popen(words, module, subprocess.DEVNULL)
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("ab") as stream:
        return _popen(words, module, stream)


def _popen(words: Sequence[str], module: str, said: Any) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", module, *words]
    return subprocess.Popen(command, cwd=ROOT, env=environment(), stdout=said, stderr=said)


@dataclass
class Watched:
    """What processes have used: processor time [s] and the most memory [MB] of each, by its id; seconds by the clock.

    A look every tenth of a second: what a process uses after the last look before its end is not there.
    """

    parents: dict[int, int] = field(default_factory=dict)
    processor: dict[int, float] = field(default_factory=dict)
    memory: dict[int, float] = field(default_factory=dict)
    clock: float = 0.0

    def look(self, roots: Sequence[int]) -> None:
        """Look at these processes and all that they started."""
        for process in tree(roots):
            try:
                stat = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
                status = Path(f"/proc/{process}/status").read_text()
            except OSError:
                continue
            self.parents[process] = int(stat[1])
            self.processor[process] = (int(stat[11]) + int(stat[12])) / TICKS
            peak = next((line for line in status.splitlines() if line.startswith("VmHWM")), None)
            if peak is not None:
                self.memory[process] = int(peak.split()[1]) / 1024.0


def tree(roots: Sequence[int]) -> list[int]:
    """These processes and all below them."""
    children: dict[int, list[int]] = {}
    for entry in os.scandir("/proc"):
        if entry.name.isdigit():
            try:
                parent = int(Path(entry.path, "stat").read_text().rpartition(")")[2].split()[1])
            except OSError:
                continue
            children.setdefault(parent, []).append(int(entry.name))
    found, queue = [], list(roots)
    while queue:
        found.append(queue.pop())
        queue += children.get(found[-1], [])
    return found


@contextmanager
def watched(*roots: int) -> Iterator[Watched]:
    """Look at processes, and at what they start, while this lasts; what they had used before is taken off."""
    before = Watched()
    before.look(roots)
    seen, over = Watched(), threading.Event()

    def watch() -> None:
        while not over.wait(LOOK):
            seen.look(roots)

    thread, begin = threading.Thread(target=watch, daemon=True), time.monotonic()
    thread.start()
    try:
        yield seen
    finally:
        seen.clock = time.monotonic() - begin
        over.set()
        thread.join()
        for process, used in before.processor.items():
            if process in seen.processor:
                seen.processor[process] -= used


def carried_out(*words: str, log: Path) -> dict[str, Any]:
    """Carry a command of the package out to its end: exit code, seconds by the clock and of processors."""
    process = start(*words, log=log)
    with watched(process.pid) as seen:
        code = process.wait()
    return {"words": list(words), "code": code, "clock": seen.clock, "processor": sum(seen.processor.values())}
