"""What a kernel depends on, and that nothing else makes it be compiled anew; `test_compiled_cache` has the rest."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import peristalsis
from peristalsis.numerics import compiled as compiling
from peristalsis.numerics import kept
from peristalsis.numerics.sources import KERNEL_FOLDERS, dependencies

PACKAGE = Path(peristalsis.__file__).parent
KERNELS = [file for folder in KERNEL_FOLDERS for file in sorted((PACKAGE / folder).rglob("*.py"))]

DEEP = """
from .compiled import compiled

FACTOR = 2.0


@compiled
def deep(x):
    return FACTOR * x
"""
MIDDLE = "from .deep import (\n    deep,\n)\n"
OUTER = """
from .compiled import compiled
from . import middle

inner = middle.deep


@compiled
def outer(x):
    return inner(x) + 1.0
"""
PROBE = """
from peristalsis.numerics.{module} import {module} as kernel
print(kernel(3.0), sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values()))
"""


def imported(file: Path) -> set[Path]:
    """Files of the package that a file imports, by Python's own grammar."""
    found: set[Path] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = file.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            names = [base / f"{alias.name}.py" for alias in node.names]
            found |= {place for place in (base.with_suffix(".py"), base / "__init__.py", *names) if place.is_file()}
        else:
            assert not (isinstance(node, ast.ImportFrom) and (node.module or "").startswith("peristalsis"))
            if isinstance(node, ast.Import):
                assert not any(alias.name.startswith("peristalsis") for alias in node.names)
    return found


@pytest.mark.parametrize("file", KERNELS, ids=lambda file: file.relative_to(PACKAGE).as_posix())
def test_everything_a_kernel_imports_is_known(file: Path) -> None:
    """A file left out here would be a stale kernel one day."""
    expected, waiting = {file}, [file]
    while waiting:
        new = imported(waiting.pop()) - expected
        expected |= new
        waiting += new
    assert dependencies(file) == expected


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A copy of the package with three files more: a kernel that calls another by way of a third file."""
    numerics = tmp_path / "src" / "peristalsis" / "numerics"
    shutil.copytree(PACKAGE, numerics.parent, ignore=shutil.ignore_patterns("__pycache__"))
    for name, text in {"deep": DEEP, "middle": MIDDLE, "outer": OUTER}.items():
        (numerics / f"{name}.py").write_text(text, encoding="utf-8")
    return numerics


def command(tree: Path, cache: Path, module: str = "outer") -> subprocess.Popen[str]:
    """A process that calls a kernel of the copy and prints its value, cache hits and misses."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith("COV")}  # a copy is no source
    environment |= {"PYTHONPATH": str(tree.parents[1]), "NUMBA_CACHE_DIR": str(cache)}
    environment |= {"HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null", "PYTHONDONTWRITEBYTECODE": "1"}
    words = [sys.executable, "-c", PROBE.format(module=module)]
    return subprocess.Popen(words, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def told(process: subprocess.Popen[str]) -> tuple[float, int, int]:
    """Value, hits, misses."""
    out, err = process.communicate()
    assert process.returncode == 0, err
    value, hits, misses = out.split()
    return float(value), int(hits), int(misses)


def test_a_change_two_files_away_is_seen_and_nothing_else_is_compiled(tree: Path, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    assert told(command(tree, cache)) == (7.0, 0, 1)
    assert told(command(tree, cache)) == (7.0, 1, 0)
    (tree / "deep.py").write_text(DEEP.replace("2.0", "5.0"), encoding="utf-8")
    assert told(command(tree, cache)) == (16.0, 0, 1)
    (tree / "outer.py").write_text(OUTER.replace("1.0", "3.0"), encoding="utf-8")
    assert told(command(tree, cache)) == (18.0, 0, 1)
    assert told(command(tree, cache, "deep")) == (15.0, 1, 0)
    (tree / "outer.py").write_text(OUTER, encoding="utf-8")
    assert told(command(tree, cache)) == (16.0, 1, 0)


@pytest.mark.parametrize(
    ("named", "usable", "expected"),
    [
        (True, ("named", "home"), "named"),
        (True, ("home",), "home/peristalsis"),
        (False, ("home",), "home/peristalsis"),
        (True, (), None),
    ],
)
def test_cache_is_in_the_first_folder_that_can_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: bool, usable: tuple[str, ...], expected: str | None
) -> None:
    """That of NUMBA_CACHE_DIR, else the user's; none where a file stands in the place of both."""
    for name in {"named", "home"} - set(usable):
        (tmp_path / name).write_text("", encoding="utf-8")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    if named:
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "named"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    found = compiling._cache_folder()
    assert found == (None if expected is None else tmp_path / expected)
    assert found is None or list(found.iterdir()) == []


def test_kernels_are_compiled_without_any_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling, "CACHE_FOLDER", None)
    kernel = compiling.compiled(lambda x: 2.0 * x + 1.0)
    assert kernel(3.0) == 7.0
    assert kernel.stats.cache_path is None  # type: ignore[attr-defined]


def test_damaged_file_is_forgotten_and_compiled_anew() -> None:
    """What cannot be read counts as not there; what can be is handed on."""
    told: list[str] = []

    class Cache:
        _py_func = test_kernels_are_compiled_without_any_cache

        def load_overload(self, name: str, context: object) -> str:
            if name == "half":
                raise EOFError
            return f"whole {name}"

        def flush(self) -> None:
            told.append("forgotten")

        def save_overload(self, name: str, made: object) -> None:
            raise RuntimeError("no compiled object yet")

    cache = Cache()
    kept.keep(SimpleNamespace(_cache=cache), Path(), "")
    assert cache.load_overload("one", None) == "whole one"
    assert told == []
    cache.save_overload("one", None)  # what cannot be written is used all the same
    assert cache.load_overload("half", None) is None
    assert told == ["forgotten"]
