"""Copies of the package with something put wrong in them: which tests notice, and what the baseline does."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Patch:
    """One exact text of one file of the package, and what stands there instead; it must occur `times` times."""

    file: str
    old: str
    new: str
    times: int = 1


@contextmanager
def patched(patches: Sequence[Patch]) -> Iterator[Path]:
    """A temporary tree of the repository with the patches applied. Raises ValueError for a text not found."""
    with tempfile.TemporaryDirectory(prefix="patched-") as folder:
        tree = Path(folder)
        for name in ("src", "tests", "verification", "benchmarks"):
            shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("pyproject.toml", "README.md"):
            shutil.copy(ROOT / name, tree / name)
        for patch in patches:
            file = tree / "src" / "peristalsis" / patch.file
            text = file.read_text(encoding="utf-8")
            if text.count(patch.old) != patch.times:
                raise ValueError(f"{patch.file}: {patch.old!r} occurs {text.count(patch.old)} times, not {patch.times}")
            file.write_text(text.replace(patch.old, patch.new), encoding="utf-8")
        yield tree


def _environment(tree: Path) -> dict[str, str]:
    return os.environ | {
        "PYTHONPATH": str(tree / "src"),
        "NUMBA_CACHE_DIR": str(tree / "cache"),
        "MPLBACKEND": "Agg",
        "OMP_NUM_THREADS": "1",
    }


def failing_tests(tree: Path, files: Sequence[str], limit: float = 900.0, first: bool = False) -> list[str]:
    """Names of the tests that fail in a tree; [\"(hangs)\"] beyond the limit [s]. first: stop at the first."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--no-header", "--tb=no", *files]
    if first:
        command.append("-x")
    try:
        done = subprocess.run(
            command, cwd=tree, env=_environment(tree), capture_output=True, text=True, timeout=limit, check=False
        )
    except subprocess.TimeoutExpired:
        return ["(hangs)"]
    found = re.findall(r"^(?:FAILED|ERROR) (\S+?)(?:\[| -|$)", done.stdout, flags=re.MULTILINE)
    if done.returncode != 0 and not found:
        return ["(does not run)"]
    return list(dict.fromkeys(found))


def baseline(tree: Path, changes: Sequence[str] = (), limit: float = 900.0) -> dict[str, object]:
    """The summary of the baseline in a tree, or a status that says how it broke off."""
    command = [sys.executable, "-m", "peristalsis", "run", "baseline", "--no-plots", "--json"]
    command += ["--out", str(tree / "out")]
    for change in changes:
        command += ["--set", change]
    try:
        done = subprocess.run(
            command, cwd=tree, env=_environment(tree), capture_output=True, text=True, timeout=limit, check=False
        )
    except subprocess.TimeoutExpired:
        return {"status": f"no end within {limit:.0f} s"}
    try:
        answer: dict[str, object] = json.loads(done.stdout)
    except json.JSONDecodeError:
        return {"status": "broke off", "error": done.stderr.strip().splitlines()[-1:] or ""}
    return answer
