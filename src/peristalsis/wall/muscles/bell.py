"""A muscle whose tension is a bell of the stretch, Eq. (66): it weakens far from its best length, and never ends."""

from __future__ import annotations

from typing import NamedTuple

from ...declared import number
from ...numerics.compiled import inlined
from ...numerics.exponential import exponential

KIND = "muscle"
NAME = "bell"
TITLE = "bell of the stretch, everywhere above zero"

PARAMETERS = (
    number("peak", 25.0, "mN/(cm*mV)", "largest tension per millivolt of depolarisation: the top of the circular "
           "layer's parabola", tag="chosen", lowest=0.0, highest=1e4),
    number("best", 1.5, "1", "stretch of the largest tension: that of the parabola", tag="chosen", lowest=0.1,
           highest=8.0),
    number("width", 1.0, "1", "distance from the best stretch at which 1/e is left: the same curvature there as the "
           "parabola's", tag="chosen", lowest=0.3, highest=10.0),
)  # fmt: skip


class ActiveConstants(NamedTuple):
    """Bell of Eq. (66): peak in mN/(cm mV), best stretch and width without unit."""

    peak: float
    best: float
    width: float


@inlined
def active_tension(stretch: float, c: ActiveConstants) -> tuple[float, float]:
    """Active tension per mV of depolarisation and its derivative by the stretch [mN/(cm mV)], Eq. (66)."""
    away = (stretch - c.best) / c.width
    value = c.peak * exponential(-min(away * away, 700.0))
    return value, -2.0 * away / c.width * value
