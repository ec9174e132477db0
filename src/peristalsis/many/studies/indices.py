"""Indices of sensitivity from values of any function on the unit cube: Sobol', Morris, PAWN.

A method says at which points of the cube it wants the function, and what it makes of the values there. Sobol' indices
are scipy's (Saltelli's design), elementary effects after Morris and PAWN are SALib's.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigurationError
from .designs import unit_points

Floats = NDArray[np.float64]

LEVEL = 0.95
"""Confidence of every band."""
RESAMPLES = 500
"""Resamples of a bootstrap."""
LEVELS = 4
"""Levels of the grid of elementary effects."""
SLICES = 8
"""Parts of a range over which PAWN compares distributions."""
FEWEST_IN_SLICE = 4


@dataclass(frozen=True)
class Index:
    """One index of one variable, with its band."""

    variable: str
    name: str
    value: float
    low: float
    high: float


class Method(Protocol):
    """A way to indices.

    ranks: the index by which variables are ranked. finite: whether it needs a number at every point.
    """

    ranks: str
    finite: bool

    def runs(self, dimensions: int, samples: int) -> int:
        """How many values are needed."""

    def points(self, dimensions: int, samples: int, seed: int) -> Floats:
        """Where they are needed, (runs, dimensions), in the unit cube."""

    def indices(self, names: Sequence[str], points: Floats, values: Floats, seed: int) -> list[Index]:
        """The indices of every variable. values: (runs,)."""


class Sobol:
    """Shares of the variance: what a variable does alone (first), and with all its interactions (total)."""

    ranks, finite = "total", True

    def runs(self, dimensions: int, samples: int) -> int:
        return samples * (dimensions + 2)

    def points(self, dimensions: int, samples: int, seed: int) -> Floats:
        """Two matrices A and B, then A with each column of B. Raises ConfigurationError unless samples is 2^k."""
        if samples & (samples - 1):
            near = 1 << (samples.bit_length() - 1)
            raise ConfigurationError(
                f"design: samples = {samples}: Sobol' indices need a power of two, such as {near} or {2 * near}"
            )
        both = unit_points("sobol", 2 * dimensions, samples, seed)
        first, second = both[:, :dimensions], both[:, dimensions:]
        mixed = []
        for column in range(dimensions):
            mixed.append(first.copy())
            mixed[-1][:, column] = second[:, column]
        return np.concatenate([first, second, *mixed])

    def indices(self, names: Sequence[str], points: Floats, values: Floats, seed: int) -> list[Index]:
        """Bands by a bootstrap over the samples, percentiles."""
        samples = values.size // (len(names) + 2)
        parts = values.reshape(len(names) + 2, samples)
        whole = _sobol(parts)
        random = np.random.default_rng(seed)
        drawn = [_sobol(parts[:, random.integers(0, samples, samples)]) for _ in range(RESAMPLES)]
        low, high = np.nanquantile(drawn, [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL], axis=0)
        return [
            Index(name, kind, float(whole[k, d]), float(low[k, d]), float(high[k, d]))
            for d, name in enumerate(names)
            for k, kind in enumerate(("first", "total"))
        ]


def _sobol(parts: Floats) -> Floats:
    """First and total indices, (2, dimensions), from the values at A, B and the mixed matrices; 0 if nothing varies."""
    from scipy.stats import sobol_indices

    if np.ptp(parts) == 0.0:
        return np.zeros((2, parts.shape[0] - 2))
    func = {"f_A": parts[:1], "f_B": parts[1:2], "f_AB": parts[2:, None, :]}
    found = sobol_indices(func=func, n=parts.shape[1])
    return np.array([np.ravel(found.first_order), np.ravel(found.total_order)])


class Morris:
    """Elementary effects over the whole range: their mean size, their mean and their spread."""

    ranks, finite = "mean size", True

    def runs(self, dimensions: int, samples: int) -> int:
        return samples * (dimensions + 1)

    def points(self, dimensions: int, samples: int, seed: int) -> Floats:
        from_salib = salib("sample.morris")
        with _own_random_numbers():
            found = from_salib.sample(_problem(dimensions), samples, num_levels=LEVELS, seed=seed + 1)
        return np.clip(np.asarray(found), 1e-9, 1.0 - 1e-9)  # the ends of a normal distribution are nowhere

    def indices(self, names: Sequence[str], points: Floats, values: Floats, seed: int) -> list[Index]:
        with _own_random_numbers():
            found = salib("analyze.morris").analyze(
                _problem(len(names)), points, values,
                num_resamples=RESAMPLES, conf_level=LEVEL, num_levels=LEVELS, seed=seed + 1,
            )  # fmt: skip
        made: list[Index] = []
        for d, name in enumerate(names):
            size, half = float(found["mu_star"][d]), float(found["mu_star_conf"][d])
            mean, spread = float(found["mu"][d]), float(found["sigma"][d])
            made.append(Index(name, "mean size", size, max(size - half, 0.0), size + half))
            made += [Index(name, "mean", mean, np.nan, np.nan), Index(name, "spread", spread, np.nan, np.nan)]
        return made


class Pawn:
    """How far the distribution moves when one variable is held: defined wherever outputs can be put in order.

    The median over parts of its range of the largest distance between two cumulative distributions. Runs without the
    number, because the pellet stalled, stand behind all others in the order.
    """

    ranks, finite = "median distance", False

    def runs(self, dimensions: int, samples: int) -> int:
        return samples

    def points(self, dimensions: int, samples: int, seed: int) -> Floats:
        if samples < FEWEST_IN_SLICE * SLICES:
            raise ConfigurationError(
                f"design: samples = {samples}: PAWN compares {SLICES} parts of each range; give "
                f"{FEWEST_IN_SLICE * SLICES} or more"
            )
        return unit_points("sobol", dimensions, samples, seed)

    def indices(self, names: Sequence[str], points: Floats, values: Floats, seed: int) -> list[Index]:
        """Bands by a bootstrap over the runs, about the value: runs that are drawn twice move all distances up."""
        ordered = last_if_missing(values)
        whole = _pawn(points, ordered)
        random = np.random.default_rng(seed)
        picks = (random.integers(0, ordered.size, ordered.size) for _ in range(RESAMPLES // 5))
        drawn = [_pawn(points[pick], ordered[pick]) for pick in picks]
        low, high = whole + np.nanquantile(
            drawn - np.nanmedian(drawn, axis=0), [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL], axis=0
        )
        return [
            Index(name, "median distance", float(whole[d]), max(float(low[d]), 0.0), float(high[d]))
            for d, name in enumerate(names)
        ]


def last_if_missing(values: Floats) -> Floats:
    """The same with a number above all others where there is none: distances of ranks do not ask how far above."""
    finite = values[np.isfinite(values)]
    return np.where(np.isfinite(values), values, (finite.max() if finite.size else 0.0) + 1.0)


def _pawn(points: Floats, values: Floats) -> Floats:
    found = salib("analyze.pawn").analyze(_problem(points.shape[1]), points, values, S=SLICES)
    return np.asarray(found["median"])


def _problem(dimensions: int) -> dict[str, Any]:
    return {
        "num_vars": dimensions,
        "names": [str(d) for d in range(dimensions)],
        "bounds": [[0.0, 1.0]] * dimensions,
    }


def salib(module: str) -> Any:
    """A module of SALib. Raises ConfigurationError where the extra `studies` is missing."""
    import importlib

    try:
        return importlib.import_module(f"SALib.{module}")
    except ImportError:
        raise ConfigurationError(
            "this method needs SALib, which is not installed; install peristalsis with its extra `studies`, or choose "
            "--method sobol"
        ) from None


@contextmanager
def _own_random_numbers() -> Iterator[None]:
    """Leave numpy's shared random numbers, which SALib seeds, as they were."""
    state = np.random.get_state()  # noqa: NPY002
    try:
        yield
    finally:
        np.random.set_state(state)  # noqa: NPY002


METHODS: dict[str, Method] = {"sobol": Sobol(), "morris": Morris(), "pawn": Pawn()}
"""The methods by name."""
