"""What a region is: a name, a layer, a shape, the width of its edge, and factors; as data, and back to a file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from ...errors import ConfigurationError
from ...units import format_quantity
from ..parts import parts
from .shapes import Band, Box, Disc, Map, Shape, Stripes

SHAPES: Mapping[str, type[Shape]] = MappingProxyType({shape.NAME: shape for shape in (Band, Box, Disc, Stripes, Map)})
LAYERS = ("both", "longitudinal", "circular")

QUANTITIES: Mapping[str, str] = MappingProxyType(
    {
        "active": "force of the muscle",
        "fast_calcium": "conductance of the fast calcium channel",
        "slow_calcium": "conductance of the slow calcium channel",
        "calcium_potassium": "conductance of the calcium-dependent potassium channel",
        "potassium": "conductance of the potassium channel",
        "leak": "conductance of the chloride leak",
        "conductivity": "conductivity of the sheet, in every direction",
        "pacemaker": "what pacemaker and standing rings bring to the cells",
        "trigger": "what the longitudinal layer brings to the circular one",
        "excitation": "exciting current of the reflex",
        "inhibition": "inhibiting conductance of the reflex",
    }
)
"""What a region can multiply, by its name in a file."""


def quantities() -> Mapping[str, str]:
    """QUANTITIES and the channels of the known cells."""
    channels = {one.name: cell.name for cell in parts("cell").values() for one in cell.channels}
    words = {name: f"conductance of the {name} channel of {cell}" for name, cell in channels.items()}
    return {**QUANTITIES, **{name: text for name, text in words.items() if name not in QUANTITIES}}


CIRCULAR_ONLY = ("trigger", "excitation", "inhibition")
"""Quantities of the circular layer: the longitudinal one has no trigger and no part in the reflex."""

MOST_REGIONS = 50
MOST_VALUES = 10_000
"""Values of all maps together: a configuration is stored with them, in one text."""
LARGEST_FACTOR = 100.0
WIDEST_EDGE = 20.0


@dataclass(frozen=True, slots=True)
class Region:
    """One region. edge: width over which its factors fade [cm], half of it outside.

    factors: (quantity, factor) in the order of QUANTITIES. A map brings factors of its own, and names the
    quantities they are for: theirs stand here as 1.
    """

    name: str
    layer: str
    shape: Shape
    edge: float
    factors: tuple[tuple[str, float], ...]

    def table(self) -> dict[str, Any]:
        """As it stands in a file: every number with its unit."""
        head: dict[str, Any] = {"name": self.name, "layer": self.layer, "shape": self.shape.NAME}
        if isinstance(self.shape, Map):
            return head | {
                "quantities": [quantity for quantity, _ in self.factors],
                "z": [format_quantity(place, "cm") for place in self.shape.z],
                "angle": [format_quantity(angle, "deg") for angle in self.shape.angle],
                "values": [list(row) for row in self.shape.values],
            }
        for about in fields(self.shape):
            value = getattr(self.shape, about.name)
            unit = about.metadata["unit"]
            head[about.name] = format_quantity(value, unit) if unit else value
        return head | {"edge": format_quantity(self.edge, "cm")} | dict(self.factors)

    def words(self) -> str:
        """In a line, for tables."""
        what = ", ".join(
            quantity if isinstance(self.shape, Map) else f"{quantity} x {factor:g}" for quantity, factor in self.factors
        )
        layer = "both layers" if self.layer == "both" else f"the {self.layer} layer"
        return f"{self.name} ({self.shape.NAME}, {layer}): {what}"


def varies_around(regions: Iterable[Region]) -> bool:
    """Whether any region differs around the ring."""
    return any(region.shape.varies_around() for region in regions)


def check(regions: Iterable[Region], length: float, radius: float, columns: int) -> None:
    """Refuse regions that do not fit the tube [cm], or that one column around the ring cannot show."""
    for region in regions:
        problem = region.shape.problem(length, radius)
        if problem is None and columns == 1 and region.shape.varies_around():
            problem = (
                f"this {region.shape.NAME} varies around the ring, and grid.n_theta = 1 is one column; use more "
                "columns, such as grid.n_theta = 16, or a shape that does not vary, such as band"
            )
        if problem is not None:
            raise ConfigurationError(f"regions: {region.name}: {problem}")


def schema() -> dict[str, Any]:
    """JSON Schema of `regions` in a file; the keys of each shape are told in words."""
    words = {name: sorted(about.name for about in fields(shape)) for name, shape in SHAPES.items()}
    properties: dict[str, Any] = {
        "name": {"type": "string", "description": "name of the region"},
        "layer": {"type": "string", "enum": list(LAYERS), "default": "both"},
        "shape": {"type": "string", "enum": list(SHAPES), "description": f"with the keys {words}"},
        "edge": {"type": "string", "x-unit": "cm", "default": "0.0 cm", "description": "width over which factors fade"},
        "file": {"type": "string", "description": "CSV file of a map"},
        "quantities": {"type": "array", "items": {"enum": list(quantities())}, "description": "what a map multiplies"},
    }
    for quantity, text in quantities().items():
        limits = {"minimum": 0, "maximum": LARGEST_FACTOR}
        properties[quantity] = {"type": "number", **limits, "description": f"factor on the {text}"}
    return {
        "type": "array",
        "default": [],
        "description": "parts of the wall whose tissue differs; they multiply in their order",
        "items": {"type": "object", "required": ["name", "shape"], "properties": properties},
    }
