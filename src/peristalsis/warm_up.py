"""Compile every kernel once, on a tube too small to matter, so that no run pays for it unseen."""

from __future__ import annotations

import time
from functools import cache


@cache
def _compile(columns: int) -> float:
    from .build import build
    from .config import Configuration
    from .model.fields import corner_tensions
    from .model.guards import violation
    from .model.initial import initial_state
    from .model.step import advance
    from .model.step_summary import summary_of_step

    begin = time.perf_counter()
    tiny = Configuration().with_changes({"grid.n_z": 200, "grid.n_z_wall": 100, "grid.n_theta": columns})
    if columns > 1:
        tiny = tiny.with_changes({"pacemaker.angular_width": "90 deg"})
    model, before, _ = initial_state(build(tiny))
    after, _ = advance(model, before)
    violation(model, after)
    summary_of_step(model, before, after)
    corner_tensions(after.wall, model.wall)
    return time.perf_counter() - begin


def warm_up(surface: bool = False) -> float:
    """Compile or load all kernels; seconds it took the first time in this process.

    surface: those of the wall and the sheets on the whole surface too, which take some minutes to compile.
    """
    return _compile(1) + (_compile(8) if surface else 0.0)
