"""Which scheme a grid asks for: the only place that tells one column from a surface."""

from __future__ import annotations

from ..model import Model
from ..scheme import WallScheme
from . import column, surface

COLUMN: WallScheme = column
SURFACE: WallScheme = surface


def scheme_of(model: Model) -> WallScheme:
    """The scheme of a model's grid, with the kernels that this module is bound to."""
    return SURFACE if model.grid.is_surface else COLUMN
