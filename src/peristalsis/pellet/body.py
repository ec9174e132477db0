"""The pellet with the shape in the slot: its constants, and these from packed numbers."""

from __future__ import annotations

import math

import numpy as np

from ..numerics.compiled import compiled
from .constants import FREE, PELLET_DRY, PELLET_SLIDING, PELLET_VISCOUS, PelletConstants, Resistance
from .shapes.sphere import ShapeConstants, poles, resized, unpack_shape, volume


def pellet_of(
    shape: ShapeConstants,
    *,
    present: bool = True,
    viscous: float = 1.0,
    dry: float = 0.0,
    frame: float = 0.0,
    tangential: bool = False,
    lowest: float = -math.inf,
    highest: float = math.inf,
    resistance: Resistance = FREE,
) -> PelletConstants:
    """A pellet of this shape, with its volume and poles; the other arguments are those of `PelletConstants`."""
    oral, anal = poles(shape)
    own = volume(shape), oral, anal
    return PelletConstants(present, shape, viscous, dry, frame, *own, tangential, lowest, highest, *resistance)


def resized_pellet(pellet: PelletConstants, radius: float) -> PelletConstants:
    """The pellet as a similar body of another girth radius [cm]."""
    shape = resized(pellet.shape, radius)
    oral, anal = poles(shape)
    return pellet._replace(shape=shape, volume=volume(shape), oral=oral, anal=anal)


def require_shape(pellet: PelletConstants) -> None:
    """Raise TypeError where a pellet is of another shape than the one that these kernels are bound to."""
    if type(pellet.shape) is not ShapeConstants:
        raise TypeError(
            f"kernels bound to {ShapeConstants.__module__} were handed a pellet of {type(pellet.shape).__module__}; "
            "take them from the binding of the pellet's shape (numerics.binding)"
        )


@compiled
def unpack_pellet(p: np.ndarray) -> PelletConstants:
    """The pellet's constants from what `model.constants.packed` made of them."""
    return PelletConstants(
        p[0] != 0.0,
        unpack_shape(p[1:]),
        p[PELLET_VISCOUS],
        p[PELLET_DRY],
        p[-13],
        p[-12],
        p[-11],
        p[-10],
        p[-9] != 0.0,
        p[-8],
        p[-7],
        p[-6],
        p[-5],
        p[-4],
        p[-3],
        p[-2],
        p[PELLET_SLIDING] != 0.0,
    )
