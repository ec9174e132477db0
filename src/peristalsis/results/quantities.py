"""Quantities of a run, defined on plain arrays: velocity, irregularity, stops, librations, mixing.

Each is None where the arrays do not hold it: no step, no pellet (positions are nan), no motion, no content.

Mixing follows the content around the pellet. The content fills the lumen less the pellet and is compressed uniformly
(one pressure), so its share S upstream of a wall node changes only as content passes that node. In the coordinates s
(share upstream) and y (share of the cross-section inside a radius), with the parabolic profile of slow flow in a tube
whose wall moves with its own velocity,

    ds/dt = g (1 - 2y),    dy/dt = -g_s (y - y^2),    g = -dS/dt at the wall,

which keeps content, has no flow through the ends, and does nothing where wall and content move together. Its mean over
the cross-section is zero: plug flow would leave every tracer at its s, and can stretch content but never mix it. Beside
a pellet that touches the wall the content passes in order, as through a thin film. A solid bolus is not mixed itself:
the number is about the fluid around it.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CELLS_OF_FLOW = 200
"""Equal parts of the content on which the flow is interpolated."""


def mean_velocity(time: Floats, position: Floats, until: float | None = None) -> float | None:
    """Displacement over time [cm/s], up to `until` [s] or to the end. time [s], position [cm]: (n,).

    None if no time passes, or if the track ends before `until`.
    """
    if not _known(time, position):
        return None
    end = float(time[-1]) if until is None else until
    if not time[0] < end <= time[-1]:
        return None
    return float((np.interp(end, time, position) - position[0]) / (end - time[0]))


def _known(*arrays: Floats) -> bool:
    """Whether there is anything in each array, and nothing that is not a number."""
    return all(array.size > 0 and bool(np.isfinite(array).all()) for array in arrays)


def on_its_way(position: Floats, shares: tuple[float, float]) -> slice | None:
    """Steps between the first passages of two shares of the largest displacement; None if it never moves forward."""
    if not _known(position):
        return None
    travelled = np.maximum.accumulate(position - position[0])
    if travelled[-1] <= 0.0:
        return None
    first, last = (int(np.searchsorted(travelled, share * travelled[-1])) for share in shares)
    return slice(first, last + 1)


def irregularity(
    time: Floats,
    position: Floats,
    bin_length: float = 0.05,
    shares: tuple[float, float] = (0.05, 0.95),
    least_travel: float = 0.1,
) -> float | None:
    """Standard deviation over mean of the velocity [1], averaged over bins [s], while the pellet is on its way.

    The coefficient of variation: 0 for uniform motion, 1/sqrt(2) for 1 + sin, 1 for equal times of going and standing.
    None below `least_travel` [cm], or if the way takes fewer than two bins.
    """
    part = on_its_way(position, shares)
    if part is None or position.max() - position[0] < least_travel:
        return None
    begin, end = float(time[part][0]), float(time[part][-1])
    count = int((end - begin) / bin_length)
    if count < 2:
        return None
    borders = np.interp(np.linspace(begin, end, count + 1), time, position)
    speeds = np.diff(borders) / ((end - begin) / count)
    return float(speeds.std() / speeds.mean()) if speeds.mean() > 0.0 else None


def stops(
    time: Floats,
    position: Floats,
    speed: float = 0.01,
    length: float = 0.1,
    shares: tuple[float, float] = (0.05, 0.95),
) -> int | None:
    """Times of at least `length` [s] below `speed` [cm/s], while the pellet is on its way; 0 if it never is."""
    if not _known(time, position):
        return None
    part = on_its_way(position, shares)
    if part is None or time[part].size < 3:
        return 0
    slow = np.abs(np.gradient(position[part], time[part])) < speed
    edges = np.flatnonzero(np.diff(np.concatenate([[False], slow, [False]]).astype(np.int8)))
    moments = time[part]
    lengths = [moments[stop - 1] - moments[start] for start, stop in zip(edges[::2], edges[1::2], strict=True)]
    return sum(1 for one in lengths if one >= length - 1e-9)


def turning_points(position: Floats, least: float) -> list[float]:
    """First place, the extremes between which the pellet goes at least `least` [cm], and the last extreme."""
    points = [float(position[0])]
    low = high = float(position[0])
    rising: bool | None = None
    for place in position[1:].tolist():
        low, high = min(low, place), max(high, place)
        if rising is not False and place < high - least:
            if rising or high > points[0] + least:
                points.append(high)
            rising, low, high = False, place, place
        elif rising is not True and place > low + least:
            if rising is False or low < points[0] - least:
                points.append(low)
            rising, low, high = True, place, place
    points.append(high if rising else low if rising is False else float(position[-1]))
    return points


def reversals(position: Floats, least: float = 0.01) -> int | None:
    """Times the pellet goes back by at least `least` [cm]."""
    if not _known(position):
        return None
    points = turning_points(position, least)
    return sum(1 for before, after in pairwise(points) if before - after >= least)


def libration(position: Floats, least: float = 0.001) -> float | None:
    """Half of the largest swing that is undone [cm]: the smaller of two neighbouring swings."""
    if not _known(position):
        return None
    swings = np.abs(np.diff(turning_points(position, least)))
    if swings.size < 2:
        return 0.0
    return 0.5 * float(np.minimum(swings[:-1], swings[1:]).max())


def content_upstream(
    radius: Floats,
    axial: Floats,
    centre: Floats | None = None,
    displaced: Callable[[Floats], Floats] | None = None,
) -> Floats:
    """Share of the content upstream of each wall node [1], shape (n_time, n_z): 0 at the oral, 1 at the anal end.

    nan at times at which the lumen holds nothing.

    radius, axial: of the wall nodes [cm], (n_time, n_z). centre: of the pellet [cm], (n_time,), or None.
    displaced: volume of the pellet [cm^3] oral of a distance from its centre [cm], as `PelletShape.volume_oral_of`.
    """
    inner = radius[:, 1:] ** 2 + radius[:, 1:] * radius[:, :-1] + radius[:, :-1] ** 2
    slices = np.pi / 3.0 * np.diff(axial, axis=1) * inner
    volume = np.concatenate([np.zeros((len(radius), 1)), np.cumsum(slices, axis=1)], axis=1)
    if centre is not None and displaced is not None:
        volume = volume - displaced(axial - centre[:, None])
    volume = np.maximum.accumulate(np.maximum(volume, 0.0), axis=1)
    whole = np.where(volume[:, -1:] > 0.0, volume[:, -1:], np.nan)
    share: Floats = np.minimum(volume / whole, 1.0)
    return share


def seeded(count: int) -> tuple[Floats, Floats]:
    """Tracers spread evenly over the content: s and y, each (count,), by a low-discrepancy sequence."""
    numbers = np.arange(count)
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    return (numbers + 0.5) / count, np.asarray((0.5 + golden * numbers) % 1.0)


def carried(time: Floats, upstream: Floats, s: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Tracers at the end of the flow that goes with `upstream`, shape (n_time, n_z), from their places s and y."""
    grid = np.linspace(0.0, 1.0, CELLS_OF_FLOW + 1)
    for step in range(len(time) - 1):
        dt = float(time[step + 1] - time[step])
        middle = 0.5 * (upstream[step] + upstream[step + 1])
        flow = np.interp(grid, middle, -(upstream[step + 1] - upstream[step]) / dt)
        flow[0] = flow[-1] = 0.0
        rate = np.gradient(flow, grid)
        parts = max(1, int(np.ceil(dt * max(np.abs(flow).max() * CELLS_OF_FLOW / 4.0, np.abs(rate).max()))))
        h = dt / min(parts, 50)
        for _ in range(min(parts, 50)):
            half_s = np.clip(s + 0.5 * h * np.interp(s, grid, flow) * (1.0 - 2.0 * y), 0.0, 1.0)
            half_y = np.clip(y - 0.5 * h * np.interp(s, grid, rate) * (y - y * y), 0.0, 1.0)
            s = np.clip(s + h * np.interp(half_s, grid, flow) * (1.0 - 2.0 * half_y), 0.0, 1.0)
            y = np.clip(y - h * np.interp(half_s, grid, rate) * (half_y - half_y * half_y), 0.0, 1.0)
    return s, y


