"""Measurements of whole processes: time on the clock and of the processor, and the most memory they held."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from peristalsis.errors import PeristalsisError

from .clock import Spent

PEAK = """
def peak():
    import resource, sys
    try:
        for line in open("/proc/self/status"):
            if line.startswith("VmHWM:"):
                return 1024 * int(line.split()[1])
    except OSError:
        pass
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
print(peak())
"""
"""The most memory that a process held, told by itself. Where there is /proc, from there: Linux counts for `getrusage`
what the parent held when it started the process."""


@dataclass(frozen=True)
class Ended:
    """A process that ended well: what it took with all it had waited for, and its output."""

    spent: Spent
    output: str


def measured(words: Sequence[str], more: Mapping[str, str] | None = None, cwd: Path | None = None) -> Ended:
    """Run a Python process (`words` behind the interpreter's name) to its end.

    more: variables of its environment beside those of this process. Raises PeristalsisError with the end of its
    messages if it fails.
    """
    import tempfile

    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(entry for entry in sys.path if entry), **(more or {})}
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as messages:
        begin = time.perf_counter()
        process = subprocess.Popen(
            [sys.executable, *words], stdin=subprocess.DEVNULL, stdout=out, stderr=messages, env=environment, cwd=cwd
        )
        try:
            _, status, usage = os.wait4(process.pid, 0)
        except BaseException:
            process.kill()
            process.wait()
            raise
        wall = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            messages.seek(0)
            said = messages.read().decode(errors="replace").strip()[-400:]
            raise PeristalsisError(f"{' '.join(words)[:120]} ended with code {process.returncode}: {said}")
        out.seek(0)
        output = out.read().decode(errors="replace")
    spent = Spent(wall, usage.ru_utime + usage.ru_stime)
    return Ended(spent, output)


def code(text: str, more: Mapping[str, str] | None = None) -> Ended:
    """Run a piece of Python text in a fresh process."""
    return measured(["-c", text], more)


def peak_bytes(text: str) -> int:
    """The largest resident memory of a fresh process that runs a piece of Python text."""
    return int(code(f"{text}\n{PEAK}").output.split()[-1])
