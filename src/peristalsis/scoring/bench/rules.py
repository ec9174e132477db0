"""Rules that only the bench has."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..rules import UNUSABLE, Finding, Measured


def half_at(concentrations: Sequence[float], values: Sequence[float], whole: float) -> float | None:
    """Concentration at which a value has fallen to half of `whole`, between two on a log scale; None if it does not."""
    before = None
    for concentration, value in zip(concentrations, values, strict=True):
        if value <= 0.5 * whole:
            if before is None:
                return concentration
            last, least = before
            share = (least - 0.5 * whole) / (least - value)
            return float(math.exp(math.log(last) + share * (math.log(concentration) - math.log(last))))
        before = concentration, value
    return None


@dataclass(frozen=True, slots=True)
class HalvesTogether:
    """Two metrics fall to half at concentrations whose ratio, first over second, is within [low, high].

    first, second: a run without the agent, a metric, and the runs with it in the order of `concentrations`.
    """

    concentrations: tuple[float, ...]
    first: tuple[str, str, tuple[str, ...]]
    second: tuple[str, str, tuple[str, ...]]
    low: float
    high: float

    def judge(self, measured: Measured) -> Finding:
        """Compare."""
        halves = []
        for control, metric, runs in (self.first, self.second):
            missing = next((run for run in (control, *runs) if run not in measured), None)
            if missing is not None:
                return Finding(None, f"{missing}: not run", missing=True)
            broken = next((run for run in (control, *runs) if measured[run]["status"] in UNUSABLE), None)
            if broken is not None:
                return Finding(None, f"{broken}: {measured[broken]['status']}")
            values = [float(measured[run][metric]) for run in runs]
            whole = float(measured[control][metric])
            half = half_at(self.concentrations, values, whole)
            if half is None:
                least = min(values) / whole if whole > 0.0 else math.nan
                return Finding(
                    False,
                    f"{metric} keeps {least:.0%} of the control's at {self.concentrations[-1]:g} times the IC50",
                    margin=-math.inf,
                )
            halves.append(half)
        ratio = halves[0] / halves[1]
        return Finding(
            self.low <= ratio <= self.high,
            f"half of {self.first[1]} at {halves[0]:.3g}, of {self.second[1]} at {halves[1]:.3g} times the channel's "
            f"IC50: ratio {ratio:.3g} (asked: {self.low:g} to {self.high:g})",
            margin=min(ratio - self.low, self.high - ratio) / max(abs(self.low), abs(self.high)),
        )

    def runs(self) -> tuple[str, ...]:
        """All of them."""
        return tuple(dict.fromkeys(run for control, _, runs in (self.first, self.second) for run in (control, *runs)))
