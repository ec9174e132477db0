"""The parts of a step that are timed one by one: which function each is, by name; a change of names is made here."""

from __future__ import annotations

import importlib
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from .clock import Spent

SOLVER = {"solver": ("model.stepping", "advance_run")}
STEP = {
    "conduction": ("model.sheets", "advance_layer"),
    "wall": ("model.step", "solve_wall"),
    "trigger": ("model.step", "_listen_to_muscle"),
    "receptors": ("model.step", "_listen_to_stretch"),
}
"""Part to (module of the package, function in it). Functions of a mapping call none but themselves of it."""


@contextmanager
def clocked(parts: Mapping[str, tuple[str, str]]) -> Iterator[dict[str, Spent]]:
    """Time that is spent in these functions within the block, by part; a function within itself counts once.

    Raises AttributeError for a function that is not there (any more).
    """
    spent = {name: Spent(0.0, 0.0) for name in parts}
    restored: list[tuple[Any, str, Any]] = []

    def watched(name: str, function: Any) -> Any:
        depth = 0

        def call(*args: Any, **more: Any) -> Any:
            nonlocal depth
            depth += 1
            wall, cpu = time.perf_counter(), time.process_time()
            try:
                return function(*args, **more)
            finally:
                depth -= 1
                if depth == 0:
                    before = spent[name]
                    spent[name] = Spent(
                        before.wall + time.perf_counter() - wall, before.cpu + time.process_time() - cpu
                    )

        return call

    try:
        for name, (module, function) in parts.items():
            home = importlib.import_module(f"peristalsis.{module}")
            original = getattr(home, function)
            restored.append((home, function, original))
            setattr(home, function, watched(name, original))
        yield spent
    finally:
        for home, function, original in restored:
            setattr(home, function, original)
