"""Where and with what a run is computed: the code, the libraries and the processor that its bits depend on."""

from __future__ import annotations

import importlib.metadata
import os
import platform
from functools import cache

from .._version import __version__

LIBRARIES = ("numpy", "scipy", "numba", "xarray", "h5netcdf")


def versions() -> dict[str, str]:
    """Versions of this package and of what the numbers depend on."""
    found = {"peristalsis": __version__, "python": platform.python_version()}
    for name in LIBRARIES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "unknown"
    return found


@cache
def code_version() -> str:
    """Version of the package and hash of its equations' sources, as they were when this process first asked."""
    from ..numerics.sources import source_digest

    return f"{__version__}-{source_digest()}"


@cache
def machine() -> dict[str, str]:
    """System and processor: kernels are compiled for this processor's instructions, which may change last bits."""
    from llvmlite import binding

    try:
        features = sorted(name for name, there in binding.get_host_cpu_features().items() if there)
    except RuntimeError:  # a processor that the compiler does not know
        features = []
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": str(binding.get_host_cpu_name()),
        "features": " ".join(features),
    }


def processors() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
