"""Compile every kernel once, on a tube too small to matter, so that no run pays for it unseen."""

from __future__ import annotations

import time
from functools import cache


@cache
def _compile(columns: int, integrator: str = "implicit") -> float:
    from dataclasses import replace

    from .build import build
    from .config import Configuration
    from .model.guards import advance_safely
    from .model.initial import initial_state
    from .observers import FieldRecorder, ScalarRecorder
    from .preflight import remarks

    begin = time.perf_counter()
    tiny = Configuration().with_changes({"grid.n_z": 200, "grid.n_z_wall": 100, "grid.n_theta": columns})
    if integrator == "explicit":
        tiny = tiny.with_changes({"solver.integrator": integrator, "wall.surface_density": "26.14 g/cm^2"})
    if columns > 1:
        tiny = tiny.with_changes({"pacemaker.angular_width": "90 deg"})
    remarks(tiny)
    model, before, _ = initial_state(build(tiny))
    if columns > 1:
        # One side of the tube pulls at once: a wall that varies around the ring takes ways that a uniform one does not.
        potential = before.circular.potential.copy()
        potential[:, 0] = model.circular.threshold + 5.0
        before = replace(before, circular=replace(before.circular, potential=potential))
    recorders = ScalarRecorder(), FieldRecorder(1)
    for recorder in recorders:
        recorder.start(model, before)
    for _ in range(1 if columns == 1 else 2):  # the sheets see a wall that varies from the second step on
        after, report = advance_safely(model, before)
        for recorder in recorders:
            recorder.see(model, before, after, report)
        before = after
    return time.perf_counter() - begin


def warm_up(surface: bool = False, explicit: bool = False) -> float:
    """Compile or load all kernels; seconds it took the first time in this process.

    surface: those of the wall and the sheets on the whole surface too, which take some minutes to compile. explicit:
    those of the explicit scheme too.
    """
    return _compile(1) + (_compile(8) if surface else 0.0) + (_compile(1, "explicit") if explicit else 0.0)
