"""How a part says its numbers: each constant of a cell, a law or a shape, in the file that uses it.

    PARAMETERS = (
        number("stiffness", 30.0, "mN/cm", "shear modulus times thickness", tag="chosen", lowest=0.0, highest=1e6),
    )

A configuration sets it as `wall.<name of the law>.stiffness`, with its unit.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

Tag = Literal["printed", "corrected", "sourced", "chosen", "calibrated", "fitted"]


class Declared(NamedTuple):
    """One constant of a part. unit: that in which its kernels take it, "1" without one; lowest and highest are allowed.

    tag: where the value comes from; source: the citation, which every tag but "chosen" needs.
    """

    name: str
    value: float
    unit: str
    description: str
    tag: Tag
    source: str
    lowest: float
    highest: float

    def bounds(self) -> dict[str, float]:
        """Those of its bounds that there are, by the names that a schema uses."""
        both = {"ge": self.lowest, "le": self.highest}
        return {name: limit for name, limit in both.items() if math.isfinite(limit)}


def number(
    name: str,
    value: float,
    unit: str,
    description: str,
    *,
    tag: Tag = "chosen",
    source: str = "",
    lowest: float = -math.inf,
    highest: float = math.inf,
) -> Declared:
    """Declare a constant of a part; see `Declared`."""
    return Declared(name, value, unit, description, tag, source, lowest, highest)
