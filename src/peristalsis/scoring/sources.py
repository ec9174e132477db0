"""Finds the sources: one folder each in this room, and those that a file of the user has registered."""

from __future__ import annotations

import importlib
import pkgutil
from pathlib import Path

from ..errors import ConfigurationError, shown, suggestion
from .source import Source

_added: dict[str, Source] = {}


def names() -> tuple[str, ...]:
    """All sources by name."""
    folders = pkgutil.iter_modules([str(Path(__file__).parent)])
    return tuple(sorted({*(folder.name for folder in folders if folder.ispkg), *_added}))


def get(name: str) -> Source:
    """The source of this name. Raises ConfigurationError if there is none."""
    if name in _added:
        return _added[name]
    if name not in names():
        raise ConfigurationError(f"source = {shown(name)}: no such source; {suggestion(name, names())}")
    found: Source = importlib.import_module(f"{__package__}.{name}.source").SOURCE
    return found


def register(source: Source) -> Source:
    """Add a source from outside the package, for this process.

    Raises ConfigurationError if its name is taken, or if a claim asks for a run that the source does not have.
    """
    if not source.name.isidentifier() or (source.name in names() and _added.get(source.name) != source):
        raise ConfigurationError(f"source {shown(source.name)}: the name is taken or no identifier; choose another")
    known = {*source.runs, *source.searches, *source.sensitivities}
    for claim in source.claims:
        for run in claim.runs():
            if run not in known:
                raise ConfigurationError(
                    f"source {shown(source.name)}: claim {source.label(claim.number)} asks for the run {shown(run)}, "
                    "which is not among its runs, searches and sensitivities; add it"
                )
    _added[source.name] = source
    return source


def forget_all() -> None:
    """Take out what was registered."""
    _added.clear()
