"""Hill's curve through a response: its half-effect concentration, slope and bottom, with bands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Floats = NDArray[np.float64]

SMALLEST_EFFECT = 0.01
"""Least change of a response, as a share of the control, of which a half can be told."""
FEWEST_POINTS = 4
STEEPEST, FLATTEST = 10.0, 0.1
BEYOND = 100.0
"""How far outside of the concentrations the half effect is looked for, as a factor."""
RESAMPLED = 400
EXACT = {"xtol": 1e-12, "ftol": 1e-12, "gtol": 1e-12}
"""Tolerances of the least squares: the curve costs nothing, and a bottom at its bound is approached slowly."""
RESAMPLING = {"xtol": 1e-6, "ftol": 1e-6, "gtol": 1e-6, "max_nfev": 50}
"""The same for resampled residuals, of which there are many, and no one counts."""
BAND = (2.5, 97.5)
"""Percentiles between which a band lies."""


@dataclass(frozen=True)
class HillCurve:
    """1 + (bottom - 1) c^slope / (c^slope + half^slope), (112): a response as a share of the control.

    half: in the unit of the concentrations. bands: 95 %, by resampled residuals. half, slope and bottom are None where
    there is no such curve; `reason` says why then, and what is to be known of it otherwise ("" if nothing). error: root
    of the mean square of the residuals.
    """

    half: float | None = None
    slope: float | None = None
    bottom: float | None = None
    half_band: tuple[float, float] | None = None
    slope_band: tuple[float, float] | None = None
    bottom_band: tuple[float, float] | None = None
    error: float | None = None
    reason: str = ""

    def at(self, concentrations: Floats) -> Floats:
        """The curve; nan where there is none."""
        if self.half is None or self.slope is None or self.bottom is None:
            return np.full(np.shape(concentrations), np.nan)
        return _curve(np.array([np.log(self.half), np.log(self.slope), self.bottom]), np.log(concentrations))


def fit_hill_curve(concentrations: Floats, response: Floats, seed: int = 0, resampled: int = RESAMPLED) -> HillCurve:
    """The curve of least squares through (concentration, share of the control); responses that are nan are left out.

    concentrations: (n,), all above 0 and rising; response: (n,). seed: of the resampling.
    """
    known = np.isfinite(response)
    logs, shares = np.log(concentrations[known]), response[known]
    if shares.size < FEWEST_POINTS:
        return HillCurve(reason=f"{shares.size} points are too few for a curve")
    largest = float(np.abs(shares - 1.0).max())
    if largest < SMALLEST_EFFECT:
        return HillCurve(reason=f"nothing changes by more than {100.0 * largest:.2g} %")
    best = _fitted(logs, shares)
    residuals = shares - _curve(best, logs)
    chance = np.random.default_rng(seed)
    # A residual is smaller than the error that it stands for, by the share of the points that the curve has used up.
    scale = np.sqrt(shares.size / max(1, shares.size - best.size))
    again = np.array(
        [
            _fitted(logs, _curve(best, logs) + scale * chance.choice(residuals, residuals.size), best)
            for _ in range(resampled)
        ]
    )
    low, high = np.percentile(again, BAND, axis=0)
    half, slope, bottom = float(np.exp(best[0])), float(np.exp(best[1])), float(best[2])
    reasons = []
    if not logs[0] <= best[0] <= logs[-1]:
        reasons.append("the half effect lies outside of the concentrations: an extrapolation")
    if slope > 0.99 * STEEPEST:
        reasons.append("the response falls in a step between two concentrations, which no slope describes")
    return HillCurve(
        half,
        slope,
        bottom,
        (float(np.exp(low[0])), float(np.exp(high[0]))),
        (float(np.exp(low[1])), float(np.exp(high[1]))),
        (float(low[2]), float(high[2])),
        float(np.sqrt(np.mean(residuals**2))),
        "; ".join(reasons),
    )


def crossing(concentrations: Floats, response: Floats, level: float = 0.5) -> float | None:
    """The first concentration at which a response falls to a level, on a logarithmic axis; None if it does not."""
    known = np.isfinite(response)
    logs, shares = np.log(concentrations[known]), response[known]
    below = np.flatnonzero(shares <= level)
    if not below.size:
        return None
    at = int(below[0])
    if at == 0:
        return float(np.exp(logs[0]))
    share = (shares[at - 1] - level) / (shares[at - 1] - shares[at])
    return float(np.exp(logs[at - 1] + share * (logs[at] - logs[at - 1])))


def _curve(parameters: Floats, logs: Floats) -> Floats:
    half, slope, bottom = parameters
    return np.asarray(1.0 + (bottom - 1.0) * _bound(half, slope, logs))


def _bound(half: float, slope: float, logs: Floats) -> Floats:
    """c^slope / (c^slope + half^slope), from logarithms of all three."""
    return np.asarray(1.0 / (1.0 + np.exp(-np.exp(slope) * (logs - half))))


def _slopes(parameters: Floats, logs: Floats) -> Floats:
    """Derivatives of `_curve` by its parameters, (n, 3)."""
    half, slope, bottom = parameters
    bound, steep = _bound(half, slope, logs), np.exp(slope)
    rise = (bottom - 1.0) * bound * (1.0 - bound)
    return np.stack([-rise * steep, rise * steep * (logs - half), bound], axis=1)


def _fitted(logs: Floats, shares: Floats, start: Floats | None = None) -> Floats:
    """(log half, log slope, bottom) of least squares, from one start or, without one, from several."""
    reach = np.log(BEYOND)
    low = np.array([logs[0] - reach, np.log(FLATTEST), 0.0])
    high = np.array([logs[-1] + reach, np.log(STEEPEST), 10.0])
    starts = [start] if start is not None else [np.array([half, 0.0, float(shares[-1])]) for half in logs[1:-1:2]]
    found = [
        least_squares(
            lambda parameters: _curve(parameters, logs) - shares,
            np.clip(one, low + 1e-9, high - 1e-9),
            jac=lambda parameters: _slopes(parameters, logs),
            bounds=(low, high),
            **(EXACT if start is None else RESAMPLING),
        )
        for one in starts
    ]
    return np.asarray(min(found, key=lambda one: one.cost).x)
