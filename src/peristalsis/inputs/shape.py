"""The pellet's shape that a configuration chooses: its file, bound, and its numbers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigurationError, shown
from ..model.constants import PelletConstants
from ..numerics.binding import Binding, bind
from .config import Configuration
from .parts import SHIPPED, find

Floats = NDArray[np.float64]

SLICES = 400
"""Slices along the axis by which a volume is summed up."""
SLOT = "pellet.shapes.sphere"
"""Slot of the pellet's shape."""
NEEDED = (
    "ShapeConstants",
    "unpack_shape",
    "gap_and_normal",
    "reach",
    "poles",
    "volume",
    "profile",
    "resized",
    "refusal",
)
"""What a shape file defines (docs/shapes.md)."""


@dataclass(frozen=True)
class PelletShape:
    """A shape with its numbers. name: of the shape; binding: of the kernels to it; constants: its `ShapeConstants`."""

    name: str
    binding: Binding
    constants: Any

    @property
    def oral(self) -> float:
        """Distance of the oral pole from the centre [cm]."""
        return float(self._kernels.poles(self.constants)[0])

    @property
    def anal(self) -> float:
        """Distance of the anal pole from the centre [cm]."""
        return float(self._kernels.poles(self.constants)[1])

    @property
    def radius(self) -> float:
        """Largest radius [cm]."""
        return float(self.constants.radius)

    @property
    def volume(self) -> float:
        """Volume [cm^3]."""
        return float(self._kernels.volume(self.constants))

    def outline(self, points: int = 181) -> tuple[Floats, Floats]:
        """The meridian from the oral to the anal pole: distances from the centre and radii [cm], each (points,)."""
        turn = np.linspace(0.0, np.pi, points)
        oral, anal = self.oral, self.anal
        axial = 0.5 * (anal - oral) - 0.5 * (anal + oral) * np.cos(turn)
        radii = np.array(self._kernels.profile(axial, self.constants), dtype=np.float64)
        radii[[0, -1]] = 0.0
        return axial, radii

    def volume_oral_of(self, distance: Floats) -> Floats:
        """Volume [cm^3] of what lies oral of a distance from the centre [cm], in the shape of `distance`.

        By Simpson's rule on the squared profile, with a cubic between its points: exact for a sphere.
        """
        from scipy.interpolate import CubicHermiteSpline  # here: few runs ask for it, and it takes long to load

        places = np.linspace(-self.oral, self.anal, 2 * SLICES + 1)
        areas = np.pi * np.square(np.array(self._kernels.profile(places, self.constants), dtype=np.float64))
        areas[[0, -1]] = 0.0
        slices = (areas[:-2:2] + 4.0 * areas[1::2] + areas[2::2]) * (places[2] - places[0]) / 6.0
        below = CubicHermiteSpline(places[::2], np.concatenate([[0.0], np.cumsum(slices)]), areas[::2])
        return np.asarray(below(np.clip(distance, -self.oral, self.anal)))

    def normals(self, rho: Floats, axial: Floats) -> tuple[Floats, Floats]:
        """(n_rho, n_zeta) at points off the axis and from the centre [cm], each in the shape of `rho`."""
        ask = self._kernels.gap_and_normal
        found = [ask(float(r), float(z), self.constants) for r, z in zip(rho, axial, strict=True)]
        return np.array([one[1] for one in found]), np.array([one[2] for one in found])

    def pellet(self, **about: Any) -> PelletConstants:
        """The pellet of this shape; the other constants by name, as `pellet.body.pellet_of` takes them."""
        made: PelletConstants = self.binding.module("pellet.body").pellet_of(self.constants, **about)
        return made

    @property
    def _kernels(self) -> Any:
        return self.binding.module(SLOT)


def shape_of(configuration: Configuration, binding: Binding | None = None) -> PelletShape:
    """The shape of the pellet. Raises ConfigurationError for numbers of which there is no body, and for a bad file.

    binding: that of the run, if more than the shape is exchanged in it.
    """
    pellet = configuration.pellet
    part = find("shape", pellet.shape)
    numbers = configuration.part_numbers("pellet", part)
    return _shape(part.name, part.file, pellet.radius, tuple(numbers.items()), binding or bind({SLOT: part.file}))


def size_in_words(configuration: Configuration) -> list[tuple[str, str]]:
    """Size and volume of a pellet that is no sphere, as a label and words; nothing of a sphere."""
    pellet = configuration.pellet
    if not pellet.enabled or pellet.shape == SHIPPED["shape"]:
        return []
    shape = shape_of(configuration)
    size = f"{20.0 * shape.radius:.4g} x {10.0 * (shape.oral + shape.anal):.4g} mm"
    return [("pellet", f"{shape.name}, {size}, {shape.volume:.4g} cm^3")]


def _shape(
    name: str, file: Path, radius: float, numbers: tuple[tuple[str, float], ...], binding: Binding
) -> PelletShape:
    try:
        kernels = binding.module(SLOT)
        missing = [one for one in NEEDED if not hasattr(kernels, one)]
    except Exception as error:  # whatever a user's file does when it is imported
        raise ConfigurationError(
            f"pellet.shape = {name}: {shown(str(file))} cannot be imported: {shown(str(error), 200)}; correct it"
        ) from None
    if missing:
        raise ConfigurationError(
            f"pellet.shape = {name}: {shown(str(file))} does not define {missing[0]}; a shape defines "
            f"{', '.join(NEEDED)}"
        )
    fields = ("radius", *(one for one, _ in numbers))
    if kernels.ShapeConstants._fields != fields:
        raise ConfigurationError(
            f"pellet.shape = {name}: {shown(str(file))}: the fields of ShapeConstants are "
            f"{', '.join(kernels.ShapeConstants._fields)}; name radius and then PARAMETERS in their order: "
            f"{', '.join(fields)}"
        )
    constants = kernels.ShapeConstants(radius, *(value for _, value in numbers))
    problem = kernels.refusal(constants)
    if problem:
        raise ConfigurationError(f"pellet.shape = {name}: {problem}")
    return PelletShape(name, binding, constants)
