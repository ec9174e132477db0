"""Compiled kernels on disk: found by the content of their sources, and loaded without what only compiling needs.

numba has no setting for either, so its own objects are given another folder, stamp and way to load. A release of numba
that names them otherwise keeps its own way: kernels are then compiled again after a move or a fresh checkout, and never
stale. Kernels may also lie in the package itself, compiled for a level of processors when it was built (`tools/wheel`):
these are found by the same hash, and used where system, numba and Python are those of the build and the processor has
all that the level asks for (docs/decisions/0029).
"""

from __future__ import annotations

import functools
import importlib
import io
import json
import os
import pickle
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .sources import PACKAGE

SHIPPED = PACKAGE / "objects"
"""Where a wheel may bring kernels that are compiled."""
ABOUT = "about.json"
"""The file beside them that says what they were compiled for."""

Tell = Callable[[str, bool], None]


@dataclass(frozen=True, slots=True)
class Target:
    """What kernels are compiled for, as numba tells it in its cache: system, level of processors, their features."""

    triple: str
    processor: str
    features: str

    def suits(self, triple: str, features: frozenset[str]) -> bool:
        """Whether code for this target runs on a system with a processor of these features."""
        asked = {one[1:] for one in self.features.split(",") if one.startswith("+")}
        return self.triple == triple and asked <= features


