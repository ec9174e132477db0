"""Whether a passive or an active law is what the wall's kernels take it for: derivatives, rest, range, record."""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any

import numpy as np

from .membrane import LARGEST_STRETCH, SMALLEST_STRETCH

NAMES = ("W_l", "W_c", "W_ll", "W_lc", "W_cc")
STEP = 1e-4
"""Step of the differences that the derivatives are compared with."""
PLACES = 200
NEAR = (0.6, 2.6)
"""Random stretches at which derivatives are looked at, and between which; finite they are over the whole range."""


def faults(law: ModuleType, constants: Any, tolerance: float = 1e-4) -> list[str]:
    """What is wrong with a law, in sentences; none if nothing is.

    law: `wall.passive` as bound to it. constants: its `PassiveConstants`. tolerance: of derivatives against
    differences of the energy, relative to their size there; those of an energy alone are good to 1e-4.
    """
    found = [] if isinstance(constants, law.PassiveConstants) else ["its constants are no PassiveConstants"]
    fields, declared = law.PassiveConstants._fields, law.PARAMETERS
    if declared and tuple(one.name for one in declared) != fields:
        found.append(
            f"PARAMETERS and the fields of PassiveConstants differ: {', '.join(fields)}; name the same in order"
        )
    if found:
        return found
    resting = law.passive_tension(1.0, 1.0, constants)
    scale = max(abs(resting[2]), abs(resting[4]), 1e-300)
    if not law.PRESTRESSED and max(abs(resting[0]), abs(resting[1])) > 1e-9 * scale:
        found.append(
            f"the undeformed wall has tensions {resting[0]:.3g} and {resting[1]:.3g} mN/cm; say PRESTRESSED = True"
        )
    if not law.admissible(1.0, 1.0, constants):
        found.append("the undeformed wall is not admissible")
        return found
    rng = np.random.default_rng(1)
    for a, b in rng.uniform(*NEAR, (PLACES, 2)):
        if all(law.admissible(a + i * STEP, b + j * STEP, constants) for i in (-2, 2) for j in (-2, 2)):
            found += _derivatives(law, float(a), float(b), constants, tolerance)
        if found:
            break
    for a, b in np.exp(rng.uniform(math.log(SMALLEST_STRETCH), math.log(LARGEST_STRETCH), (PLACES, 2))):
        numbers = law.passive_tension(float(a), float(b), constants)
        if law.admissible(float(a), float(b), constants) and not all(map(math.isfinite, numbers)):
            found.append(f"admissible at stretches {a:.3g} and {b:.3g}, where its tensions are not finite")
            break
    return found


def _derivatives(law: ModuleType, a: float, b: float, constants: Any, tolerance: float) -> list[str]:
    """Derivatives that differ from differences of the energy, or, the second ones, of the tensions."""
    h = STEP

    def energy(i: float, j: float) -> float:
        return float(law.strain_energy(a + i * h, b + j * h, constants))

    def tension(i: float, j: float, which: int) -> float:
        return float(law.passive_tension(a + i * h, b + j * h, constants)[which])

    own = law.passive_tension(a, b, constants)
    wanted = (
        (8.0 * (energy(1, 0) - energy(-1, 0)) - (energy(2, 0) - energy(-2, 0))) / (12.0 * h),
        (8.0 * (energy(0, 1) - energy(0, -1)) - (energy(0, 2) - energy(0, -2))) / (12.0 * h),
        (8.0 * (tension(1, 0, 0) - tension(-1, 0, 0)) - (tension(2, 0, 0) - tension(-2, 0, 0))) / (12.0 * h),
        (8.0 * (tension(0, 1, 0) - tension(0, -1, 0)) - (tension(0, 2, 0) - tension(0, -2, 0))) / (12.0 * h),
        (8.0 * (tension(0, 1, 1) - tension(0, -1, 1)) - (tension(0, 2, 1) - tension(0, -2, 1))) / (12.0 * h),
    )
    size = max(abs(value) for value in own) + abs(energy(0, 0))
    return [
        f"{name} is {value:.8g} mN/cm at stretches {a:.4g} and {b:.4g}, and the difference of the energy {right:.8g}"
        for name, value, right in zip(NAMES, own, wanted, strict=True)
        if not abs(value - right) <= tolerance * size
    ]


def muscle_faults(law: ModuleType, constants: Any, tolerance: float = 1e-4) -> list[str]:
    """What is wrong with an active law, in sentences; none if nothing is.

    law: `wall.active` as bound to it. constants: its `ActiveConstants`. tolerance: of the slope against differences of
    the tension, relative to their size there; where the tension has a corner, anything between both sides will do.
    """
    fields, declared = law.ActiveConstants._fields, law.PARAMETERS
    if not fields:
        return ["ActiveConstants has no field; give it one number at least"]
    if tuple(one.name for one in declared) != fields:
        return [f"PARAMETERS and the fields of ActiveConstants differ: {', '.join(fields)}; name the same in order"]

    def tension(stretch: float) -> float:
        return float(law.active_tension(stretch, constants)[0])

    rng = np.random.default_rng(1)
    for stretch in np.exp(rng.uniform(math.log(SMALLEST_STRETCH), math.log(LARGEST_STRETCH), PLACES)).tolist():
        value, slope = law.active_tension(stretch, constants)
        if not (math.isfinite(value) and math.isfinite(slope)):
            return [f"its tension at a stretch of {stretch:.3g} is {value:.3g} mN/(cm mV), its slope {slope:.3g}"]
        if value < 0.0 and not law.NEGATIVE:
            return [
                f"its tension at a stretch of {stretch:.3g} is {value:.3g} mN/(cm mV): muscle pushes there; cut it at "
                'zero, or say why it may in NEGATIVE = "..."'
            ]
    h = 1e-5
    for stretch in rng.uniform(*NEAR, PLACES).tolist():
        value, slope = law.active_tension(stretch, constants)
        left, right = (value - tension(stretch - h)) / h, (tension(stretch + h) - value) / h
        size = abs(value) + abs(left) + abs(right)
        if not min(left, right) - tolerance * size <= slope <= max(left, right) + tolerance * size:
            return [
                f"its slope is {slope:.8g} mN/(cm mV) at a stretch of {stretch:.4g}, and the difference of the tension "
                f"{0.5 * (left + right):.8g}"
            ]
    return []
