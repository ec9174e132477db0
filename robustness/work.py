"""One case carried out: whatever comes of it is a row of plain data."""

from __future__ import annotations

import math
import signal
import time
import traceback
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
from plan import Case

import peristalsis as ps
from peristalsis.errors import PeristalsisError

LIMIT = 300.0
"""Seconds on the clock after which a run is stopped and called too slow."""
OTHER_WAYS = {
    "half the grid": ("grid", 0.5),
    "the doubled grid": ("grid", 2.0),
    "half the step": ("step", 0.5),
    "a hundred times the tolerance": ("tolerance", 100.0),
}
"""How a problem that was refused or broken off is tried again before that is believed."""
FURTHER = 0.05
"""Seconds beyond a break that another way must come to be a second opinion."""


class Watch:
    """Stops a run that takes too long, and remembers how far it came."""

    def __init__(self, limit: float) -> None:
        self.end = time.monotonic() + limit
        self.late = False

    def start(self, model: Any, state: Any) -> None:
        """Nothing before the first step."""

    def see(self, model: Any, before: Any, after: Any, report: Any) -> str | None:
        """A reason to stop, once the time is over."""
        self.late = time.monotonic() > self.end
        return "too slow" if self.late else None


def carry_out(case: Case, limit: float = LIMIT) -> dict[str, Any]:
    """The row of a case: outcome, sentence, summary, remarks, where the pellet went, seconds."""
    row: dict[str, Any] = {
        "number": case.number,
        "group": case.group,
        "scenario": case.scenario,
        "reading": case.reading,
        "changes": dict(case.changes),
    }
    begin = time.process_time()
    signal.signal(signal.SIGALRM, _hung)
    signal.alarm(math.ceil(2.0 * limit))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            row |= _outcome(case, limit)
        except PeristalsisError as error:
            row |= {"outcome": "diverged" if "t = " in str(error) else "refused", "sentence": str(error)}
        except TimeoutError as error:
            row |= {"outcome": "too_slow", "sentence": str(error)}
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            told = f"{type(error).__name__}: {error} ({last.name}, line {last.lineno})"
            row |= {"outcome": "traceback", "sentence": told}
        finally:
            signal.alarm(0)
    row["warnings"] = sorted({str(one.message) for one in caught})
    row["seconds"] = time.process_time() - begin
    return row


def _hung(*_: object) -> None:
    raise TimeoutError("a single step, or the start, took longer than twice the limit")


def _outcome(case: Case, limit: float) -> dict[str, Any]:
    configuration = ps.configuration(case.scenario, reading=case.reading, changes=dict(case.changes))
    watch = Watch(limit)
    simulation = ps.Simulation(configuration, observers=(watch,))
    result = simulation.run()
    summary = dict(result.summary)
    outcome = "too_slow" if watch.late else result.status
    found: dict[str, Any] = {
        "outcome": outcome,
        "summary": _plain(summary),
        "remarks": list(result.remarks),
        "events": sorted({str(event.kind) for event in simulation.events()}),
    }
    if outcome in ("diverged", "too_slow"):
        reached = f"came to t = {summary['simulated_s']:.4g} s"
        found["sentence"] = reached if watch.late else str(result.error)
    if configuration.pellet.enabled:
        position = np.asarray(result.arrays["pellet_position"])
        radius, length = configuration.pellet.radius, configuration.wall.length
        low, high = float(np.nanmin(position)), float(np.nanmax(position))
        found["ends"] = {"oral_pole": low - radius, "anal_pole": high + radius, "length": length}
    return found


def _plain(value: Any) -> Any:
    """The same in types that JSON has; numbers that are not finite stay, for the rules to see."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value


def altered(case: Case, what: str, factor: float) -> Case:
    """The same problem on other numbers."""
    c = ps.configuration(case.scenario, reading=case.reading, changes=dict(case.changes))
    changes = dict(case.changes)
    if what == "grid":
        changes["grid.n_z"] = max(8, round(c.grid.n_z * factor))
        changes["grid.n_z_wall"] = max(8, round(c.grid.n_z_wall * factor))
    elif what == "step":
        changes["step.wall"] = f"{c.step.wall * factor!r} ms"
        changes["step.conduction"] = f"{c.step.conduction * factor!r} ms"
    else:
        changes["solver.residual_tolerance"] = min(1e-2, c.solver.residual_tolerance * factor)
    return Case(case.number, case.group, case.scenario, case.reading, changes)


def second_opinion(case: Case, row: Mapping[str, Any]) -> str:
    """The first other way in which a refused start is found, or a broken run gets past its break; "" if none does."""
    broke = (row.get("summary") or {}).get("simulated_s", 0.0) if row["outcome"] == "diverged" else 0.0
    for name, (what, factor) in OTHER_WAYS.items():
        try:
            other = altered(case, what, factor)
        except PeristalsisError:
            return ""  # the configuration itself is refused, on any grid
        until = f"{broke + FURTHER:.6g} s"
        again = carry_out(
            Case(other.number, other.group, other.scenario, other.reading, {**other.changes, "run.duration": until})
        )
        if again["outcome"] not in ("diverged", "refused", "traceback", "crashed", "too_slow"):
            return name
    return ""
