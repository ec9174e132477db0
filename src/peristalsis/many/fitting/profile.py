"""The profile of the likelihood: how much worse a fit becomes where one parameter is held, and the others follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from .problem import Problem

Floats = NDArray[np.float64]

LEVELS = (1.0, 2.0, 3.0, 5.0, 8.0)
"""Where a parameter is held, in standard errors on either side, until the fit is worse than any that is accepted."""
LEAST_ERROR = 1e-3
"""Smallest standard error that points are spread by, so that no profile is drawn within the model's roughness."""
WIDEST_ERROR = 0.6
"""Largest one: beyond it the curve is looked at before it is trusted."""


@dataclass(frozen=True)
class Profile:
    """Coordinates at which a parameter was held, and the rise of the sum of squares over the variance of the noise.

    coordinates: (n,), rising, the best one among them; rise: (n,), 0 there; others: (n, m), where the rest went. low,
    high: where `rise` passes what a 95 % interval accepts; None where it does not before a bound or a failing run.
    """

    coordinates: Floats
    rise: Floats
    others: Floats
    low: float | None
    high: float | None


def profile(problem: Problem, best: Floats, covariance: Floats, variance: float, accepted: float, k: int) -> Profile:
    """The profile of coordinate k. covariance, variance: as of the fit; accepted: rise of the 95 % interval."""
    low, high = problem.bounds
    error = float(np.clip(np.sqrt(covariance[k, k]), LEAST_ERROR, WIDEST_ERROR))
    along = covariance[:, k] / covariance[k, k] if covariance[k, k] > 0.0 else np.zeros_like(best)
    least = float(np.sum(problem.residuals(best) ** 2))
    found: list[tuple[float, float, Floats]] = [(float(best[k]), 0.0, best)]
    for side in (-1.0, 1.0):
        last, before = best, float(best[k])
        for level in LEVELS:
            held = float(np.clip(best[k] + side * level * error, low[k], high[k]))
            if held == before:
                break
            guess = np.clip(last + along * (held - before), low, high)
            guess[k] = held
            solved = _others(problem, guess, k)
            if solved is None:
                break
            last, before, squares = solved[0], held, solved[1]
            rise = max(0.0, (squares - least) / variance)
            found.append((held, rise, last))
            if rise > 1.5 * accepted or held in (low[k], high[k]):
                break
    found.sort(key=lambda one: one[0])
    coordinates, rises = np.array([one[0] for one in found]), np.array([one[1] for one in found])
    at = int(np.argmin(np.abs(coordinates - best[k])))
    return Profile(
        coordinates,
        rises,
        np.array([one[2] for one in found]),
        _passed(coordinates[at::-1], rises[at::-1], accepted),
        _passed(coordinates[at:], rises[at:], accepted),
    )


def _others(problem: Problem, guess: Floats, k: int) -> tuple[Floats, float] | None:
    """The best point with coordinate k held, and its sum of squares; None where runs fail."""
    rest = [one for one in range(guess.size) if one != k]
    if not rest:
        residuals = problem.residuals(guess)
        return (guess, float(np.sum(residuals**2))) if np.isfinite(residuals).all() else None

    def whole(part: Floats) -> Floats:
        x = guess.copy()
        x[rest] = part
        return x

    low, high = problem.bounds
    try:
        solved = least_squares(
            lambda part: problem.residuals(whole(part)),
            guess[rest],
            jac=lambda part: problem.jacobian(whole(part), held=k),
            bounds=(low[rest], high[rest]),
            ftol=1e-3,  # a rise is read off, for which a thousandth of the sum is enough
            xtol=1e-4,
            max_nfev=5,
        )
    except ValueError:  # of a run that failed
        return None
    return whole(solved.x), 2.0 * float(solved.cost)


def _passed(coordinates: Floats, rises: Floats, level: float) -> float | None:
    """Where the root of the rise, which is straight for a linear model, passes that of a level."""
    above = np.flatnonzero(rises > level)
    if not above.size or above[0] == 0:
        return None
    at = int(above[0])
    one, two = np.sqrt(rises[at - 1]), np.sqrt(rises[at])
    share = (np.sqrt(level) - one) / (two - one)
    return float(coordinates[at - 1] + share * (coordinates[at] - coordinates[at - 1]))
