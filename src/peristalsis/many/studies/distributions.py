"""Distributions of the numbers of a study, by their quantiles; all but the uniform ones may be cut at either end."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigurationError

Floats = NDArray[np.float64]

NEEDED = {
    "uniform": ("low", "high"),
    "loguniform": ("low", "high"),
    "normal": ("mean", "deviation"),
    "lognormal": ("median", "spread"),
}
"""The numbers that each distribution must have, as attributes."""
DISTRIBUTIONS = tuple(NEEDED)
_WORDS = {"low": "from", "high": "to"}


@dataclass(frozen=True)
class Distribution:
    """A distribution of one number.

    low, high: ends; the distribution between them is the whole one, cut and made to sum to 1. mean and deviation of a
    normal distribution before it is cut; median of a lognormal one, and its spread: the factor of one standard
    deviation.
    """

    kind: str
    low: float | None = None
    high: float | None = None
    mean: float | None = None
    deviation: float | None = None
    median: float | None = None
    spread: float | None = None

    @property
    def logarithmic(self) -> bool:
        """Whether it is even on a logarithmic scale."""
        return self.kind in ("loguniform", "lognormal")

    def check(self, where: str) -> None:
        """Raise ConfigurationError where numbers are missing, surplus or out of order."""
        needed = NEEDED[self.kind]
        for name in ("low", "high", "mean", "deviation", "median", "spread"):
            given, word = getattr(self, name), _WORDS.get(name, name)
            if given is None and name in needed:
                others = " and ".join(_WORDS.get(one, one) for one in needed)
                raise ConfigurationError(f"{where}: a {self.kind} distribution needs {others}; {word} is missing")
            if given is not None and name not in needed and name not in ("low", "high"):
                raise ConfigurationError(f"{where}: a {self.kind} distribution has no {word}; leave it out")
        if self.low is not None and self.high is not None and not self.low < self.high:
            raise ConfigurationError(f"{where}: from = {self.low:g} is not below to = {self.high:g}; exchange them")
        if self.logarithmic:
            for name in ("low", "high", "median"):
                given = getattr(self, name)
                if given is not None and given <= 0.0:
                    raise ConfigurationError(
                        f"{where}: {_WORDS.get(name, name)} = {given:g} has no logarithm; give a positive number"
                    )
        if self.deviation is not None and self.deviation <= 0.0:
            raise ConfigurationError(f"{where}: deviation = {self.deviation:g}; give a positive number")
        if self.spread is not None and self.spread <= 1.0:
            raise ConfigurationError(
                f"{where}: spread = {self.spread:g}; it is the factor of one standard deviation, give more than 1"
            )

    def quantiles(self, shares: Floats) -> Floats:
        """The numbers below which these shares of the distribution lie, for shares in [0, 1], (n,)."""
        if self.kind in ("uniform", "loguniform"):
            low, high = self._ends()
            return self._back(low + np.asarray(shares) * (high - low))
        from scipy.stats import truncnorm

        centre, width = self._normal()
        low, high = self._ends()
        cut = truncnorm((low - centre) / width, (high - centre) / width, loc=centre, scale=width)
        return self._back(np.asarray(cut.ppf(shares)))

    def levels(self, count: int, where: str) -> Floats:
        """So many numbers from end to end, evenly on the scale of the distribution; one is the middle.

        Raises ConfigurationError where there is no end.
        """
        low, high = self._ends()
        if not (math.isfinite(low) and math.isfinite(high)):
            raise ConfigurationError(f"{where}: a grid needs from and to; give both, or list values")
        shares = np.array([0.5]) if count == 1 else np.linspace(0.0, 1.0, count)
        found = self._back(low + shares * (high - low))
        if count > 1:
            found[0], found[-1] = self.low, self.high  # to the bit
        return found

    def _ends(self) -> tuple[float, float]:
        """Both ends on the scale of the distribution; infinite where it has none."""
        low = -math.inf if self.low is None else math.log(self.low) if self.logarithmic else self.low
        high = math.inf if self.high is None else math.log(self.high) if self.logarithmic else self.high
        return low, high

    def _normal(self) -> tuple[float, float]:
        if self.kind == "lognormal":
            assert self.median is not None
            assert self.spread is not None
            return math.log(self.median), math.log(self.spread)
        assert self.mean is not None
        assert self.deviation is not None
        return self.mean, self.deviation

    def _back(self, scaled: Floats) -> Floats:
        return np.exp(scaled) if self.logarithmic else np.asarray(scaled, dtype=np.float64)
