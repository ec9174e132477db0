"""Constants of the wall, whatever laws it has: records that no exchanged part renews."""

from __future__ import annotations

from typing import Any, NamedTuple


class WallConstants(NamedTuple):
    """Everything the wall needs, in mN, cm, s, mV; `published` picks the tension convention of Eq. (35).

    passive: the passive law's `PassiveConstants`; longitudinal, circular: the active law's `ActiveConstants`.
    """

    radius: float
    element_size: float
    viscosity: float
    surface_density: float
    bending_stiffness: float
    bending_viscosity: float
    slack_blend: float
    slack_slope: float
    fold_stretch: float
    fold_tension: float
    published: bool
    passive: Any
    longitudinal: Any
    circular: Any


class SurfaceConstants(NamedTuple):
    """Shear viscosity [mN s/cm], bending around the ring [mN cm] and its viscosity [mN s cm], foundation [mN/cm^3]."""

    shear_viscosity: float = 0.005
    bending_stiffness_around: float = 0.5
    bending_viscosity_around: float = 1.0e-5
    foundation: float = 100.0
