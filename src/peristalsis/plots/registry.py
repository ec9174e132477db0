"""Finds the figures: one module each in `plots/figures`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

from . import figures as home
from .figure import Figure

FIRST = "overview"


@lru_cache(maxsize=1)
def figures() -> Mapping[str, Figure]:
    """Name to figure, the overview first and the others by name."""
    found: dict[str, Figure] = {}
    for module in pkgutil.iter_modules(home.__path__):
        figure = importlib.import_module(f"{home.__name__}.{module.name}").FIGURE
        found[figure.name] = figure
    ordered = sorted(found, key=lambda name: (name != FIRST, name))
    return MappingProxyType({name: found[name] for name in ordered})
