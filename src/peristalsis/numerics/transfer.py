"""Transfer between grids by averages over overlapping cells, Eq. (33): integrals are conserved."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compiled import compiled

Floats = NDArray[np.float64]


class Overlap(NamedTuple):
    """Averaging weights in rows: target t takes sources indices[start[t]:start[t+1]] with these weights."""

    start: NDArray[np.int64]
    indices: NDArray[np.int64]
    weights: Floats


def overlap(source_edges: Floats, target_edges: Floats) -> Overlap:
    """Weights that turn averages over source cells into averages over target cells.

    source_edges, target_edges: increasing cell edges, shapes (n_source + 1,) and (n_target + 1,); the source
    must cover the target. Each row sums to one, so constants are kept, and so is every integral over the line.
    """
    # Cutting at the edges of both grids leaves pieces that lie in one source and one target cell each.
    inner = source_edges[(source_edges > target_edges[0]) & (source_edges < target_edges[-1])]
    cuts = np.unique(np.concatenate([target_edges, inner]))
    widths, middles = np.diff(cuts), 0.5 * (cuts[1:] + cuts[:-1])
    target = np.searchsorted(target_edges, middles, side="right") - 1
    source = np.searchsorted(source_edges, middles, side="right") - 1
    kept = widths > 1e-12 * np.diff(target_edges)[target]
    target, source, widths = target[kept], source[kept], widths[kept]
    totals = np.bincount(target, widths, minlength=target_edges.size - 1)
    start = np.concatenate([[0], np.cumsum(np.bincount(target, minlength=target_edges.size - 1))])
    return Overlap(start.astype(np.int64), source.astype(np.int64), widths / totals[target])


def interpolation(source: Floats, target: Floats) -> Overlap:
    """Weights that interpolate linearly between increasing source points, constant beyond the first and last."""
    position = np.clip(np.interp(target, source, np.arange(source.size)), 0.0, source.size - 1.0)
    left = np.minimum(position.astype(np.int64), source.size - 2)
    share = position - left
    return Overlap(
        2 * np.arange(target.size + 1, dtype=np.int64),
        np.stack([left, left + 1], axis=1).ravel(),
        np.stack([1.0 - share, share], axis=1).ravel(),
    )


def reconstruction(sources: int, low: Floats, high: Floats, points: int) -> Overlap:
    """Weights from averages over equal cells to averages over other stretches, or to values where low = high.

    low, high: ends of the stretches, in cells from the first edge. Each sees the polynomial of degree points - 1 whose
    averages over the `points` cells nearest its middle are theirs. With an odd number, all stretches within a cell see
    one polynomial, and the cell's own average is kept; with an even number, values between two centres do.
    """
    points = min(points, sources)
    middle = 0.5 * (low + high)
    left = np.floor(middle - 0.5 * (1 - points % 2) + 1e-9) - (points - 1) // 2
    first = np.clip(left, 0, sources - points).astype(np.int64)
    powers, cells = np.arange(points), np.arange(points)
    # Rows: the averages of t^p over the cells of a stencil; the weights reproduce those of the target.
    moments = ((cells + 1.0) ** (powers[:, None] + 1) - cells ** (powers[:, None] + 1.0)) / (powers[:, None] + 1)
    a, b = (low - first)[:, None], (high - first)[:, None]
    # (b^(p+1) - a^(p+1)) / (b - a) as a sum, which holds where the ends meet.
    wanted = np.stack([sum(a**k * b ** (p - k) for k in range(p + 1))[:, 0] / (p + 1) for p in powers], axis=1)
    weights = np.linalg.solve(moments, wanted.T).T
    return Overlap(
        points * np.arange(low.size + 1, dtype=np.int64),
        (first[:, None] + cells).ravel().astype(np.int64),
        np.ascontiguousarray(weights).ravel(),
    )


def periodic_overlap(sources: int, targets: int) -> Overlap:
    """Weights that turn averages over equal source cells into averages over equal target cells of a closed ring.

    Cell k of n is centred at k/n of the ring. Targets must divide sources: each then takes the whole
    sources around its own centre and, where their number is even, half of one on either side.
    """
    ratio = _ratio_of_rings(sources, targets)
    reach = ratio // 2
    row = np.full(2 * reach + 1, 1.0 / ratio)
    if ratio % 2 == 0:
        row[0] = row[-1] = 0.5 / ratio
    indices = (ratio * np.arange(targets)[:, None] + np.arange(-reach, reach + 1)) % sources
    return Overlap(
        row.size * np.arange(targets + 1, dtype=np.int64),
        indices.ravel().astype(np.int64),
        np.tile(row, targets),
    )


def periodic_interpolation(sources: int, targets: int, offset: float = 0.0) -> Overlap:
    """Weights that interpolate linearly around a closed ring, from places (k + offset)/sources to (j + offset)/targets.

    offset 0 is for centres, 0.5 for the faces that follow them. As many targets as sources: nothing is changed.
    """
    ratio = _ratio_of_rings(targets, sources)
    place = (np.arange(targets) + offset) / ratio - offset
    left = np.floor(place)
    share = place - left
    first = left.astype(np.int64)
    return Overlap(
        2 * np.arange(targets + 1, dtype=np.int64),
        (np.stack([first, first + 1], axis=1) % sources).ravel(),
        np.stack([1.0 - share, share], axis=1).ravel(),
    )


def trigonometric(field: Floats, targets: int) -> Floats:
    """Values on equal columns of a closed ring, (..., n), at `targets` columns, a multiple, by their Fourier series.

    Column j of either stands at j/n of the ring; the highest mode of an even n is taken as a cosine. Values at columns
    of both rings and the mean around the ring are kept, to rounding, and what does not vary to the last bit.
    """
    sources = field.shape[-1]
    _ratio_of_rings(targets, sources)
    if targets == sources:
        return field
    base = field[..., :1]
    spectrum = np.fft.rfft(field - base, axis=-1)
    if sources % 2 == 0:
        spectrum[..., -1] *= 0.5
    return np.asarray(base + np.fft.irfft(spectrum, n=targets, axis=-1) * (targets / sources))


def _ratio_of_rings(fine: int, coarse: int) -> int:
    if coarse < 1 or fine % coarse != 0:
        raise ValueError(
            f"{fine} columns are not a multiple of {coarse}: choose one, so that every column keeps its place"
        )
    return fine // coarse


@compiled
def average(weights: Overlap, source: np.ndarray, target: np.ndarray) -> None:
    """Write the average of `source` (shape (n_source, n_theta)) over each target cell into `target`."""
    for t in range(target.shape[0]):
        for j in range(target.shape[1]):
            total = 0.0
            for k in range(weights.start[t], weights.start[t + 1]):
                total += weights.weights[k] * source[weights.indices[k], j]
            target[t, j] = total


@compiled
def average_within(weights: Overlap, source: np.ndarray, target: np.ndarray) -> None:
    """`average` with the weights of a `reconstruction`, kept between the least and the largest value that it uses."""
    for t in range(target.shape[0]):
        for j in range(target.shape[1]):
            total, least, most = 0.0, np.inf, -np.inf
            for k in range(weights.start[t], weights.start[t + 1]):
                value = source[weights.indices[k], j]
                total += weights.weights[k] * value
                least = min(least, value)
                most = max(most, value)
            target[t, j] = min(max(total, least), most)


@compiled
def average_around(weights: Overlap, source: np.ndarray, target: np.ndarray) -> None:
    """Write the average of `source` (shape (n, n_source)) over each target column into `target`, row by row.

    Taken relative to one of the sources, so that a row without variation stays so to the last bit.
    """
    for i in range(target.shape[0]):
        for t in range(target.shape[1]):
            base = source[i, weights.indices[weights.start[t]]]
            total = 0.0
            for k in range(weights.start[t], weights.start[t + 1]):
                total += weights.weights[k] * (source[i, weights.indices[k]] - base)
            target[i, t] = base + total
