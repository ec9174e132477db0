"""Designs: which combinations of values a study runs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigurationError
from .variables import Variable

Floats = NDArray[np.float64]

KINDS = ("grid", "list", "random", "latin_hypercube", "sobol")
DRAWN = ("random", "latin_hypercube", "sobol")
EXTENDED = ("random", "sobol")
"""Those of which the first points of a longer design are the whole of a shorter one."""
MOST_POINTS = 100_000


@dataclass(frozen=True)
class Design:
    """What combinations there are. samples, seed: of drawn designs."""

    kind: str = "grid"
    samples: int | None = None
    seed: int = 0

    def combinations(self, variables: Sequence[Variable]) -> list[dict[str, Any]]:
        """Name to value for every point, in order. Raises ConfigurationError where there are too many or too few."""
        names = [one.name for one in variables]
        if self.kind == "grid":
            levels = [one.levels() for one in variables]
            _count(math.prod(map(len, levels)))
            return [dict(zip(names, chosen, strict=True)) for chosen in itertools.product(*levels)]
        if self.kind == "list":
            levels = [one.levels() for one in variables]
            lengths = {len(one) for one in levels}
            if len(lengths) > 1:
                raise ConfigurationError(
                    f"design list: the parameters have {', '.join(map(str, sorted(lengths)))} values; give each as many"
                )
            return [dict(zip(names, chosen, strict=True)) for chosen in zip(*levels, strict=True)]
        assert self.samples is not None
        _count(self.samples)
        columns = self.shares(len(variables)).T
        drawn = [one.drawn(column) for one, column in zip(variables, columns, strict=True)]
        return [dict(zip(names, chosen, strict=True)) for chosen in zip(*drawn, strict=True)]

    def shares(self, dimensions: int) -> Floats:
        """Points of the unit cube, (samples, dimensions), the same for the same seed."""
        assert self.samples is not None
        if self.kind == "random":
            return np.random.default_rng(self.seed).random((self.samples, dimensions))
        return unit_points(self.kind, dimensions, self.samples, self.seed)


def unit_points(kind: str, dimensions: int, samples: int, seed: int) -> Floats:
    """Points of a Latin hypercube or of a scrambled Sobol' sequence, (samples, dimensions)."""
    import warnings

    from scipy.stats import qmc

    engine = qmc.LatinHypercube if kind == "latin_hypercube" else qmc.Sobol
    with warnings.catch_warnings():  # a number that is no power of two is the user's choice
        warnings.filterwarnings("ignore", message="The balance properties of Sobol", category=UserWarning)
        return np.asarray(engine(dimensions, seed=np.random.default_rng(seed)).random(samples))


def _count(points: int) -> None:
    if points > MOST_POINTS:
        raise ConfigurationError(f"the study has {points} points, more than {MOST_POINTS}; divide it")
