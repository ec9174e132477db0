"""Dose and response: transit, speed and force of a pellet against the concentration of an agent."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import scenarios, units
from ..errors import ConfigurationError
from ..inputs.config import Configuration
from ..inputs.drugs import CONCENTRATION, NOT_ADVICE, Dose, amount, changes_by, factor, library
from ..paths import located
from .engine import Progress
from .hill_curve import HillCurve, crossing, fit_hill_curve
from .passage import passage
from .rows import Row
from .sweep import sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

FEWEST, MOST = 5, 200
RESPONSES = {"speed": "mean_velocity_cm_s", "force": "max_axial_force_mN"}
"""Responses through which a curve is laid, and the number of a run that each is."""


@dataclass(frozen=True)
class DoseResponse:
    """A control and a row for each concentration [nM]; `doses` says what the agent does at the first of them.

    beside: what else acts in all runs, in words.
    """

    agent: str
    concentrations: tuple[float, ...]
    control: Row
    rows: tuple[Row, ...]
    doses: tuple[Dose, ...]
    beside: tuple[str, ...] = ()

    def share(self, response: str) -> Floats:
        """A response as a share of the control, (n,); nan where a run has none."""
        name = RESPONSES[response]
        whole = self.control.summary.get(name)
        found = [row.summary.get(name) for row in self.rows]
        return np.array([np.nan if one is None or not whole else one / whole for one in found], dtype=np.float64)

    @cached_property
    def curves(self) -> dict[str, HillCurve]:
        """Hill's curve through each response."""
        concentrations = np.array(self.concentrations)
        return {name: fit_hill_curve(concentrations, self.share(name)) for name in RESPONSES}

    def half_concentration(self, response: str) -> float | None:
        """Where a response falls to half of the control [nM]; None if it does not within these concentrations."""
        return crossing(np.array(self.concentrations), self.share(response))

    @property
    def uncertainty(self) -> tuple[float, float] | None:
        """By which factors the concentrations of all effects may be wrong, as the IC50 are; None if nothing says so.

        An agent acts by c / IC50 alone, so a response is shifted along a logarithmic axis of concentration by as much
        as the IC50, and no run is needed to know it. Of several targets the widest range counts, moved together.
        """
        known = [(dose.range[0] / dose.ic50, dose.range[1] / dose.ic50) for dose in self.doses if dose.range]
        return (min(low for low, _ in known), max(high for _, high in known)) if known else None

    def whole_band(self, response: str) -> tuple[float, float] | None:
        """Band of the half-effect concentration [nM] with the range of the IC50 on top of that of the curve."""
        band = self.curves[response].half_band
        low, high = self.uncertainty or (1.0, 1.0)
        return None if band is None else (band[0] * low, band[1] * high)

    def numbers(self) -> dict[str, Any]:
        """Everything as plain data."""
        return {
            "agent": self.agent,
            "note": NOT_ADVICE,
            "doses": [dose.table() for dose in self.doses],
            "beside": list(self.beside),
            "control": dict(self.control.summary),
            "points": [
                {"concentration_nM": one, **row.summary}
                for one, row in zip(self.concentrations, self.rows, strict=True)
            ],
            "curves": {
                name: {
                    "ec50_nM": curve.half,
                    "ec50_band_nM": curve.half_band,
                    "ec50_band_with_ic50_nM": self.whole_band(name),
                    "slope": curve.slope,
                    "slope_band": curve.slope_band,
                    "bottom": curve.bottom,
                    "bottom_band": curve.bottom_band,
                    "error": curve.error,
                    "reason": curve.reason,
                    "half_of_control_nM": self.half_concentration(name),
                }
                for name, curve in self.curves.items()
            },
        }

    def csv(self) -> str:
        """A row for the control and for each concentration."""
        text = io.StringIO(newline="")
        writer = csv.writer(text, lineterminator="\n")
        targets = [dose.target for dose in self.doses]
        numbers = ("transit_s", "mean_velocity_cm_s", "max_axial_force_mN", "travel_cm", "simulated_s")
        writer.writerow(["concentration_nM", *(f"factor on {one}" for one in targets), "status", *numbers, "error"])
        for concentration, row in zip((0.0, *self.concentrations), (self.control, *self.rows), strict=True):
            left = [repr(factor([_at(dose, concentration)])) for dose in self.doses]
            cells = ["" if (one := row.summary.get(name)) is None else repr(one) for name in numbers]
            writer.writerow([repr(concentration), *left, row.status, *cells, row.summary.get("error") or ""])
        return text.getvalue()

    def figure(self) -> Figure:
        """Transit, speed and force against concentration."""
        from .dose_pictures import dose_figure

        return dose_figure(self)


def dose_response(
    agent: str,
    low: str,
    high: str,
    *,
    scenario: Configuration | str = "baseline",
    points: int = 9,
    beside: Sequence[str] = (),
    library_file: str | None = None,
    out: str | PathLike[str] = "out/dose_response",
    workers: int = 1,
    progress: Progress | None = None,
) -> DoseResponse:
    """Run a control and the concentrations of an agent between `low` and `high`, evenly spread on a logarithmic axis.

    agent: its name, with " in PREPARATION" for another than the first. scenario: its name, or the configuration.
    beside: lines as for `--drug` that act in all runs, the control too. out: folder; finished runs are kept in it.
    Raises ConfigurationError.
    """
    name, _, tissue = (part.strip() for part in agent.partition(" in "))
    concentrations = _spread(low, high, points)
    base = scenarios.configuration(scenario) if isinstance(scenario, str) else scenario
    if beside:
        base = base.with_changes(changes_by(beside, base, library_file))
    named = library(library_file).of(name, tissue or None)[0].name

    def under(concentration: float) -> Configuration:
        line = f"{named} {concentration!r} {CONCENTRATION}" + (f" in {tissue}" if tissue else "")
        return base.with_changes(changes_by([line], base, library_file))

    runs = {"control": base} | {amount(one): under(one) for one in concentrations}
    rows = sweep(runs, Path(located(out)) / "runs", passage, workers, progress)
    doses = tuple(one for one in runs[amount(concentrations[0])].drugs if one not in base.drugs)
    control, *others = rows.values()
    if not control.summary.get("mean_velocity_cm_s"):
        raise ConfigurationError(
            f"without {named} the pellet does not move ({control.status}), so there is nothing to compare with; choose "
            "another scenario"
        )
    return DoseResponse(named, concentrations, control, tuple(others), doses, tuple(beside))


def _at(dose: Dose, concentration: float) -> Dose:
    return replace(dose, concentration=concentration)


def _spread(low: str, high: str, points: int) -> tuple[float, ...]:
    """Concentrations [nM], of four digits, so that they are told apart and read the same everywhere."""
    first, last = (units.parse(one, CONCENTRATION, key) for one, key in ((low, "from"), (high, "to")))
    if not 0.0 < first < last:
        raise ConfigurationError(
            f"from = {low}, to = {high}: concentrations above 0 that rise are needed; correct them"
        )
    if not FEWEST <= points <= MOST:
        raise ConfigurationError(f"points = {points}: give {FEWEST} to {MOST}")
    found = tuple(float(f"{one:.4g}") for one in np.geomspace(first, last, points))
    if len(set(found)) < points:
        raise ConfigurationError(f"points = {points}: too many between {low} and {high}; take fewer, or a wider span")
    return found
