"""Whether an activation is what the kernels of the muscle take it for: its drive, its states, its record."""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any

import numpy as np

POTENTIALS = np.linspace(-100.0, 50.0, 31)
CALCIUM = np.concatenate(([0.0], np.geomspace(1e-3, 1e3, 30)))
"""Potentials [mV] and calcium [uM] at which an activation is looked at."""
STEP = 0.01
"""Step for which its states are advanced from where they should stay [s]."""


def activation_faults(kernels: ModuleType, constants: Any, tolerance: float = 1e-9) -> list[str]:
    """What is wrong with an activation, in sentences; none if nothing is.

    kernels: `tissue.activating` as bound to it. constants: its `ActivationConstants`. tolerance: of states that should
    stay where they are, relative to their range.
    """
    fields, declared = kernels.ActivationConstants._fields, kernels.PARAMETERS
    if not fields:
        return ["ActivationConstants has no field; give it one number at least"]
    if tuple(one.name for one in declared) != fields:
        return [f"PARAMETERS and the fields of ActivationConstants differ: {', '.join(fields)}; name the same in order"]
    states = np.zeros((len(kernels.STATES), CALCIUM.size))
    if len(states):
        kernels.set_steady(CALCIUM, 1.0, constants, states)
        moved = states.copy()
        kernels.advance_states(CALCIUM, CALCIUM, 1.0, STEP, constants, moved)
        for (name, low, high), values, later in zip(kernels.STATES, states, moved, strict=True):
            margin = tolerance * (high - low)
            if not ((values >= low - margin) & (values <= high + margin)).all():
                return [f"its state {name} leaves {low:g}...{high:g} where it is steady, with {values.min():.3g}"]
            away = np.abs(later - values)
            if not away.max() <= margin:
                k = int(np.argmax(away))
                return [
                    f"its state {name} is no steady one at a calcium of {CALCIUM[k]:.3g} uM: it moves by {away[k]:.3g} "
                    f"within {STEP:g} s"
                ]
    out = np.empty(CALCIUM.size)
    for potential in POTENTIALS.tolist():
        kernels.drive_of_cells(np.full(CALCIUM.size, potential), CALCIUM, 1.0, states, constants, out)
        k = int(np.argmin(out))
        if not (np.isfinite(out).all() and out[k] >= 0.0):
            return [f"its drive at {potential:g} mV and a calcium of {CALCIUM[k]:.3g} uM is {out[k]:.3g} mV"]
        largest = float(kernels.largest_drive(potential, constants))
        if math.isnan(largest) or out.max() > largest + tolerance * abs(largest):
            return [
                f"its drive at {potential:g} mV is {out.max():.3g} mV, more than its largest_drive of {largest:.3g}"
            ]
    return []
