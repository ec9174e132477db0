"""Where the package runs: systems without POSIX locks, and variables of the environment with odd values."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from peristalsis.numerics import compiled, sources

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
TINY = {"grid.n_z": 50, "grid.n_z_wall": 60, "run.duration": "10 ms", "output.interval": "5 ms"}


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


@pytest.mark.parametrize("value", ["0", "-3", "abc"])
def test_a_number_of_threads_that_numba_refuses_is_said_and_harmless(value: str) -> None:
    """Runs use one thread. numba itself raises for 0, and prints a traceback for a word."""
    done = started(
        "-c", "import peristalsis.numerics.compiled as c; print(c.numba.config.OPT)", NUMBA_NUM_THREADS=value
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert f"NUMBA_NUM_THREADS = '{value}' is not what numba understands" in done.stderr
    assert "unset it" in done.stderr


def test_a_backend_that_matplotlib_does_not_know_is_a_sentence() -> None:
    program = """
from peristalsis.errors import ConfigurationError
from peristalsis.plots import style
try:
    with style.applied():
        pass
except ConfigurationError as error:
    print(error)
"""
    done = started("-c", program, MPLBACKEND="bad")
    assert done.stdout.strip() == "MPLBACKEND = 'bad' is no backend of matplotlib; unset it, or set it to agg"


def test_settings_of_the_compiler_have_kernels_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """numba's cache does not look at them: kernels compiled without optimisation were everybody's from then on."""
    file = sources.PACKAGE / "numerics" / "roots.py"
    monkeypatch.delenv("NUMBA_OPT", raising=False)
    usual = sources.kernel_digest.__wrapped__(file)
    monkeypatch.setenv("NUMBA_OPT", "0")
    assert sources.kernel_digest.__wrapped__(file) != usual


def test_a_cache_is_never_made_in_the_working_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Where nobody knows the home folder, it stays "~"; a relative XDG_CACHE_HOME is to be ignored."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert compiled._cache_folder() == tmp_path / "home" / ".cache" / "peristalsis"
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)
    assert compiled._cache_folder() is None
    assert [file.name for file in tmp_path.iterdir()] == ["home"]
