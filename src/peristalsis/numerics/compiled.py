"""The one door to numba: every compiled kernel of the package is decorated with `compiled`.

numba's on-disk cache looks only at the file that holds a kernel and misses a change in another file that the
kernel calls. So every file has a folder of its own in the cache, named by a hash of that file and of all that it
imports (`sources`): a changed source means a new folder for whatever depends on it, never a stale kernel
(docs/decisions/0010). Neither the path of the package nor the time of a file is part of the name, so checkouts,
environments and notebooks share one cache. Where no folder can be written, kernels are compiled anew each time.
"""

from __future__ import annotations

import importlib
import os
import re
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from .binding import digest_of

_UNREAD = re.compile(r"Environment variable '(\w+)' is defined but its associated value '(.*?)' could not be parsed")


def _import_numba() -> Any:
    """numba, which answers a variable of the environment that it cannot read with a traceback: made one sentence.

    Threads are not used here, so a number of them that numba refuses is said and changes nothing.
    """
    said = "{} = {!r} is not what numba understands and is not used; unset it, or give it a whole number of at least 1"
    threads = os.environ.get("NUMBA_NUM_THREADS", "").strip()
    if re.fullmatch(r"-\d+|[+]?0+", threads):
        warnings.warn(said.format("NUMBA_NUM_THREADS", threads), RuntimeWarning, stacklevel=2)
        del os.environ["NUMBA_NUM_THREADS"]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        import numba
    for one in caught:
        unread = _UNREAD.match(str(one.message))
        if unread:
            warnings.warn(said.format(*unread.groups()).partition(", or")[0], RuntimeWarning, stacklevel=2)
        else:
            warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)
    return numba


numba = _import_numba()

fixed_tuple: Callable[[Any, int], tuple[float, ...]] = importlib.import_module("numba.np.unsafe.ndarray").to_fixed_tuple
"""For kernels: the first so many entries of an array, a number known when they are compiled, as a tuple."""

Function = TypeVar("Function", bound=Callable[..., Any])


INDEX = 2**31 - 1
"""An index `and` this is seen by the compiler not to be negative, so that it drops the check for Python's indices
from the end, and loops over it may use vector registers. For parts of arrays, whose first index is an argument."""


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _cache_folder() -> Path | None:
    named = os.environ.get("NUMBA_CACHE_DIR")
    home = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(home):  # to be ignored, says its specification
        home = os.path.join(os.path.expanduser("~"), ".cache")
    for root in (Path(named) if named else None, Path(home) / "peristalsis" if os.path.isabs(home) else None):
        if root is not None and _writable(root):
            return root
    return None


CACHE_FOLDER = _cache_folder()


def compiled(function: Function) -> Function:
    """Compile `function` with numba: cached on disk, double precision as written (no fast-math), one thread."""
    return _decorate(function)


def inlined(function: Function) -> Function:
    """As `compiled`, and always made part of its caller: a loop around a call would not use vector registers.

    For formulas without branches: choose between values that are both computed, not between statements.
    """
    return _decorate(function, forceinline=True)


def _decorate(function: Function, **more: Any) -> Function:
    file = Path(function.__code__.co_filename)
    digest = None if CACHE_FOLDER is None else digest_of(function.__module__, file)
    kept = digest is not None  # a function typed in has no file to go by
    if CACHE_FOLDER is not None and digest is not None:
        numba.config.CACHE_DIR = str(CACHE_FOLDER / digest)
    result: Function = numba.njit(cache=kept, fastmath=False, error_model="numpy", nogil=True, **more)(function)
    if CACHE_FOLDER is not None and digest is not None:
        _place(result, CACHE_FOLDER / digest, digest)
    _mend(result)
    return result


def _place(kernel: object, folder: Path, digest: str) -> None:
    """Let a kernel's files in the cache go by the content of its sources alone, not by their path and time.

    numba has no setting for it, so its own object is given another folder and stamp. A release of numba that names
    them otherwise keeps its own way: kernels are then compiled again after a move or a fresh checkout, and never stale.
    """
    cache = getattr(kernel, "_cache", None)
    implementation, files = getattr(cache, "_impl", None), getattr(cache, "_cache_file", None)
    locator, base = getattr(implementation, "_locator", None), getattr(implementation, "_filename_base", None)
    if files is None or base is None or not hasattr(locator, "_cache_path"):
        return
    vars(locator)["_cache_path"] = str(folder)
    vars(cache)["_cache_path"] = str(folder)
    vars(cache)["_cache_file"] = type(files)(cache_path=str(folder), filename_base=base, source_stamp=digest)


def _mend(kernel: object) -> None:
    """Let a kernel whose file in the cache is not whole be compiled again: a power failure can cut files short."""
    kept = getattr(kernel, "_cache", None)
    load, forget = getattr(kept, "load_overload", None), getattr(kept, "flush", None)
    if load is None or forget is None:
        return

    def load_or_compile(*words: Any) -> Any:
        try:
            return load(*words)
        except Exception:  # whatever pickle makes of half a file
            forget()
            return None

    vars(kept)["load_overload"] = load_or_compile
