"""The cache of compiled kernels: never stale, never beside the sources, safe among processes, and not needed."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from llvmlite import binding

import peristalsis

PACKAGE = Path(peristalsis.__file__).parent

# A kernel of two files is what could go stale.
CALLER = """
from __future__ import annotations
from .callee import part
from ..numerics.compiled import compiled
@compiled
def whole(x: float) -> float:
    return 10.0 * part(x)
"""
CALLEE = """
from __future__ import annotations
from ..numerics.compiled import compiled
@compiled
def part(x: float) -> float:
    return x + {}
"""
ASK = (
    "from peristalsis.pellet.caller import whole; from peristalsis.numerics.compiled import CACHE_FOLDER;"
    "value = whole(2.0); print(value, sum(whole.stats.cache_misses.values()), CACHE_FOLDER is not None)"
)


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A copy of what kernels need of the package, with two kernels in two files of it, one calling the other."""
    copy = tmp_path / "site" / "peristalsis"
    for folder in ("numerics", "pellet"):
        (copy / folder).mkdir(parents=True)
    for name in ("binding.py", "compiled.py", "kept.py", "sources.py"):
        shutil.copy(PACKAGE / "numerics" / name, copy / "numerics")
    for folder in (copy, copy / "numerics", copy / "pellet"):
        (folder / "__init__.py").write_text("", encoding="utf-8")
    (copy / "pellet" / "caller.py").write_text(CALLER, encoding="utf-8")
    write_callee(copy, 1)
    return copy


def write_callee(package: Path, number: int) -> None:
    """The called kernel adds this number; the file keeps its times and its size."""
    file = package / "pellet" / "callee.py"
    times = (file.stat().st_atime_ns, file.stat().st_mtime_ns) if file.exists() else None
    file.write_text(CALLEE.format(number), encoding="utf-8")
    if times is not None:
        os.utime(file, ns=times)


def environment(package: Path, cache: Path, home: Path | None = None) -> dict[str, str]:
    """Of a process that uses this copy and this cache, and nothing of the user's."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("NUMBA_", "XDG_", "COV"))}
    return kept | {
        "PYTHONPATH": str(package.parent),
        "PYTHONDONTWRITEBYTECODE": "1",
        "NUMBA_CACHE_DIR": str(cache),
        "XDG_CACHE_HOME": str(home or cache.with_name("home")),
    }


def ask(package: Path, cache: Path, home: Path | None = None) -> tuple[float, int, bool]:
    """(value, kernels that had to be compiled, whether there is a cache) in a fresh process."""
    done = subprocess.run(
        [sys.executable, "-c", ASK], capture_output=True, text=True, check=True, env=environment(package, cache, home)
    )
    value, misses, kept = done.stdout.split()
    return float(value), int(misses), kept == "True"


def files(folder: Path) -> set[str]:
    return {file.relative_to(folder).as_posix() for file in folder.rglob("*")}


def test_second_process_compiles_nothing(package: Path, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    assert ask(package, cache) == (30.0, 1, True)
    assert ask(package, cache) == (30.0, 0, True)


def test_change_in_another_file_is_never_missed(package: Path, tmp_path: Path) -> None:
    """numba looks only at the caller's file, which has not changed; not even time and size of the other one have."""
    cache = tmp_path / "cache"
    assert ask(package, cache)[0] == 30.0
    write_callee(package, 5)
    assert ask(package, cache) == (70.0, 1, True)
    write_callee(package, 1)
    assert ask(package, cache) == (30.0, 0, True), "what was compiled for these sources is still there"


def test_another_checkout_shares_the_cache(package: Path, tmp_path: Path) -> None:
    """The same sources at another path, with other times, as in a fresh clone or a second environment."""
    cache = tmp_path / "cache"
    assert ask(package, cache) == (30.0, 1, True)
    clone = tmp_path / "clone" / "peristalsis"
    shutil.copytree(package, clone)
    for file in clone.rglob("*.py"):
        os.utime(file, (1.0, 1.0))
    assert ask(clone, cache) == (30.0, 0, True)


def test_installation_is_not_written_to(package: Path, tmp_path: Path) -> None:
    """A package that an administrator installed is read-only for who runs it."""
    before = files(package)
    ask(package, tmp_path / "cache")
    assert files(package) == before


@pytest.mark.parametrize("home_too", [False, True])
def test_unwritable_cache_is_done_without(package: Path, tmp_path: Path, home_too: bool) -> None:
    """A file stands where the folder should be, which not even the superuser can write into."""
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    home = blocked if home_too else tmp_path / "home"
    value, misses, kept = ask(package, blocked / "cache", home)
    assert value == 30.0
    assert kept is not home_too
    if home_too:
        assert ask(package, blocked / "cache", home)[0] == 30.0
    else:
        assert misses == 1
        assert ask(package, blocked / "cache", home) == (30.0, 0, True), "the user's own cache takes its place"


