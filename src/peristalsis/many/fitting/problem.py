"""How far runs are from what was observed, and how that changes with the parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...errors import DivergenceError
from ...inputs.config import Configuration
from ..engine import Progress
from ..passage import passage
from ..rows import Row
from ..sweep import sweep
from .observed import Observed
from .parameters import Free

Floats = NDArray[np.float64]

DIFFERENCE = 0.01
"""Change of a coordinate from which derivatives are taken, one per cent of a parameter.

A run moves on in steps, and the instants of triggers and receptors are found to parts of one, so a track is rough in
its parameters by some 1e-3 mm. Over one per cent a conductance moves it by up to 0.5 mm: derivatives are then good to
about one per cent, from curvature and roughness alike. From a change of 1e-6, right for a smooth function, they would
be made of roughness (docs/fitting.md has the numbers).
"""
LAST = 0.1
"""Seconds from which the speed is taken with which a pellet that is out goes on."""
SPARE = 0.05
"""Seconds that a run goes on beyond the last observation."""


@dataclass(frozen=True)
class Offsets:
    """Which offsets are found besides, for each track its own: of place [cm], of time [s]. They need no runs."""

    place: bool = False
    time: bool = False


@dataclass
class Problem:
    """Observed tracks, a configuration, what is free in it, and the folder in which finished runs are kept.

    Coordinates x: one for each free parameter, then the offsets that are free, a place and a time for each track.
    """

    observed: Sequence[Observed]
    base: Configuration
    free: Sequence[Free]
    folder: Path
    offsets: Offsets = field(default_factory=Offsets)
    workers: int = 1
    progress: Progress | None = None
    refusals: dict[tuple[float, ...], str] = field(default_factory=dict)
    runs: int = 0

    def __post_init__(self) -> None:
        last = max(float(one.time[-1]) for one in self.observed) + SPARE
        changes = {"run.duration": f"{min(last, self.base.run.duration)!r} s"} if last < self.base.run.duration else {}
        self.simulated = self.base.with_changes(changes) if changes else self.base

    @property
    def names(self) -> tuple[str, ...]:
        """Of all coordinates."""
        found = [one.name for one in self.free]
        for one in self.observed:
            found += [f"place of {one.name}"] if self.offsets.place else []
            found += [f"time of {one.name}"] if self.offsets.time else []
        return tuple(found)

    @property
    def start(self) -> Floats:
        """Coordinates at the start."""
        return np.array([one.coordinate(one.start) for one in self.free] + [0.0] * (len(self.names) - len(self.free)))

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Smallest and largest coordinates; offsets have none."""
        more = len(self.names) - len(self.free)
        low = [one.coordinate(one.low) for one in self.free] + [-np.inf] * more
        high = [one.coordinate(one.high) for one in self.free] + [np.inf] * more
        return np.array(low), np.array(high)

    @property
    def size(self) -> int:
        """How many positions were observed."""
        return sum(one.time.size for one in self.observed)

    def residuals(self, x: Floats) -> Floats:
        """Place in the model less the one observed [cm], (n,), all tracks one after another; nan where a run failed."""
        return self.residuals_at([x])[0]

    def residuals_at(self, points: Sequence[Floats]) -> list[Floats]:
        """As `residuals` for several points at once, whose runs may go side by side."""
        configurations: dict[str, Configuration] = {}
        places: dict[tuple[int, int], str] = {}
        for number, x in enumerate(points):
            for which, one in enumerate(self.observed):
                places[number, which] = name = self._name(x, one)
                if name not in configurations:
                    configurations[name] = self.configuration(x, one)
        rows = sweep(configurations, self.folder, passage, self.workers, self._see)
        found = []
        for number, x in enumerate(points):
            parts = []
            for which, one in enumerate(self.observed):
                row = rows[places[number, which]]
                if "time_step" not in row.arrays or row.status == DivergenceError.status:
                    self.refusals[tuple(x)] = str(row.summary.get("error") or row.status)
                    parts.append(np.full(one.time.size, np.nan))
                    continue
                place, time = self._offsets_of(x, which)
                parts.append(track_at(row, one.time - time) + place - one.place)
            found.append(np.concatenate(parts))
        return found

    def jacobian(self, x: Floats, held: int | None = None) -> Floats:
        """Derivatives of the residuals by the coordinates, (n, m), by differences of runs, or of the track for offsets.

        held: a coordinate that stays as it is, whose column is left out.

        A difference goes to the other side at a bound, and where a run fails; nan where both do.
        """
        low, high = self.bounds
        points, steps = [x], []
        moving = [k for k in range(len(self.free)) if k != held]
        for k in moving:
            step = DIFFERENCE if x[k] + DIFFERENCE <= high[k] else -DIFFERENCE
            steps.append(step)
            points.append(_moved(x, k, step))
        first, *others = self.residuals_at(points)
        columns = [(other - first) / step for other, step in zip(others, steps, strict=True)]
        for at, (k, step) in enumerate(zip(moving, steps, strict=True)):
            if not np.isfinite(columns[at]).all() and low[k] <= x[k] - step <= high[k]:
                columns[at] = (self.residuals(_moved(x, k, -step)) - first) / -step
        begin, at = 0, len(self.free)
        for one in self.observed:
            own = slice(begin, begin + one.time.size)
            begin = own.stop
            if self.offsets.place:
                columns.append(_only(first, own, 1.0))
                at += 1
            if self.offsets.time:
                columns.append(
                    _only(first, own, (self.residuals(_moved(x, at, DIFFERENCE))[own] - first[own]) / DIFFERENCE)
                )
                at += 1
        return np.stack(columns, axis=1)

    def unevenness(self, x: Floats, jacobian: Floats) -> tuple[float, ...]:
        """How much the derivative by each free parameter differs on its other side, as a share of it; nan if unknown.

        A smooth track is curved by some hundredths over two per cent; a jump of the model between them shows at once.
        """
        low, high = self.bounds
        found = []
        for k in range(len(self.free)):
            inside = low[k] <= x[k] - DIFFERENCE and x[k] + DIFFERENCE <= high[k]
            size = float(np.linalg.norm(jacobian[:, k]))
            if not inside or size == 0.0:
                found.append(float("nan"))
                continue
            below = (self.residuals(x) - self.residuals(_moved(x, k, -DIFFERENCE))) / DIFFERENCE
            found.append(float(np.linalg.norm(below - jacobian[:, k]) / size))
        return tuple(found)

    def configuration(self, x: Floats, one: Observed | None = None) -> Configuration:
        """The configuration at a point; of the run for one track, or, without one, to be run by the user."""
        changes: dict[str, object] = {}
        for k, free in enumerate(self.free):
            changes |= free.changes(float(x[k]))
        if one is None:
            return self.base.with_changes(changes)
        return self.simulated.with_changes({**one.changes, **changes})

    def modelled(self, x: Floats) -> list[Floats]:
        """Places in the model at the observed times [cm], offsets and all, one array a track."""
        differences = self.residuals(x)
        ends = np.cumsum([one.time.size for one in self.observed])[:-1]
        return [part + one.place for part, one in zip(np.split(differences, ends), self.observed, strict=True)]

    def _offsets_of(self, x: Floats, which: int) -> tuple[float, float]:
        """Offsets of place [cm] and time [s] of a track."""
        each = int(self.offsets.place) + int(self.offsets.time)
        own = list(x[len(self.free) + each * which : len(self.free) + each * (which + 1)])
        place = float(own.pop(0)) if self.offsets.place else 0.0
        return place, float(own.pop(0)) if self.offsets.time else 0.0

    def _name(self, x: Floats, one: Observed) -> str:
        values = ", ".join(free.text(free.value(float(x[k]))) for k, free in enumerate(self.free))
        exact = ",".join(float(x[k]).hex() for k in range(len(self.free)))
        return f"{values} | {exact} {sorted(map(str, one.changes.items()))}"

    def _see(self, step: object) -> None:
        from ..rows import Step

        assert isinstance(step, Step)
        self.runs += not step.kept
        if self.progress is not None:
            self.progress(step)


def track_at(row: Row, time: Floats) -> Floats:
    """Place of the pellet's centre [cm] at times [s]: at rest before the start; out of the tube it goes on as it left.

    So a run that ends before the observations still says how far from them it is, and continuously.
    """
    times, places = row.arrays["time_step"], row.arrays["pellet_position"]
    found = np.interp(time, times, places)
    beyond = time > times[-1]
    if beyond.any():
        before = max(float(times[-1]) - LAST, float(times[0]))
        speed = (places[-1] - np.interp(before, times, places)) / max(float(times[-1]) - before, 1e-12)
        found[beyond] = places[-1] + speed * (time[beyond] - times[-1])
    return np.asarray(found)


def _moved(x: Floats, k: int, by: float) -> Floats:
    moved = x.copy()
    moved[k] += by
    return moved


def _only(like: Floats, part: slice, value: float | Floats) -> Floats:
    column = np.zeros_like(like)
    column[part] = value
    return column


def as_values(free: Sequence[Free], x: Floats) -> Mapping[str, float]:
    """Values of the free parameters by name."""
    return {one.name: one.value(float(x[k])) for k, one in enumerate(free)}
