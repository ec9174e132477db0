"""Cables with known answers, in dimensionless or stated units.

Sources: the symbols follow from Eq. (30) by inserting cos(k z); the passive cable is textbook (J. J. B. Jack,
D. Noble, R. W. Tsien, Electric Current Flow in Excitable Cells, 1975, ch. 3; A. L. Hodgkin, W. A. H. Rushton,
Proc. R. Soc. B 133, 1946, for the response to a step).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc

from peristalsis.numerics.stabilised import coefficients, stages_for
from peristalsis.tissue.cells.plant import LEAK, CellConstants
from peristalsis.tissue.conduction import GHOSTS, diffuse, fill_ghosts, largest_eigenvalue
from peristalsis.tissue.records import Brought, SheetArrays, Steps, Tables
from peristalsis.tissue.sheet import advance_sheet

Floats = NDArray[np.float64]


def apply_operator(potential: Floats, diffusivity: float | Floats, cell_size: float) -> Floats:
    """The package's d/dz (D dV/dz) with sealed ends; `diffusivity` at the inner faces, or one for all."""
    n = potential.size
    padded = np.zeros(n + 2 * GHOSTS)
    padded[GHOSTS:-GHOSTS] = potential
    fill_ghosts(padded, 1)
    coefficient = np.broadcast_to(np.asarray(diffusivity, float), (n - 1,)) / (24.0 * cell_size) ** 2
    rate = np.empty(n)
    diffuse(padded, np.ascontiguousarray(coefficient), np.zeros(n + 3), rate, 1)
    return rate


def discrete_symbol(wave_number: float, cell_size: float) -> float:
    """What Eq. (30) makes of -k^2: minus the square of the staggered fourth-order first difference."""
    half = 0.5 * wave_number * cell_size
    return -(((27.0 * np.sin(half) - np.sin(3.0 * half)) / (12.0 * cell_size)) ** 2)


PASSIVE = CellConstants(30.0, -75.0, 0.0, 0.5, 0.0003, 0.0085, 140.0, 12.5, 235.0, 1.0, 1.0)
"""A cell with its leak at 0 mV; with the leak alone open, the sheet is a passive cable."""


@dataclass
class PassiveCable:
    """A sealed passive cable driven through the sheet's own kernel; lengths in space constants, times in tau.

    The leak is 1 mS/cm^2 at 1 uF/cm^2, so that tau = 1 ms, and D = 1 length^2/ms.
    """

    length: float
    cells: int

    def __post_init__(self) -> None:
        self.h = self.length / self.cells
        self.z = (np.arange(self.cells) + 0.5) * self.h
        self.potential = np.zeros(self.cells)

    def advance(
        self, dt: float, steps: int, injected: float = 0.0, leak: float = 1.0, stages: int | None = None
    ) -> int:
        """Advance by steps of as many stages as stability needs; `injected` is the flux into the first cell.

        Returns the kernel's verdict: -1, or the first cell out of range.
        """
        needed = stages or stages_for(dt * (largest_eigenvalue(1.0, self.h) + leak))
        conductances = np.zeros((5, self.cells))
        conductances[LEAK] = leak
        drive = np.zeros(self.cells)
        drive[0] = injected / self.h
        unset = np.full(self.cells, np.nan)
        table = np.zeros((2, 8))
        return advance_sheet(
            SheetArrays(self.potential, np.zeros((4, self.cells)), unset, unset.copy()),
            conductances,
            np.full(self.cells - 1, 1.0 / (24.0 * self.h) ** 2),
            Brought(drive, np.zeros(self.cells)),
            Steps(0.0, dt, steps, 1, True, -40.0),
            coefficients(needed),
            Tables(table, table),
            PASSIVE,
        )


def sealed_cable(z: Floats, length: float) -> Floats:
    """Steady potential of unit flux into z = 0 of a sealed cable: coth(L) cosh(L - z)/cosh(L)."""
    return np.cosh(length - z) / np.sinh(length)


def hodgkin_rushton(x: Floats, t: float) -> Floats:
    """Response of the half-line to a unit flux into x = 0 switched on at t = 0 (x in lambda, t in tau)."""
    root = np.sqrt(t)
    rise = np.exp(-x) * erfc(0.5 * x / root - root)
    return 0.5 * (rise - np.exp(x) * erfc(0.5 * x / root + root))
