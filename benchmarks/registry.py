"""Finds the sections: every module of `sections` that defines SECTION; a new one is a new file."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable, Mapping
from functools import lru_cache
from types import MappingProxyType

from peristalsis.errors import ConfigurationError, shown, suggestion

from . import sections as home
from .section import Section


@lru_cache(maxsize=1)
def sections() -> Mapping[str, Section]:
    """Every section by name, in the order of the page."""
    found = [
        importlib.import_module(f"{home.__name__}.{module.name}").SECTION
        for module in pkgutil.iter_modules(home.__path__)
    ]
    return MappingProxyType({one.name: one for one in sorted(found, key=lambda one: (one.place, one.name))})


def chosen(names: Iterable[str] = ()) -> tuple[Section, ...]:
    """The named sections, or all; ConfigurationError for an unknown name."""
    known = sections()
    named = tuple(dict.fromkeys(names))
    for name in named:
        if name not in known:
            raise ConfigurationError(f"section = {shown(name)}: no such section; {suggestion(name, known)}")
    return tuple(known[name] for name in named) if named else tuple(known.values())
