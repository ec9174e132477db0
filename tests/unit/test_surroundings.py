"""Where the package runs: systems without POSIX locks, and variables of the environment with odd values."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

WITHOUT_LOCKS = """
import sys
class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name == "fcntl":
            raise ModuleNotFoundError("No module named 'fcntl'", name="fcntl")
sys.meta_path.insert(0, Blocker())
sys.modules.pop("fcntl", None)
import os
for flag in ("O_NOFOLLOW", "O_CLOEXEC", "O_NONBLOCK"):
    delattr(os, flag)
"""
TINY = {"grid.n_z": 50, "grid.n_z_wall": 60, "run.duration": "4 ms", "output.interval": "2 ms"}


def started(*words: str, **variables: str | None) -> subprocess.CompletedProcess[str]:
    """Python with these words, and with these variables set, or unset if None."""
    changed = {**os.environ, **variables}
    environment = {name: value for name, value in changed.items() if value is not None}
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False, env=environment)


def test_without_posix_locks_whatever_writes_nothing_works_and_writing_is_refused(tmp_path: Path) -> None:
    """As on Windows: a run in Python, listing and validating; a run into a folder is one sentence beforehand."""
    table = tmp_path / "pressure.csv"
    table.write_text("time [s],value [kPa]\n0,0.2\n1,0.3\n", encoding="utf-8")
    program = f"""{WITHOUT_LOCKS}
import peristalsis as ps
from peristalsis.cli import main
result = ps.run("baseline", {TINY!r} | {{"protocols": ["lumen.pressure: table {table}"]}})
print(result.status, main(["list"]))
try:
    ps.run("baseline", {TINY!r}, out={str(tmp_path / "kept")!r})
except ps.PeristalsisError as error:
    print(type(error).__name__, error)
print(main(["run", "baseline", "--out", {str(tmp_path / "told")!r}]))
"""
    done = started("-c", program)
    assert "Traceback" not in done.stderr
    first, *_, refused, code = done.stdout.splitlines()
    assert first, done.stderr
    assert "in_transit 0" in done.stdout
    assert refused.startswith("WriteError this system has no POSIX file locks")
    assert "WSL" in refused
    assert code == "4"
    assert "POSIX" in done.stderr
    assert sorted(file.name for file in tmp_path.iterdir()) == ["pressure.csv"]
