"""A wheel's kernels, compiled for a level of processors: a run with them compiles nothing and has the same bits."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from unit.programs import tool

ROOT = Path(__file__).parents[2]

RUN = """
import json, sys
from pathlib import Path
import peristalsis.numerics.kept as kept
from peristalsis.numerics.compiled import KERNELS
kept.SHIPPED = Path(sys.argv[1])
import peristalsis as ps
changes = {"grid.n_z": "200", "grid.n_z_wall": "200", "run.duration": "0.2 s"}
result = ps.run("baseline", changes)
print(json.dumps([result.fingerprint, sum(sum(one.stats.cache_misses.values()) for one in KERNELS)]))
"""


@pytest.mark.slow
def test_a_run_with_the_kernels_of_a_wheel_compiles_nothing_and_has_the_same_bits(tmp_path: Path) -> None:
    objects, empty = tmp_path / "objects", tmp_path / "empty"
    tool("wheel").compile_kernels(objects, surface=False, explicit=False)

    def run(folder: Path, **more: str) -> tuple[str, int]:
        words = [sys.executable, "-c", RUN, str(folder)]
        done = subprocess.run(words, capture_output=True, text=True, check=True, env=os.environ | more)
        fingerprint, compiled = json.loads(done.stdout.splitlines()[-1])
        return fingerprint, compiled

    here, _ = run(tmp_path / "nothing")
    assert run(objects, NUMBA_CACHE_DIR=str(empty)) == (here, 0)
    assert not any(empty.rglob("*.nbc"))


def test_levels_are_for_machines_that_python_names() -> None:
    """Features as LLVM writes them, each switched on."""
    for processor, features in tool("wheel").LEVELS.values():
        assert processor
        assert all(one.startswith("+") and one == one.strip() for one in features.split(","))