def lacey_index(place: Floats, label: NDArray[np.bool_], cells: int = 20) -> float | None:
    """Lacey's mixing index of two kinds of tracers along a line: 0 in order, 1 mixed at random.

    (S0 - S)/(S0 - Sr) with S the variance of the share of one kind over cells of equally many tracers, S0 = c(1 - c)
    when separated and Sr = S0/n when n tracers a cell are mixed at random, which makes it independent of their number.
    P. M. C. Lacey, J. Appl. Chem. 4 (1954) 257; S/S0 is Danckwerts' intensity of segregation. None with one kind
    alone, or with fewer than two tracers a cell.
    """
    if len(place) < 2 * cells or not 0 < label.sum() < len(label):
        return None
    order = np.argsort(place, kind="stable")
    each = len(order) // cells
    shares = label[order][: each * cells].reshape(cells, each).mean(axis=1)
    mean = float(label.mean())
    separated = mean * (1.0 - mean)
    found = (separated - float(((shares - mean) ** 2).mean())) / (separated * (1.0 - 1.0 / each))
    return min(max(found, 0.0), 1.0)


def mixing(time: Floats, upstream: Floats, tracers: int = 4000, cells: int = 20) -> float | None:
    """Mixing of the oral and the anal half of the content by the flow that goes with `upstream`, from 0 to 1.

    time [s], (n_time,); upstream: see `content_upstream`.
    """
    if len(time) < 2 or not _known(upstream):
        return None
    s, y = seeded(tracers)
    oral = s < 0.5
    return lacey_index(carried(time, upstream, s, y)[0], oral, cells)
