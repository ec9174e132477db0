"""The one door to numba: every compiled kernel of the package is decorated with `compiled`.

numba is imported when the first kernel is called, not when it is decorated: whatever reads configurations or stored
results never waits for it. What it has compiled is loaded by `kept`, which spares it most of its own start.

numba's on-disk cache looks only at the file that holds a kernel and misses a change in another file that the
kernel calls. So every file has a folder of its own in the cache, named by a hash of that file and of all that it
imports (`sources`): a changed source means a new folder for whatever depends on it, never a stale kernel
(docs/decisions/0010). Neither the path of the package nor the time of a file is part of the name, so checkouts,
environments and notebooks share one cache. Where no folder can be written, kernels are compiled anew each time.
"""

from __future__ import annotations

import functools
import importlib
import os
import re
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

from .binding import digest_of
from .kept import keep

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


@functools.cache
def the_numba() -> Any:
    """numba itself, imported when it is first asked for."""
    return _import_numba()


def __getattr__(name: str) -> Any:
    if name == "numba":
        return the_numba()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


class _FixedTuple:
    """A function that only kernels can call, known to numba by what it stands for."""

    def __call__(self, numbers: Any, count: int) -> tuple[float, ...]:
        return tuple(float(numbers[place]) for place in range(count))

    @property
    def _numba_type_(self) -> Any:
        the_numba()
        meant = importlib.import_module("numba.np.unsafe.ndarray").to_fixed_tuple
        context = importlib.import_module("numba.core.registry").cpu_target.typing_context
        return context.resolve_value_type(meant)


fixed_tuple: Callable[[Any, int], tuple[float, ...]] = _FixedTuple()
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


class Kernel:
    """A function that is compiled: numba's own object for it is made when it is first called, or by a kernel's call.

    Whatever numba's object has, such as `py_func`, `stats` and `signatures`, this has too.
    """

    def __init__(self, function: Callable[..., Any], digest: str | None, options: dict[str, Any]) -> None:
        functools.update_wrapper(self, function)
        self.py_func = function
        self._folder = None if CACHE_FOLDER is None or digest is None else CACHE_FOLDER / digest
        self._digest = digest
        self._options = options

    def __call__(self, *values: Any, **named: Any) -> Any:
        return self.dispatcher(*values, **named)

    @functools.cached_property
    def dispatcher(self) -> Any:
        """numba's object."""
        numba = the_numba()
        if self._folder is not None:
            numba.config.CACHE_DIR = str(self._folder)
        decorate = numba.njit(
            cache=self._folder is not None, fastmath=False, error_model="numpy", nogil=True, **self._options
        )
        found = decorate(self.py_func)
        if self._folder is not None and self._digest is not None:
            keep(found, self._folder, self._digest)
        KERNELS.append(self)
        return found

    @property
    def _numba_type_(self) -> Any:
        """What numba takes this for where another kernel calls it."""
        return self.dispatcher._numba_type_

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.dispatcher, name)

    def __reduce__(self) -> str:
        return self.__qualname__


KERNELS: list[Kernel] = []
"""Those that were called or compiled in this process."""


def _decorate(function: Function, **options: Any) -> Function:
    # The hash is that of the source as it is imported: the file may be another one when the kernel is first called.
    digest = None if CACHE_FOLDER is None else digest_of(function.__module__, Path(function.__code__.co_filename))
    return cast(Function, Kernel(function, digest, options))
