"""Virtual electrodes on the serosa: means of the extracellular potential over small patches of the surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def electrode_weights(
    cells: Floats, columns: Floats, radius: float, places: Sequence[tuple[float, float]], contact_radius: float
) -> Floats:
    """Weights of round contacts, (n_electrodes, n_z, n_theta): each sums to one over the cells whose centre it covers.

    cells: centres along z [cm]; columns: their angles [rad]; radius: of the undeformed tube [cm]; places: (z [cm],
    theta [rad]) of each contact, Lagrangian. A contact smaller than a cell reads the nearest one. Raises ValueError for
    a place off the sheet.
    """
    half = 0.5 * (cells[1] - cells[0]) if cells.size > 1 else np.inf
    weights = np.zeros((len(places), cells.size, columns.size))
    for electrode, (z, theta) in enumerate(places):
        if not cells[0] - half <= z <= cells[-1] + half:
            raise ValueError(
                f"electrode at z = {z:g} cm is off the sheet, which reaches from {cells[0] - half:g} to "
                f"{cells[-1] + half:g} cm; place it in between"
            )
        turn = np.angle(np.exp(1j * (columns - theta)))
        squared = (cells - z)[:, None] ** 2 + (radius * turn)[None, :] ** 2
        covered = squared <= max(contact_radius**2, float(squared.min()))
        weights[electrode] = covered / covered.sum()
    return weights


def electrode_potentials(extracellular: Floats, weights: Floats) -> Floats:
    """Potential [mV] at each electrode, shape (n_electrodes,), from phi_e of shape (n_z, n_theta)."""
    return np.asarray(np.einsum("eij,ij->e", weights, extracellular))
