"""How many compiled kernels this process has, and how many of them it had to compile itself."""

from __future__ import annotations

from dataclasses import dataclass

from peristalsis.numerics.compiled import KERNELS


@dataclass(frozen=True)
class Census:
    """Kernels that can be called, compiled here (not in the cache), and loaded from the cache."""

    ready: int
    compiled: int
    loaded: int


def census() -> Census:
    """Count over every kernel that was called in this process, or compiled as part of another."""
    return Census(
        ready=sum(len(one.signatures) for one in KERNELS),
        compiled=sum(sum(one.stats.cache_misses.values()) for one in KERNELS),
        loaded=sum(sum(one.stats.cache_hits.values()) for one in KERNELS),
    )