@functools.cache
def shipped_target(folder: Path) -> Target | None:
    """What the kernels in a folder were compiled for; None where there are none, or none for this machine.

    A processor that NUMBA_CPU_NAME or NUMBA_CPU_FEATURES asks for is compiled for.
    """
    asked = any(os.environ.get(name) for name in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"))
    if asked or not (folder / ABOUT).is_file():
        return None
    binding = importlib.import_module("llvmlite.binding")
    with suppress(OSError, ValueError, TypeError, RuntimeError):  # not readable, or a processor unknown to LLVM
        target = Target(**json.loads((folder / ABOUT).read_text("utf-8")))
        features = frozenset(name for name, there in binding.get_host_cpu_features().items() if there)
        return target if target.suits(binding.get_process_triple(), features) else None
    return None


class _Watch:
    """Who is told of kernels that are loaded or compiled, and how many are being compiled, one within the other."""

    def __init__(self) -> None:
        self.tell: Tell | None = None
        self.depth = 0

    def say(self, name: str, compiled: bool) -> None:
        """Tell of a kernel, but for one that is part of another that is being compiled."""
        if self.tell is not None and self.depth == 0:
            self.tell(name, compiled)


_WATCH = _Watch()


@contextmanager
def watched(tell: Tell) -> Iterator[None]:
    """While this lasts, `tell` hears the name of every kernel that is called first, and whether it is compiled now."""
    events = importlib.import_module("numba.core.event")

    class Listener(events.Listener):  # type: ignore[misc,name-defined]
        def on_start(self, event: Any) -> None:
            _WATCH.say(event.data["dispatcher"].py_func.__name__, True)
            _WATCH.depth += 1

        def on_end(self, event: Any) -> None:
            _WATCH.depth -= 1

    before, _WATCH.tell = _WATCH.tell, tell
    try:
        with events.install_listener("numba:compile", Listener()):
            yield
    finally:
        _WATCH.tell = before


def keep(dispatcher: Any, folder: Path, digest: str) -> None:
    """Let the files of a kernel, numba's object, go by the content of its sources alone, not by their path and time."""
    cache = getattr(dispatcher, "_cache", None)
    implementation, files = getattr(cache, "_impl", None), getattr(cache, "_cache_file", None)
    locator, base = getattr(implementation, "_locator", None), getattr(implementation, "_filename_base", None)
    if files is None or base is None or not hasattr(locator, "_cache_path"):
        _mend(cache, None)
        return
    vars(locator)["_cache_path"] = str(folder)
    vars(cache)["_cache_path"] = str(folder)
    vars(cache)["_cache_file"] = type(files)(cache_path=str(folder), filename_base=base, source_stamp=digest)
    _mend(cache, type(files)(cache_path=str(SHIPPED / digest), filename_base=base, source_stamp=digest))


def _mend(cache: Any, shipped: Any) -> None:
    """Load a kernel lightly; let one whose file is not whole be compiled again: a power failure can cut files short.

    One that cannot be written is no reason to stop either. shipped: numba's object for the files of this kernel that
    came with the package, if any did.
    """
    load, forget = getattr(cache, "load_overload", None), getattr(cache, "flush", None)
    save = getattr(cache, "save_overload", None)
    if load is None or forget is None or save is None:
        return

    def load_or_compile(signature: Any, context: Any) -> Any:
        ways: tuple[Callable[[], Any], ...] = (
            lambda: _lightly(cache, shipped, signature, context),
            lambda: load(signature, context),
        )
        for way in ways:
            try:
                found = way()
            except Exception:  # whatever pickle makes of half a file, and a numba that is not as expected here
                continue
            if found is not None:
                _WATCH.say(cache._py_func.__name__, False)
            return found
        forget()
        return None

    def save_if_possible(signature: Any, made: Any) -> None:
        """Keep a kernel that was compiled; one that numba cannot write is used, and compiled by the next process."""
        with suppress(RuntimeError):  # "no compiled object yet": seen once, with many processes compiling at once
            save(signature, made)

    vars(cache)["load_overload"] = load_or_compile
    vars(cache)["save_overload"] = save_if_possible


def _lightly(cache: Any, shipped: Any, signature: Any, context: Any) -> Any:
    """What numba makes of a kernel's file, or None if there is none; an exception where something is unexpected.

    numba reads all that it knows of types and functions before it looks at its cache, which takes longer than its own
    import. Machine code that is there needs its runtime alone.
    """
    importlib.import_module("numba.core.runtime").rtsys.initialize(context)
    codegen = context.codegen()
    codegen._library_class = _light_library(type(codegen)._library_class)
    key = cache._index_key(signature, codegen)
    target = None if shipped is None else shipped_target(SHIPPED)
    if target is not None:
        for_target = (key[0], (target.triple, target.processor, target.features), *key[2:])
        with suppress(Exception):  # damaged: as if it were not there
            found = _rebuilt(cache, shipped, for_target, context)
            if found is not None:
                return found
    return _rebuilt(cache, cache._cache_file, key, context)


def _rebuilt(cache: Any, files: Any, key: Any, context: Any) -> Any:
    name = files._load_index().get(key)
    if name is None:
        return None
    try:
        content = Path(files._data_path(name)).read_bytes()
    except FileNotFoundError:
        return None
    return cache._impl.rebuild(context, _Unpickler(io.BytesIO(content)).load())


class _Unpickler(pickle.Unpickler):
    """Reads a file of numba's cache; kernels name modules of numba that they only need when they are compiled."""

    def find_class(self, module: str, name: str) -> Any:
        found = super().find_class(module, name)
        if (module, name) != ("numba.core.environment", "_rebuild_env"):
            return found
        return functools.partial(_environment, found)


def _environment(rebuild: Any, module: str, constants: Any, name: str) -> Any:
    """The environment of a function; for those of numba's own modules that are not loaded one without their names.

    Only Python objects that compiled code makes are looked up there, which kernels do not make by name. To import such
    a module can mean to look for BLAS, by way of scipy.
    """
    home = importlib.import_module("numba.core.environment")
    if not module.startswith("numba.") or module in sys.modules or home.lookup_environment(name) is not None:
        return rebuild(module, constants, name)
    found = home.Environment({"__name__": module})
    found.consts[:] = constants
    found.env_name = name
    home.Environment._memo[name] = found
    return found


@functools.cache
def _light_library(kind: Any) -> Any:
    """A class of numba's libraries, `kind`, that reads the form of a function in which others are made of it on demand.

    It is half of a kernel's file, and needed only where a kernel is compiled that calls one which was loaded.
    """
    parse = importlib.import_module("llvmlite.binding").parse_bitcode

    class Light(kind):  # type: ignore[misc]
        @classmethod
        def _unserialize(cls, codegen: Any, state: Any) -> Any:
            name, form, content = state
            if form != "object":
                return super()._unserialize(codegen, state)
            library = codegen.create_library(name)
            library.enable_object_caching()
            library._set_compiled_object(content[0])
            library._unread = content[1]
            library._finalize_final_module()
            return library

        @property
        def _shared_module(self) -> Any:
            unread = self.__dict__.pop("_unread", None)
            if unread is not None:
                self._read = parse(unread)
                self._codegen._engine._load_defined_symbols(self._read)
            return self._read

        @_shared_module.setter
        def _shared_module(self, module: Any) -> None:
            self._read = module

        def get_pointer_to_function(self, name: str) -> int:
            if "_unread" not in vars(self):
                return int(super().get_pointer_to_function(name))
            self._ensure_finalized()
            return int(self._codegen._engine.get_function_address(name))

    return Light