def test_processes_at_once_share_an_empty_cache(package: Path, tmp_path: Path) -> None:
    """All compile, none is disturbed, and what they leave is whole."""
    cache = tmp_path / "cache"
    started = [
        subprocess.Popen(
            [sys.executable, "-c", ASK], stdout=subprocess.PIPE, text=True, env=environment(package, cache)
        )
        for _ in range(3)
    ]
    for one in started:
        said, _ = one.communicate(timeout=120)
        assert one.returncode == 0
        assert said.split()[0] == "30.0"
    assert ask(package, cache) == (30.0, 0, True)


@pytest.mark.parametrize("kind", ["nbc", "nbi"])
def test_damaged_cache_is_made_anew(package: Path, tmp_path: Path, kind: str) -> None:
    """A file that a power failure cut short, of kernels or of their index, costs a compilation and no run."""
    cache = tmp_path / "cache"
    ask(package, cache)
    damaged = list(cache.rglob(f"*.{kind}"))
    assert damaged
    for file in damaged:
        file.write_bytes(file.read_bytes()[:30])
    assert ask(package, cache) == (30.0, 1, True)
    assert ask(package, cache) == (30.0, 0, True)


# --- kernels that come with the package -----------------------------------------------------------


def bring(package: Path, **other: str) -> Path:
    """Compile for any processor of this kind into the folder of the package, as `tools/wheel.py` does; that folder.

    other: what the file beside them says instead of the truth.
    """
    objects = package / "objects"
    settings = environment(package, objects) | {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    subprocess.run([sys.executable, "-c", ASK], capture_output=True, check=True, env=settings)
    about = {"triple": binding.get_process_triple(), "processor": "generic", "features": ""} | other
    (objects / "about.json").write_text(json.dumps(about), encoding="utf-8")
    return objects


def test_kernels_that_come_with_the_package_are_not_compiled(package: Path, tmp_path: Path) -> None:
    bring(package)
    assert ask(package, tmp_path / "cache") == (30.0, 0, True)
    assert not any((tmp_path / "cache").rglob("*.nb?")), "nothing is written"


@pytest.mark.parametrize(
    "other",
    [{"triple": "another-system"}, {"features": "+feature_of_no_processor"}, {"processor": "another"}, {"odd": ""}],
    ids=str,
)
def test_kernels_for_another_machine_are_left_alone(package: Path, tmp_path: Path, other: dict[str, str]) -> None:
    bring(package, **other)
    assert ask(package, tmp_path / "cache") == (30.0, 1, True)
    assert ask(package, tmp_path / "cache") == (30.0, 0, True), "and what was compiled instead is kept"


def test_kernels_of_other_sources_are_left_alone(package: Path, tmp_path: Path) -> None:
    bring(package)
    write_callee(package, 5)
    assert ask(package, tmp_path / "cache") == (70.0, 1, True)


@pytest.mark.parametrize("kind", ["nbc", "nbi"])
def test_damaged_kernels_of_the_package_are_compiled_anew(package: Path, tmp_path: Path, kind: str) -> None:
    for file in bring(package).rglob(f"*.{kind}"):
        file.write_bytes(file.read_bytes()[:30])
    assert ask(package, tmp_path / "cache") == (30.0, 1, True)
    assert ask(package, tmp_path / "cache") == (30.0, 0, True)


def test_kernels_are_compiled_for_a_processor_that_is_asked_for(package: Path, tmp_path: Path) -> None:
    bring(package)
    settings = environment(package, tmp_path / "cache") | {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    done = subprocess.run([sys.executable, "-c", ASK], capture_output=True, text=True, check=True, env=settings)
    assert done.stdout.split()[:2] == ["30.0", "1"]


def test_loading_leaves_out_what_only_compiling_needs(package: Path, tmp_path: Path) -> None:
    """Not scipy.linalg, whose BLAS numba looks for, nor what it knows of texts; a later kernel finds all."""
    ask(package, tmp_path / "cache")
    program = f"""
import sys
{ASK}
light = [name for name in ("scipy.linalg", "numba.cpython.unicode", "numba.np.linalg") if name in sys.modules]
import numpy as np
from peristalsis.numerics.compiled import compiled
@compiled
def more(x):
    return whole(np.sum(x))
print(light, more(np.ones(3)))
"""
    settings = environment(package, tmp_path / "cache")
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=settings)
    assert done.stdout.splitlines() == ["30.0 0 True", "[] 40.0"]


def test_decorating_does_not_import_numba(package: Path, tmp_path: Path) -> None:
    program = "import sys; from peristalsis.pellet.caller import whole; print('numba' in sys.modules, whole.__name__)"
    settings = environment(package, tmp_path / "cache")
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=settings)
    assert done.stdout.split() == ["False", "whole"]
