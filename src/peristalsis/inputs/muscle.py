"""Laws of the wall and activations that a configuration chooses: their constants, and whether they are sound.

A part of the package is checked by the tests; one from outside before the first run that uses it, at the values that it
declares, and refused in one sentence.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any, NamedTuple

from ..errors import ConfigurationError, shown
from ..numerics.binding import Binding
from ..tissue.activation import SHIPPED_ACTIVATION, SLOT, Activation, activation_of
from ..tissue.checking import activation_faults
from ..wall.active import ActiveConstants
from ..wall.checking import faults, muscle_faults
from .config import Configuration
from .parts import SHIPPED, UNITS_OF_CALCIUM, Part, find

LAW_SLOT, MUSCLE_SLOT, ACTIVATION_SLOT = "wall.laws.tong_fung", "wall.muscles.parabola", SLOT


class Muscle(NamedTuple):
    """What a layer of the model has of its activation, under the names of its fields."""

    activation: Activation
    muscle_constants: Any
    calcium_state: int
    calcium_scale: float


def passive_constants(c: Configuration, binding: Binding) -> Any:
    """The `PassiveConstants` of the chosen law."""
    w, part = c.wall, find("law", c.wall.law)
    law = _taken_up("wall.law", part, binding, "wall.passive", "a law has PassiveConstants and strain_energy")
    if part.name == SHIPPED["law"]:
        return law.PassiveConstants(w.c1, w.c2, w.c3, w.c4, w.c5, w.c6, w.c10)
    _refuse_faulty("wall.law", part, law, _law_faults)
    return law.PassiveConstants(**c.part_numbers("wall", part))


def active_constants(c: Configuration, layer: str, binding: Binding) -> Any:
    """The `ActiveConstants` of a layer for the chosen active law."""
    part, own = find("muscle", c.wall.muscle), getattr(c, layer)
    if part.name == SHIPPED["muscle"]:
        return ActiveConstants(own.c7, own.c8, own.c9)
    words = "an active law has ActiveConstants and active_tension"
    law = _taken_up("wall.muscle", part, binding, "wall.active", words)
    _refuse_faulty("wall.muscle", part, law, _muscle_faults)
    return law.ActiveConstants(**c.part_numbers(layer, part))


def muscle_of_layer(c: Configuration, layer: str) -> Muscle:
    """What makes the drive of a layer's muscle, its constants, and where it finds the calcium of the layer's cells."""
    part, key = c.activation_of(layer), f"{layer}.activation"
    if part.name == SHIPPED["activation"]:
        return Muscle(SHIPPED_ACTIVATION, None, -1, 1.0)
    activation = activation_of(part.name, part.file)
    words = "an activation has ActivationConstants and drive"
    kernels = _taken_up(key, part, activation.binding, "tissue.activating", words)
    _refuse_faulty(key, part, kernels, _activation_faults)
    numbers = c.part_numbers(layer, part)
    constants = kernels.ActivationConstants(**numbers)
    if not part.reads_calcium:
        return Muscle(activation, constants, -1, 1.0)
    cell = find("cell", c.cell_of(layer))
    state, unit = cell.calcium
    scale = UNITS_OF_CALCIUM[unit] * (numbers["calcium_unit"] if unit == "1" else 1.0)
    return Muscle(activation, constants, cell.states.index(state), scale)


def _taken_up(key: str, part: Part, binding: Binding, module: str, words: str) -> ModuleType:
    """The kernels with a part in their slot. Raises ConfigurationError if its file cannot be imported."""
    try:
        return binding.module(module)
    except Exception as error:  # whatever the user's file does when it is imported
        raise ConfigurationError(
            f"{key} = {part.name}: {shown(str(part.file))} cannot be taken up: {shown(str(error), 200)}; {words}"
        ) from None


def _refuse_faulty(key: str, part: Part, kernels: ModuleType, find_faults: Callable[[ModuleType], list[str]]) -> None:
    fault = None if part.origin == "peristalsis" else _fault(kernels, find_faults)
    if fault is not None:
        raise ConfigurationError(f"{key} = {part.name}: {shown(str(part.file))}: {fault}; correct the file")


@cache
def _fault(kernels: ModuleType, find_faults: Callable[[ModuleType], list[str]]) -> str | None:
    """What is wrong with a part from outside of the package, at the values that it declares; None if nothing is."""
    try:
        found = find_faults(kernels)
    except Exception as error:  # whatever numba or the user's formulas say
        return f"its functions cannot be used: {shown(str(error), 300)}"
    return found[0] if found else None


def _law_faults(law: ModuleType) -> list[str]:
    return faults(law, law.PassiveConstants(*(one.value for one in law.PARAMETERS)))


def _muscle_faults(law: ModuleType) -> list[str]:
    return muscle_faults(law, law.ActiveConstants(*(one.value for one in law.PARAMETERS)))


def _activation_faults(kernels: ModuleType) -> list[str]:
    return activation_faults(kernels, kernels.ActivationConstants(*(one.value for one in kernels.PARAMETERS)))
