"""Least squares of a run's track to those observed, with intervals; what is no success says so."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import t as student

from ... import scenarios
from ...errors import ConfigurationError
from ...inputs.config import Configuration
from ...paths import located
from ..engine import Progress
from .observed import Observed, check, observed
from .parameters import Free, free_parameters
from .problem import Offsets, Problem
from .profile import Profile, profile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...maps.recording import Track

Floats = NDArray[np.float64]

CONFIDENCE = 0.95
MOST_EVALUATIONS = 40
TOLERANCES = {"ftol": 1e-4, "xtol": 3e-5, "gtol": 1e-10}
"""Where the search ends: a ten-thousandth of the sum of squares is a tenth of a standard error of one parameter or less
for up to a hundred positions, and smaller steps are lost in the roughness of the tracks.
"""
INSEPARABLE = 0.95
"""Correlation of two estimates beyond which one can hardly be told from the other."""
SMALLEST_CHANGE = 1e-6
"""Change of a track along one direction of the parameters, of that along the best one, that is no more than nothing."""
UNEVEN = 0.3
"""Difference of a derivative from one side to the other beyond which the track jumps there."""
DEPENDENT = 0.5
"""Correlation of neighbouring residuals beyond which they are no independent noise, and intervals are too narrow."""


@dataclass(frozen=True)
class Estimate:
    """A parameter that was found: its value, 95 % intervals by curvature and by profile, in its unit.

    An end of the interval by profile is None where the likelihood does not fall enough before the bound.
    """

    free: Free
    value: float
    interval: tuple[float, float] | None
    profile: tuple[float | None, float | None] | None


@dataclass(frozen=True)
class Fit:
    """What came out. status: "converged", "not converged" or "failed"; message says why, and what to change.

    residuals: place in the model less the observed one [cm], all tracks one after another. noise: standard deviation of
    the positions [cm], of the residuals unless it was stated. correlation: of the estimates, (m, m), or None.
    """

    problem: Problem
    status: str
    message: str
    x: Floats
    residuals: Floats
    noise: float
    estimates: tuple[Estimate, ...]
    correlation: Floats | None
    profiles: Mapping[str, Profile] = field(default_factory=dict)
    accepted: float = 0.0
    covariance: Floats | None = None
    unevenness: tuple[float, ...] = ()

    @property
    def success(self) -> bool:
        """Whether the numbers can be used."""
        return self.status == "converged"

    @property
    def configuration(self) -> Configuration:
        """Ready to be run, with what was found."""
        return self.problem.configuration(self.x)

    @property
    def values(self) -> dict[str, float]:
        """What was found by name, in the unit of the parameter."""
        return {one.free.name: one.value for one in self.estimates}

    @property
    def dependence(self) -> float:
        """Correlation of each residual with the next of its track: 0 for independent noise."""
        ends = np.cumsum([one.time.size for one in self.problem.observed])[:-1]
        parts = [part - part.mean() for part in np.split(self.residuals, ends)]
        whole = sum(float(part @ part) for part in parts)
        return sum(float(part[1:] @ part[:-1]) for part in parts) / whole if whole > 0.0 else 0.0

    def remarks(self) -> tuple[str, ...]:
        """What is to be known before the numbers are used."""
        said = []
        names = self.problem.names
        if self.correlation is not None:
            for one in range(len(names)):
                for two in range(one):
                    if abs(self.correlation[one, two]) > INSEPARABLE:
                        sign = "falls" if self.correlation[one, two] < 0.0 else "rises"
                        said.append(
                            f"{names[two]} and {names[one]} can hardly be told apart: where one rises the other {sign} "
                            f"(correlation {self.correlation[one, two]:.3f}); hold one of them, or observe under "
                            "another condition, such as another load or pellet"
                        )
        for estimate in self.estimates:
            free, value = estimate.free, estimate.value
            if min(abs(value - free.low), abs(value - free.high)) <= 1e-3 * max(abs(value), 1e-3 * free.scale):
                said.append(f"{free.name} lies at its bound, {free.text(value)}: widen the bounds, or hold it there")
            if estimate.profile is not None and None in estimate.profile:
                open_ends = " and ".join(
                    end for end, at in zip(("below", "above"), estimate.profile, strict=True) if at is None
                )
                said.append(f"{free.name} has no limit {open_ends} within its bounds: these tracks do not determine it")
        for estimate, uneven in zip(self.estimates, self.unevenness, strict=False):
            if uneven > UNEVEN:
                said.append(
                    f"the model's track jumps where {estimate.free.name} changes by one per cent here (its derivative "
                    f"differs by {100.0 * uneven:.0f} % from one side to the other): a search can end at such a jump, "
                    "and its interval is too narrow; use a finer grid and shorter steps, or begin elsewhere"
                )
        if self.success and self.dependence > DEPENDENT:
            said.append(
                f"neighbouring residuals are alike (correlation {self.dependence:.2f}): the model misses the shape "
                "of the track, or noise is not independent; intervals are too narrow then"
            )
        return tuple(said)

    def numbers(self) -> dict[str, Any]:
        """Everything as plain data."""
        return {
            "status": self.status,
            "message": self.message,
            "parameters": {
                one.free.name: {
                    "value": one.value,
                    "unit": one.free.unit,
                    "interval": one.interval,
                    "profile_interval": one.profile,
                    "bounds": [one.free.low, one.free.high],
                    "start": one.free.start,
                }
                for one in self.estimates
            },
            "offsets": dict(zip(self.problem.names[len(self.problem.free) :], self._offsets(), strict=True)),
            "correlation": None if self.correlation is None else self.correlation.tolist(),
            "rms_residual_cm": float(np.sqrt(np.mean(self.residuals**2)))
            if np.isfinite(self.residuals).all()
            else None,
            "noise_cm": self.noise if np.isfinite(self.noise) else None,
            "residual_dependence": self.dependence if np.isfinite(self.residuals).all() else None,
            "observations": self.problem.size,
            "runs": self.problem.runs,
            "remarks": list(self.remarks()),
        }

    def csv(self) -> str:
        """Observed and modelled place and their difference, a row a position."""
        text = io.StringIO(newline="")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["track", "time [s]", "observed [mm]", "model [mm]", "residual [mm]"])
        begin = 0
        for one in self.problem.observed:
            own = self.residuals[begin : begin + one.time.size]
            begin += one.time.size
            for time, place, residual in zip(one.time, one.place, own, strict=True):
                writer.writerow(
                    [one.name, *(repr(float(v)) for v in (time, 10 * place, 10 * (place + residual), 10 * residual))]
                )
        return text.getvalue()

    def figure(self) -> Figure:
        """Tracks, residuals, and the profile of every parameter."""
        from .pictures import fit_figure

        return fit_figure(self)

    def _offsets(self) -> list[float]:
        return [float(one) for one in self.x[len(self.problem.free) :]]


def fit(
    tracks: Sequence[Track | tuple[Track, Mapping[str, Any]]] | Sequence[Observed] | str | PathLike[str],
    free: Sequence[str],
    *,
    scenario: Configuration | str = "baseline",
    bounds: Mapping[str, tuple[object, object]] | None = None,
    free_offsets: Offsets | None = None,
    noise: float | None = None,
    profiles: bool = True,
    out: str | PathLike[str] = "out/fit",
    workers: int = 1,
    progress: Progress | None = None,
) -> Fit:
    """Find the parameters with which the pellet's track comes nearest to those observed.

    tracks: see `observed`, which knows scales and offsets of recordings. free, bounds: see `free_parameters`. noise:
    standard deviation of a position [cm]; that of the residuals unless stated. out: folder; finished runs are kept in
    it. Raises ConfigurationError for what cannot be begun; a fit that fails later is returned with its status.
    """
    base = scenarios.configuration(scenario) if isinstance(scenario, str) else scenario
    if not base.pellet.enabled:
        raise ConfigurationError("pellet.enabled = false: there is no track to fit; set it true")
    if (
        isinstance(tracks, Sequence)
        and not isinstance(tracks, str)
        and all(isinstance(one, Observed) for one in tracks)
    ):
        listed = tuple(one for one in tracks if isinstance(one, Observed))
    else:
        listed = observed(tracks)  # type: ignore[arg-type]
    if noise is not None and not 0.0 < noise < math.inf:
        raise ConfigurationError(f"noise = {noise:g} cm is no deviation of a position; give one above 0 cm")
    check(listed, base.wall.length)
    folder = Path(located(out)) / "runs"
    problem = Problem(
        listed, base, free_parameters(free, base, bounds), folder, free_offsets or Offsets(), workers, progress
    )
    if problem.size <= len(problem.names):
        raise ConfigurationError(
            f"{problem.size} positions are too few for {len(problem.names)} unknowns; free fewer, or observe more"
        )
    return solve(problem, noise, profiles)


def solve(problem: Problem, noise: float | None = None, profiles: bool = True) -> Fit:
    """The fit of a problem; see `fit`."""
    start = problem.start
    first = problem.residuals(start)
    if not np.isfinite(first).all():
        why = next(iter(problem.refusals.values()), "a run failed")
        return _failed(problem, start, first, f"the run at the start has no track ({why}); begin elsewhere (--set)")
    try:
        solved = least_squares(
            problem.residuals,
            start,
            jac=problem.jacobian,
            bounds=problem.bounds,
            max_nfev=MOST_EVALUATIONS,
            **TOLERANCES,
        )
    except ValueError:
        last = problem.refusals and list(problem.refusals.items())[-1]
        why = f" ({last[1]})" if last else ""
        return _failed(problem, start, first, f"runs beside the best point have no track{why}; narrow the bounds")
    best, residuals = solved.x, problem.residuals(solved.x)
    jacobian = problem.jacobian(best)
    if not (np.isfinite(residuals).all() and np.isfinite(jacobian).all()):
        return _failed(problem, best, residuals, "a run at the best point has no track; narrow the bounds")
    status = "converged" if solved.status > 0 else "not converged"
    message = str(solved.message) if solved.status > 0 else (
        f"the sum of squares still falls after {MOST_EVALUATIONS} evaluations; begin where it ended, or free fewer"
    )  # fmt: skip
    freedom = residuals.size - best.size
    deviation = float(np.sqrt(residuals @ residuals / freedom)) if noise is None else noise
    variance = max(deviation**2, 1e-16)  # tracks without noise: no interval is narrower than 1e-8 cm makes it
    covariance = variance * inverse_of_squares(jacobian)
    quantile = float(student.ppf(0.5 + 0.5 * CONFIDENCE, freedom if noise is None else 1e9))
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = covariance / np.outer(errors, errors)
    accepted = quantile**2
    drawn = {}
    if profiles:
        for k, one in enumerate(problem.free):
            drawn[one.name] = profile(problem, best, covariance, variance, accepted, k)
    estimates = []
    for k, one in enumerate(problem.free):
        ends = one.value(best[k] - quantile * errors[k]), one.value(best[k] + quantile * errors[k])
        found = drawn.get(one.name)
        by_profile = (
            None if found is None else tuple(None if x is None else one.value(x) for x in (found.low, found.high))
        )
        estimates.append(Estimate(one, one.value(best[k]), ends, by_profile))  # type: ignore[arg-type]
    return Fit(
        problem,
        status,
        message,
        best,
        residuals,
        deviation,
        tuple(estimates),
        correlation,
        drawn,
        accepted,
        covariance,
        problem.unevenness(best, jacobian),
    )


def inverse_of_squares(jacobian: Floats) -> Floats:
    """The inverse of J^T J, (m, m); a direction in which nothing changes is uncertain, and not certain as in a
    pseudo-inverse.
    """
    _, sizes, directions = np.linalg.svd(jacobian, full_matrices=False)
    floor = max(SMALLEST_CHANGE * float(sizes[0]), 1e-150)
    return np.asarray((directions.T / np.maximum(sizes, floor) ** 2) @ directions)


def _failed(problem: Problem, x: Floats, residuals: Floats, message: str) -> Fit:
    estimates = tuple(Estimate(one, one.value(x[k]), None, None) for k, one in enumerate(problem.free))
    return Fit(problem, "failed", message, x, residuals, float("nan"), estimates, None)
