"""An activation as a layer uses it: its kernels, bound once, and what the rest of the package must know of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..numerics.binding import SHIPPED, Binding, bind

Floats = NDArray[np.float64]

SLOT = "tissue.activations.depolarisation"


@dataclass(frozen=True, eq=False)
class Activation:
    """What makes the drive of muscle from its cells. One object for each name and file."""

    name: str
    binding: Binding

    @cached_property
    def kernels(self) -> ModuleType:
        """The kernels with it in their slot."""
        return self.binding.module("tissue.activating")

    @property
    def constants(self) -> Any:
        """Class of its constants, a NamedTuple."""
        return self.kernels.ActivationConstants

    @cached_property
    def states(self) -> tuple[tuple[str, float, float], ...]:
        """Name, least and largest value of each state that it has in every cell."""
        states: tuple[tuple[str, float, float], ...] = self.kernels.STATES
        return states

    @property
    def reads_calcium(self) -> bool:
        """Whether its drive follows from calcium."""
        return bool(self.kernels.READS_CALCIUM)

    def __reduce__(self) -> tuple[Any, ...]:
        return activation_of, (self.name, *self.binding.exchanged.values())


_activations: dict[tuple[str, str], Activation] = {}


def activation_of(name: str, file: Path | None = None) -> Activation:
    """The activation in a file; without one that of the paper, which stands in the slot."""
    binding = SHIPPED if file is None else bind({SLOT: file})
    return _activations.setdefault((name, binding.key), Activation(name, binding))


SHIPPED_ACTIVATION = activation_of("depolarisation")
"""The paper's, which stands in the slot."""
