"""The passive law that the wall's kernels call, and what a law may leave out, Eq. (3).

The slot is `wall.laws.tong_fung`: `bind({"wall.laws.tong_fung": file})` puts another law there. A law is one file with
`PassiveConstants` and `strain_energy`; see docs/laws.md for the whole of it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..declared import Declared
from ..numerics.compiled import fixed_tuple, inlined
from .laws import tong_fung

_law: Any = tong_fung

PassiveConstants = tong_fung.PassiveConstants
strain_energy = tong_fung.strain_energy
NUMBERS = len(PassiveConstants._fields)
"""How many numbers the law has."""

PARAMETERS: tuple[Declared, ...] = getattr(_law, "PARAMETERS", ())
PRESTRESSED: bool = getattr(_law, "PRESTRESSED", False)
"""Whether the undeformed wall may have tension."""

_OWN = ", ".join(f"wall.{tong_fung.NAME}.{one.name}" for one in PARAMETERS)
LIMIT: str = getattr(_law, "LIMIT", f"the law {tong_fung.NAME} ends")
"""What ends where the law is not admissible: "its stretches come to where ..."."""
STIFFER_ALONG: str = getattr(_law, "STIFFER_ALONG", _OWN)
STIFFER_AROUND: str = getattr(_law, "STIFFER_AROUND", _OWN)
"""Keys of the configuration that make the wall stiffer along the tube, and around it."""

STEP = 2e-3
"""Step of the stretches in differences of the energy: their truncation and their rounding are alike there."""


@inlined
def _everywhere(longitudinal: float, circumferential: float, c: PassiveConstants) -> bool:
    """A law without an end."""
    return longitudinal > 0.0 and circumferential > 0.0


@inlined
def by_differences(
    longitudinal: float, circumferential: float, c: PassiveConstants
) -> tuple[float, float, float, float, float]:
    """(W_l, W_c, W_ll, W_lc, W_cc) [mN/cm] of a law that gives its energy alone, by central differences.

    Sixth order along either stretch, so that tensions are good to about 1e-10; second order across.
    """
    a, b, h = longitudinal, circumferential, STEP
    middle = strain_energy(a, b, c)
    l1, l_1 = strain_energy(a + h, b, c), strain_energy(a - h, b, c)
    l2, l_2 = strain_energy(a + 2.0 * h, b, c), strain_energy(a - 2.0 * h, b, c)
    l3, l_3 = strain_energy(a + 3.0 * h, b, c), strain_energy(a - 3.0 * h, b, c)
    c1, c_1 = strain_energy(a, b + h, c), strain_energy(a, b - h, c)
    c2, c_2 = strain_energy(a, b + 2.0 * h, c), strain_energy(a, b - 2.0 * h, c)
    c3, c_3 = strain_energy(a, b + 3.0 * h, c), strain_energy(a, b - 3.0 * h, c)
    across = (strain_energy(a + h, b + h, c) - strain_energy(a + h, b - h, c)) - (
        strain_energy(a - h, b + h, c) - strain_energy(a - h, b - h, c)
    )
    per_step, per_square = 1.0 / (60.0 * h), 1.0 / (180.0 * h * h)
    return (
        (45.0 * (l1 - l_1) - 9.0 * (l2 - l_2) + (l3 - l_3)) * per_step,
        (45.0 * (c1 - c_1) - 9.0 * (c2 - c_2) + (c3 - c_3)) * per_step,
        (270.0 * (l1 + l_1) - 27.0 * (l2 + l_2) + 2.0 * (l3 + l_3) - 490.0 * middle) * per_square,
        across / (4.0 * h * h),
        (270.0 * (c1 + c_1) - 27.0 * (c2 + c_2) + 2.0 * (c3 + c_3) - 490.0 * middle) * per_square,
    )


admissible = getattr(_law, "admissible", _everywhere)
passive_tension = getattr(_law, "passive_tension", by_differences)


@inlined
def unpack_passive(numbers: np.ndarray, first: int) -> PassiveConstants:
    """The law's constants from `numbers[first:]`, in the order of their fields."""
    return PassiveConstants(*fixed_tuple(numbers[first : first + NUMBERS], NUMBERS))
