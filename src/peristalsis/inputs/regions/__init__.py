"""Regions of tissue: parts of the wall whose muscle, cells or nerves differ from the rest.

A region is a shape on the undeformed surface and factors on what lies inside. Regions multiply, in their order.
This package knows shapes, files and cell centres; it knows no physics. Reading a configuration needs no numpy, so
`sampling`, which does, is imported where fields are made.
"""

from .reading import read
from .specification import MOST_REGIONS, QUANTITIES, SHAPES, Region, check, schema, varies_around

__all__ = ["MOST_REGIONS", "QUANTITIES", "SHAPES", "Region", "check", "read", "schema", "varies_around"]
