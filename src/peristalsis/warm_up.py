"""Compile every kernel once, on a tube too small to matter, so that no run pays for it unseen."""

from __future__ import annotations

import time
from functools import cache


@cache
def _compile(columns: int, integrator: str = "implicit") -> float:
    from .build import build
    from .config import Configuration
    from .model.balance import work_of_step
    from .model.contact_summary import contact_summary
    from .model.fields import corner_tensions, end_reactions
    from .model.initial import initial_state
    from .model.step import advance

    begin = time.perf_counter()
    tiny = Configuration().with_changes({"grid.n_z": 200, "grid.n_z_wall": 100, "grid.n_theta": columns})
    if integrator == "explicit":
        tiny = tiny.with_changes({"solver.integrator": integrator, "wall.surface_density": "26.14 g/cm^2"})
    if columns > 1:
        tiny = tiny.with_changes({"pacemaker.angular_width": "90 deg"})
    model, before, _ = initial_state(build(tiny))
    after, _ = advance(model, before)
    work_of_step(model, before, after)
    contact_summary(model, after)
    end_reactions(after.wall, model.wall, after.pressure)
    corner_tensions(after.wall, model.wall)
    return time.perf_counter() - begin


def warm_up(surface: bool = False, explicit: bool = False) -> float:
    """Compile or load all kernels; seconds it took the first time in this process.

    surface: those of the wall and the sheets on the whole surface too, which take some minutes to compile. explicit:
    those of the explicit scheme too.
    """
    return _compile(1) + (_compile(8) if surface else 0.0) + (_compile(1, "explicit") if explicit else 0.0)
