"""The paper's active tension of a muscle layer, Eqs. (5) and (19): a parabola of the stretch, cut at zero.

Its constants are the configuration's c7, c8, c9 of either layer, with their sources in `parameters`.
"""

from __future__ import annotations

from typing import NamedTuple

from ...numerics.compiled import inlined

KIND = "muscle"
NAME = "parabola"
TITLE = "parabola of the stretch, cut at zero (the paper's)"


class ActiveConstants(NamedTuple):
    """Parabola of Eq. (5): c7, c8, c9 in mN/(cm mV)."""

    c7: float
    c8: float
    c9: float


@inlined
def active_tension(stretch: float, c: ActiveConstants) -> tuple[float, float]:
    """Active tension per mV of depolarisation and its derivative by the stretch [mN/(cm mV)], never negative."""
    value = (c.c7 * stretch + c.c8) * stretch + c.c9
    pulls = value > 0.0
    return (value if pulls else 0.0), (2.0 * c.c7 * stretch + c.c8 if pulls else 0.0)
