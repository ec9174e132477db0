"""A cell model as a layer uses it: its kernels, bound once, and what the rest of the package must know of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..numerics.binding import SHIPPED, Binding, bind
from .records import Tables

Floats = NDArray[np.float64]

PLANT = "plant"
_HERE = Path(__file__).parent
_DESCRIBED = {
    "tissue.cells.plant": _HERE / "cells" / "general.py",
    "tissue.rest": _HERE / "general_rest.py",
}
"""Slots that a described cell fills, besides that of its description."""


@dataclass(frozen=True, eq=False)
class Cell:
    """A cell model. One object for each name and file: two layers with the same cell share it."""

    name: str
    binding: Binding

    @cached_property
    def kernels(self) -> ModuleType:
        """The module that stands in the slot of Plant's cell."""
        return self.binding.module("tissue.cells.plant")

    @cached_property
    def advance_sheet(self) -> Any:
        """`sheet.advance_sheet` with this cell."""
        return self.binding.module("tissue.sheet").advance_sheet

    @cached_property
    def advance_surface_sheet(self) -> Any:
        """`surface_sheet.advance_surface_sheet` with this cell."""
        return self.binding.module("tissue.surface_sheet").advance_surface_sheet

    @cached_property
    def rest(self) -> ModuleType:
        """`rest` with this cell."""
        return self.binding.module("tissue.rest")

    @property
    def constants(self) -> Any:
        """Class of its constants, a NamedTuple with `capacitance` [uF/cm^2] and `kinetics_rate` among its fields."""
        return self.kernels.CellConstants

    @cached_property
    def states(self) -> tuple[str, ...]:
        """Names of its states besides the potential, in the order of their rows."""
        return tuple(name for name, _, _ in self.kernels.STATES)

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Least and largest allowed value of each state."""
        low, high = zip(*((low, high) for _, low, high in self.kernels.STATES), strict=True)
        return np.array(low, dtype=np.float64), np.array(high, dtype=np.float64)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of its conductances, in the order of their rows."""
        names: tuple[str, ...] = self.kernels.CHANNELS
        return names

    @property
    def lowest(self) -> float:
        """Least potential for which it is defined [mV]."""
        return float(self.kernels.TABLE_LOW)

    @property
    def highest(self) -> float:
        """Largest potential for which it is defined [mV]."""
        return float(self.kernels.TABLE_HIGH)

    def tables(self, dt: float, constants: Any) -> Tables:
        """Its tables for a whole and a half step of dt [ms]."""
        return Tables(self.kernels.gate_table(dt, constants), self.kernels.gate_table(0.5 * dt, constants))

    def inhibition(self, constants: Any) -> float:
        """Potential towards which inhibiting nerves pull it [mV]."""
        return float(getattr(constants, self.kernels.INHIBITION))

    def leakiness(self, conductances: Floats, constants: Any) -> float:
        """Largest change of the current of a cell with its potential [mS/cm^2]; conductances: (channels, n)."""
        return float(self.kernels.leakiness(conductances, constants))

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.name, {slot: str(file) for slot, file in _slots(self.binding).items()})


def _slots(binding: Binding) -> dict[str, Path]:
    root = _HERE.parent
    return {".".join(place.relative_to(root).with_suffix("").parts): file for place, file in binding.exchanged.items()}


def _again(name: str, slots: dict[str, str]) -> Cell:
    return _cell(name, bind({slot: Path(file) for slot, file in slots.items()}))


def described(name: str, file: Path) -> Cell:
    """The cell that a file describes for `cells.general`."""
    return _cell(name, bind({**_DESCRIBED, "tissue.cells.hodgkin_huxley": file}))


_cells: dict[tuple[str, str], Cell] = {}


def _cell(name: str, binding: Binding) -> Cell:
    return _cells.setdefault((name, binding.key), Cell(name, binding))


SHIPPED_CELL = _cell(PLANT, SHIPPED)
"""Plant's cell, which stands in the slot."""
