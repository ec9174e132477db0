"""How many compiled kernels this process has, and how many of them it had to compile itself."""

from __future__ import annotations

import sys
from dataclasses import dataclass


@dataclass(frozen=True)
class Census:
    """Kernels that can be called, compiled here (not in the cache), and loaded from the cache."""

    ready: int
    compiled: int
    loaded: int


def census() -> Census:
    """Count over every module of the package that is loaded."""
    kernels = {}
    for name, module in list(sys.modules.items()):
        if name.startswith("peristalsis."):
            for one in vars(module).values():
                if hasattr(one, "py_func") and hasattr(one, "stats"):
                    kernels[id(one)] = one
    return Census(
        ready=sum(len(one.signatures) for one in kernels.values()),
        compiled=sum(sum(one.stats.cache_misses.values()) for one in kernels.values()),
        loaded=sum(sum(one.stats.cache_hits.values()) for one in kernels.values()),
    )
