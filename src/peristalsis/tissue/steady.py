"""A steady state of a cell, whatever the cell is, Eq. (23)."""

from __future__ import annotations

from dataclasses import dataclass


class NoRestError(ValueError):
    """Why a cell has no steady state in the range of its tables, and what to change."""


@dataclass(frozen=True)
class RestState:
    """A steady state of the cell: potential [mV], its other states in their order, and whether the cell stays there."""

    potential: float
    gates: tuple[float, ...]
    stable: bool
