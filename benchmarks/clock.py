"""Times that survive a busy machine: processor time beside wall time, medians, ratios in turns, exponents."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Spent:
    """Seconds on the clock and of the processor that one measurement took."""

    wall: float
    cpu: float


@dataclass(frozen=True)
class Timing:
    """Repeated measurements: medians of wall and processor time [s], the least processor time, and how many."""

    wall: float
    cpu: float
    least: float
    repeats: int

    @classmethod
    def of(cls, spent: Sequence[Spent]) -> Timing:
        """Medians of at least one measurement."""
        cpu = [one.cpu for one in spent]
        return cls(statistics.median(one.wall for one in spent), statistics.median(cpu), min(cpu), len(spent))

    @property
    def share(self) -> float:
        """Processor time over wall time: 1 if the machine was free for this measurement."""
        return self.cpu / self.wall if self.wall > 0.0 else math.nan


class Stopwatch:
    """`with Stopwatch() as watch: ...`, then `watch.spent`: wall and processor time of this process."""

    spent: Spent

    def __enter__(self) -> Stopwatch:
        self._wall, self._cpu = time.perf_counter(), time.process_time()
        return self

    def __exit__(self, *_: object) -> None:
        self.spent = Spent(time.perf_counter() - self._wall, time.process_time() - self._cpu)


def once(call: Callable[[], object]) -> Spent:
    """What one call takes."""
    with Stopwatch() as watch:
        call()
    return watch.spent


def repeated(call: Callable[[], object], repeats: int) -> Timing:
    """Medians over calls."""
    return Timing.of([once(call) for _ in range(repeats)])


def in_turns(calls: Mapping[str, Callable[[], object]], repeats: int, least: float = 0.02) -> dict[str, Timing]:
    """Medians of one call of each, measured in turns, so that a load that comes and goes meets all of them.

    least: processor time [s] that a measurement should take; quick calls are made several times in a row.
    """
    counts = {}
    for name, call in calls.items():
        call()  # compiled, and in the caches
        counts[name] = max(1, math.ceil(least / max(once(call).cpu, 1e-7)))
    spent: dict[str, list[Spent]] = {name: [] for name in calls}
    for _ in range(repeats):
        for name, call in calls.items():
            count = counts[name]
            with Stopwatch() as watch:
                for _ in range(count):
                    call()
            spent[name].append(Spent(watch.spent.wall / count, watch.spent.cpu / count))
    return {name: Timing.of(found) for name, found in spent.items()}


@dataclass(frozen=True)
class Exponent:
    """Slope of log cost over log size by least squares, with the half width of its 95 % interval."""

    value: float
    half_width: float
    points: int


def exponent(sizes: Sequence[float], costs: Sequence[float]) -> Exponent:
    """Fit cost = a size^p. Raises ValueError with fewer than three points or costs that are not above zero."""
    if len(sizes) < 3 or len(sizes) != len(costs) or min(*sizes, *costs) <= 0.0:
        raise ValueError(f"no exponent can be told from sizes {list(sizes)} and costs {list(costs)}")
    from scipy.stats import t

    x, y = np.log(np.asarray(sizes, dtype=float)), np.log(np.asarray(costs, dtype=float))
    slope, offset = np.polyfit(x, y, 1)
    spread = float(((x - x.mean()) ** 2).sum())
    left = float(((y - slope * x - offset) ** 2).sum())
    degrees = len(sizes) - 2
    half = float(t.ppf(0.975, degrees)) * math.sqrt(left / degrees / spread)
    return Exponent(float(slope), half, len(sizes))


def plain(timing: Timing) -> dict[str, Any]:
    """A timing as it is kept."""
    return {"wall": timing.wall, "cpu": timing.cpu, "least": timing.least, "repeats": timing.repeats}
