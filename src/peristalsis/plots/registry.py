"""Finds the figures: one module each in `plots/figures`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

from ..errors import ConfigurationError, shown
from . import figures as home
from .figure import Figure

FIRST = "overview"


_added: dict[str, Figure] = {}


def register(figure: Figure) -> Figure:
    """Add a figure from outside the package, for this process. Raises ConfigurationError if its name is taken."""
    if not figure.name.isidentifier() or (figure.name in figures() and _added.get(figure.name) != figure):
        raise ConfigurationError(f"figure {shown(figure.name)}: the name is taken or no identifier; choose another")
    _added[figure.name] = figure
    figures.cache_clear()
    return figure


def forget_all() -> None:
    """Take out what was registered."""
    _added.clear()
    figures.cache_clear()


@lru_cache(maxsize=1)
def figures() -> Mapping[str, Figure]:
    """Name to figure, the overview first and the others by name."""
    found = dict(_added)
    for module in pkgutil.iter_modules(home.__path__):
        figure = importlib.import_module(f"{home.__name__}.{module.name}").FIGURE
        found[figure.name] = figure
    ordered = sorted(found, key=lambda name: (name != FIRST, name))
    return MappingProxyType({name: found[name] for name in ordered})
