"""The configuration of one run: every parameter, typed, checked, with unit, tag and source.

Each field is written once, in `fields`, with its bounds; its default, unit, description, tag and source come from
the parameter files by key.  Numbers are stored in the canonical unit of their parameter, and enter and leave
as text with a unit.  Whatever is wrong with the input becomes one ConfigurationError of one line.
"""

from __future__ import annotations

from .configuration import ENDS, Configuration, Entry
from .fields import LAYERS, Layer, Pellet, Wall, parameter
from .reading import LARGEST_TEXT, read_toml
from .schema import json_schema
from .specification import FIELDS, KEYS, FieldSpec

__all__ = [
    "ENDS",
    "FIELDS",
    "KEYS",
    "LARGEST_TEXT",
    "LAYERS",
    "Configuration",
    "Entry",
    "FieldSpec",
    "Layer",
    "Pellet",
    "Wall",
    "json_schema",
    "parameter",
    "read_toml",
]
