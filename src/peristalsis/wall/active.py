"""The active law that the wall's kernels call, Eq. (5): the tension of a muscle layer against its stretch.

The slot is `wall.muscles.parabola`: `bind({"wall.muscles.parabola": file})` puts another law there, one file with
`ActiveConstants` and `active_tension`; see docs/activation.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..declared import Declared
from ..numerics.compiled import fixed_tuple, inlined
from .muscles import parabola

_muscle: Any = parabola

ActiveConstants = parabola.ActiveConstants
active_tension = parabola.active_tension
NUMBERS = len(ActiveConstants._fields)
"""How many numbers a layer of muscle has."""
PARAMETERS: tuple[Declared, ...] = getattr(_muscle, "PARAMETERS", ())
NEGATIVE: str = getattr(_muscle, "NEGATIVE", "")
"""Why the law may push: a sentence, or nothing where it never does."""


@inlined
def unpack_active(numbers: np.ndarray, first: int) -> ActiveConstants:
    """The constants of a layer from `numbers[first:]`, in the order of their fields."""
    return ActiveConstants(*fixed_tuple(numbers[first : first + NUMBERS], NUMBERS))
