"""Kernels bound to chosen parts: the same source files, imported once more with some of them exchanged.

A compiled kernel binds what it calls when it is compiled, and numba's cache on disk never finds closures or functions
that were passed as arguments. So a choice is made where Python makes it, at import: `bind` gives the package a second
set of modules, `peristalsis.bound.<key>...`, in which a slot such as `tissue.cells.plant` is another file. A module
that depends on an exchanged file is executed anew from its own source; every other name leads to the one module that is
there already. Records, too, are the same classes everywhere, but those of an exchanged file: numba tells arguments
apart by their structure before it looks at their class, and of two classes of one structure it would find only the
first at once; calls with the other took 0.7 ms more each. What is compiled is cached by the content of
all files that went into it (`sources`), under the same names in the next process.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any

from .sources import KERNEL_FOLDERS, PACKAGE, dependencies, kernel_digest

ROOT = PACKAGE.name
BOUND = f"{ROOT}.bound"
"""Names of bound modules begin with this; there is no such folder."""


@dataclass(frozen=True)
class Binding:
    """Which shipped files are exchanged for which others, and the key under which the modules go."""

    key: str
    exchanged: Mapping[Path, Path]

    @property
    def prefix(self) -> str:
        """Beginning of the names of its modules: that of the package itself where nothing is exchanged."""
        return f"{BOUND}.{self.key}" if self.exchanged else ROOT

    @cached_property
    def renewed(self) -> frozenset[Path]:
        """Files of the package that depend on an exchanged one, the exchanged ones among them."""
        files = (file for folder in KERNEL_FOLDERS for file in (PACKAGE / folder).rglob("*.py"))
        return frozenset(file for file in files if not dependencies(file).isdisjoint(self.exchanged))

    def module(self, name: str) -> ModuleType:
        """The module of a dotted name within the package, such as "tissue.sheet", with the exchanged parts."""
        return importlib.import_module(f"{self.prefix}.{name}")


SHIPPED = Binding("", {})
_bindings: dict[str, Binding] = {}


def bind(choices: Mapping[str, Path]) -> Binding:
    """The binding in which each slot, a dotted name such as "tissue.cells.plant", is the file given for it.

    Choices that name the shipped file change nothing. Two calls with files of equal content give the same binding.
    Raises OSError where a file cannot be read and KeyError where there is no such slot.
    """
    exchanged: dict[Path, Path] = {}
    parts: list[str] = []
    for slot, file in sorted(choices.items()):
        place = PACKAGE.joinpath(*slot.split(".")).with_suffix(".py")
        if not place.is_file():
            raise KeyError(slot)
        chosen = Path(file).resolve()
        if chosen != place:
            exchanged[place] = chosen
            parts += [slot, hashlib.sha256(chosen.read_bytes()).hexdigest()]
    if not exchanged:
        return SHIPPED
    key = f"k{hashlib.sha256(' '.join(parts).encode()).hexdigest()[:16]}"
    if key not in _bindings:
        _bindings[key] = Binding(key, exchanged)
    if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Finder())
    return _bindings[key]


def digest_of(module: str, file: Path) -> str | None:
    """Hash of all that a kernel in this file of this module depends on; None for a file outside the package."""
    if module.startswith(f"{BOUND}."):
        return kernel_digest(file, tuple(sorted(_bindings[module.split(".")[2]].exchanged.items())))
    return kernel_digest(file) if file.is_relative_to(PACKAGE) else None


class _Finder(MetaPathFinder):
    """Finds the modules below `BOUND`."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname == BOUND:
            return ModuleSpec(fullname, _Empty(), is_package=True)
        if not fullname.startswith(f"{BOUND}."):
            return None
        key, *parts = fullname.removeprefix(f"{BOUND}.").split(".")
        binding = _bindings.get(key)
        if binding is None:
            return None
        place = PACKAGE.joinpath(*parts)
        if place.is_dir():  # a package of its own, to hold its own modules
            return ModuleSpec(fullname, _Empty(), is_package=True)
        file = place.with_suffix(".py")
        if file in binding.renewed:
            source = str(binding.exchanged.get(file, file))
            own = ".".join([ROOT, *parts])
            exchanged = file in binding.exchanged
            loader = SourceFileLoader(fullname, source) if exchanged else _Renewed(fullname, source, own)
            return importlib.util.spec_from_file_location(fullname, source, loader=loader)
        return ModuleSpec(fullname, _Same(".".join([ROOT, *parts])))


class _Empty(Loader):
    """A package without content: those of the kernels have none."""

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        pass


class _Renewed(SourceFileLoader):
    """A module executed anew, with the records of the one that is there already."""

    def __init__(self, fullname: str, source: str, own: str) -> None:
        super().__init__(fullname, source)
        self.own = own

    def exec_module(self, module: ModuleType) -> None:
        super().exec_module(module)
        known = vars(importlib.import_module(self.own))
        for name, record in list(vars(module).items()):
            if _is_record(record) and record.__module__ == module.__name__ and _alike(record, known.get(name)):
                setattr(module, name, known[name])  # kernels look names up when they are compiled, at their first call


def _is_record(thing: object) -> bool:
    return isinstance(thing, type) and issubclass(thing, tuple) and hasattr(thing, "_fields")


def _alike(record: Any, other: Any) -> bool:
    """Whether two records have the same fields with the same defaults, which may come from an exchanged file."""
    return _is_record(other) and (record._fields, record._field_defaults) == (other._fields, other._field_defaults)


class _Same(Loader):
    """The module that is there already, under a second name."""

    def __init__(self, name: str) -> None:
        self.name = name

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = importlib.import_module(self.name)
        self.own = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__ = self.own  # importlib has put in that of the second name
