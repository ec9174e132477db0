"""Which source files a kernel depends on, and a hash of them: what the cache of compiled kernels goes by."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterable
from functools import cache
from importlib.metadata import version
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
KERNEL_FOLDERS = ("numerics", "geometry", "tissue", "wall", "pellet", "control", "model")

MACHINE_CODE = (
    "NUMBA_BOUNDSCHECK",
    "NUMBA_DEBUGINFO",
    "NUMBA_DISABLE_INTEL_SVML",
    "NUMBA_ENABLE_AVX",
    "NUMBA_LOOP_VECTORIZE",
    "NUMBA_OPT",
    "NUMBA_SLP_VECTORIZE",
)
"""Variables of the environment that change the machine code of a kernel, and that numba's cache does not look at."""

_IMPORT = re.compile(
    r"^[ \t]*from[ \t]+(\.+|peristalsis\b\.?)([\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n#]*)", re.MULTILINE
)
_NAME = re.compile(r"(\w+)(?:\s+as\s+\w+)?\s*(?:,|$|\)|#)", re.MULTILINE)


@cache
def source_digest() -> str:
    """Hash of every source file that can hold a kernel, of numba's version and its settings; 16 hexadecimal digits."""
    return _together(file for folder in KERNEL_FOLDERS for file in (PACKAGE / folder).rglob("*.py"))


@cache
def kernel_digest(file: Path, exchanged: tuple[tuple[Path, Path], ...] = ()) -> str:
    """As `source_digest`, of a source file and of all that it imports of the package.

    exchanged: files of the package, each with the file that stands in its place.
    """
    return _together(dependencies(file, exchanged))


def dependencies(file: Path, exchanged: tuple[tuple[Path, Path], ...] = ()) -> frozenset[Path]:
    """A source file and every file of the package that it imports, directly or through others; see `kernel_digest`."""
    instead = dict(exchanged)
    found, waiting = {file}, [file]
    while waiting:
        new = {instead.get(one, one) for one in _read(waiting.pop())[1]} - found
        found |= new
        waiting += new
    return frozenset(found)


@cache
def _read(file: Path) -> tuple[str, frozenset[Path]]:
    """Hash of a file with its name, and the files behind its relative imports: modules, packages, imported modules."""
    content = file.read_bytes()
    found: list[str] = []
    here = str(file.parent)
    for dots, module, names in _IMPORT.findall(content.decode("utf-8")):
        root = os.path.join(here, *[".."] * (len(dots) - 1)) if dots.startswith(".") else str(PACKAGE)
        base = os.path.normpath(os.path.join(root, *module.split(".")))
        found += [f"{base}.py"] if module else []
        found += [
            os.path.join(base, "__init__.py"),
            *(os.path.join(base, f"{name}.py") for name in _NAME.findall(names)),
        ]
    name = (file.relative_to(PACKAGE).as_posix() if file.is_relative_to(PACKAGE) else file.name).encode()
    digest = hashlib.sha256(name + b"\0" + content).hexdigest()
    return digest, frozenset(Path(place) for place in found if _is_file(place))


@cache
def _is_file(place: str) -> bool:
    return os.path.isfile(place)


def _together(files: Iterable[Path]) -> str:
    settings = [f"{name}={os.environ[name]}" for name in MACHINE_CODE if os.environ.get(name)]
    parts = [_numba_version(), *settings, *sorted(_read(file)[0] for file in files)]
    return hashlib.sha256("".join(parts).encode()).hexdigest()[:16]


@cache
def _numba_version() -> str:
    """Read once: it is looked up among the files of everything that is installed."""
    return version("numba")
