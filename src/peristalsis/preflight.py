"""What can be said of a run before it starts: is the wave resolved?"""

from __future__ import annotations

import math

from .build import diffusivity
from .config import Configuration

MEASURED_DIFFUSIVITY, MEASURED_SPEED, MEASURED_RATE = 0.0873, 4.2, 0.125
"""Wave that the error laws below were measured on: cm^2/s, cm/s, and tissue.kinetics_rate."""

CELL_ERROR = (3.3, 0.96, 4)
"""Cells of 0.96 foot lengths change the transit by 3.3 %, with the fourth power of their size."""
ELEMENT_ERROR = (1.5, 1.2, 2)
"""Wall elements of 1.2 foot lengths change it by 1.5 %, with the second power."""
MEASURED_RANGE = 5.0
"""Beyond this [%] the laws are no longer those that were measured, and the warning names no number."""
ACCEPTED = 1.0
"""Error of either grid beyond which a run warns [%]; the shipped grids make 0.2 and 0.4 %."""


def foot_length(configuration: Configuration, layer: str) -> float:
    """Length over which the foot of a layer's wave rises e-fold, D/c [cm], scaled from the measured wave."""
    part = configuration.longitudinal if layer == "longitudinal" else configuration.circular
    spread = diffusivity(configuration, part) / MEASURED_DIFFUSIVITY
    pace = configuration.tissue.kinetics_rate / MEASURED_RATE
    return MEASURED_DIFFUSIVITY / MEASURED_SPEED * math.sqrt(spread / pace)


def expected_error(size: float, foot: float, law: tuple[float, float, int]) -> float:
    """Error of the transit [%] that cells or elements of this size [cm] make, by a measured law."""
    percent, reference, order = law
    return percent * (size / (reference * foot)) ** order


def remarks(configuration: Configuration) -> list[str]:
    """Warnings about grids too coarse for the wave; none for the shipped ones."""
    found = [*_unseen_regions(configuration)]
    length = configuration.wall.length
    grids = (
        ("grid.n_z", configuration.grid.n_z, CELL_ERROR, "conduction cells"),
        ("grid.n_z_wall", configuration.grid.n_z_wall, ELEMENT_ERROR, "wall elements"),
    )
    conducting = [
        layer
        for layer, part in (("longitudinal", configuration.longitudinal), ("circular", configuration.circular))
        if part.conduction
    ]
    for key, count, law, what in grids:
        if not conducting:
            break
        foot = min(foot_length(configuration, layer) for layer in conducting)
        error = expected_error(length / count, foot, law)
        if error > ACCEPTED:
            needed = math.ceil(count * (error / ACCEPTED) ** (1.0 / law[2]))
            expected = f"about {error:.1g} %" if error < MEASURED_RANGE else "several per cent or more"
            found.append(
                f"{key} = {count}: {what} of {10.0 * length / count:.2g} mm are coarse for a wave whose foot is "
                f"{10.0 * foot:.2g} mm long; expect the transit to be off by {expected}. "
                f"Use {needed} or more for {ACCEPTED:g} %"
            )
    return found


def _unseen_regions(configuration: Configuration) -> list[str]:
    """Regions so small that no conduction cell has its centre in them."""
    import numpy as np

    from .regions.sampling import reached

    grid, wall = configuration.grid, configuration.wall
    z = (np.arange(grid.n_z) + 0.5) * wall.length / grid.n_z
    angle = 2.0 * np.pi * np.arange(grid.conduction_columns) / grid.conduction_columns
    return [
        f"region {region.name}: no conduction cell lies in it, so it has no effect; enlarge it, or raise grid.n_z or "
        "grid.n_theta_conduction"
        for region in configuration.regions
        if not reached(region, z, angle, wall.radius)
    ]
