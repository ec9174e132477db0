"""What an exact problem is, and how its numbers become a verdict."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from .exact.orders import observed_orders

Tier = Literal["quick", "full"]
Verdict = Literal["pass", "fail", "not applicable", "elsewhere"]

ORDER_TOLERANCE = 0.1
FEWEST_LEVELS = 4


@dataclass(frozen=True)
class Check:
    """One observed number between two bounds; a number that is not finite never passes."""

    what: str
    observed: float
    low: float = -math.inf
    high: float = math.inf

    @property
    def passed(self) -> bool:
        """Whether the number is finite and between the bounds."""
        return math.isfinite(self.observed) and self.low <= self.observed <= self.high

    @property
    def bounds(self) -> str:
        """The acceptance in words."""
        if self.low == self.high:
            return f"= {self.low:.6g}"
        if math.isinf(self.low) or (self.low == 0.0 and math.isfinite(self.high)):
            return f"≤ {self.high:.3g}"
        if math.isinf(self.high):
            return f"≥ {self.low:.3g}"
        return f"{self.low:.6g} … {self.high:.6g}"


@dataclass(frozen=True)
class Outcome:
    """What a problem gave. error: the number that decides most; order: the observed order farthest from the stated one.

    The verdict follows from the checks alone (`judged`); problems without checks are not applicable or elsewhere.
    """

    expected: str
    observed: str
    error: float | None
    order: float | None
    accept: str
    verdict: Verdict
    note: str = ""
    checks: tuple[Check, ...] = ()


@dataclass(frozen=True)
class Problem:
    """One exact problem: `source` is literature or derivation, `equations` those of docs/equations.md it exercises."""

    id: str
    title: str
    source: str
    tier: Tier
    run: Callable[[], Outcome]
    equations: tuple[int, ...] = ()


def error(what: str, observed: float, limit: float) -> Check:
    """An error or any other number that must not exceed `limit`; its sign is no matter."""
    return Check(what, abs(float(observed)), 0.0, limit)


def equal(what: str, observed: float, wanted: float) -> Check:
    """A number that must be met to the last bit."""
    return Check(what, float(observed), wanted, wanted)


def order(
    what: str, sizes: Sequence[float], errors: Sequence[float], wanted: float, tolerance: float = ORDER_TOLERANCE
) -> Check:
    """The observed order farthest from `wanted`, on at least four levels, gated from both sides.

    Raises ValueError with fewer levels or errors that vanish: then no order was observed.
    """
    if len(errors) < FEWEST_LEVELS or len(sizes) != len(errors) or not all(e > 0.0 for e in errors):
        raise ValueError(f"{what}: no order can be told from {list(errors)}; give four levels with errors above zero")
    farthest = max((float(p) for p in observed_orders(sizes, errors)), key=lambda p: abs(p - wanted))
    return Check(f"order {what}".strip(), farthest, wanted - tolerance, wanted + tolerance)


def judged(expected: str, checks: Sequence[Check], note: str = "") -> Outcome:
    """An outcome whose verdict is that of its checks; the first error and the first order stand for the rest."""
    if not checks:
        raise ValueError(f"{expected}: nothing was checked")
    errors = [check for check in checks if check.low == 0.0]
    orders = [check.observed for check in checks if check.what.startswith("order")]
    return Outcome(
        expected=expected,
        observed="; ".join(f"{check.what} {check.observed:.2g}" for check in checks),
        error=max(errors, key=_used).observed if errors else None,
        order=orders[0] if orders else None,
        accept="; ".join(f"{check.what} {check.bounds}" for check in checks),
        verdict="pass" if all(check.passed for check in checks) else "fail",
        note=note,
        checks=tuple(checks),
    )


def not_applicable(expected: str, why: str) -> Outcome:
    """A problem that this model or scheme does not pose, with the reason."""
    return Outcome(expected, "–", None, None, "–", "not applicable", why)


def elsewhere(expected: str, where: str) -> Outcome:
    """A problem whose result is kept on another page."""
    return Outcome(expected, "–", None, None, "–", "elsewhere", where)


def _used(check: Check) -> float:
    """How much of its allowance an error uses."""
    return check.observed / check.high if check.high > 0.0 else math.inf if check.observed > 0.0 else 0.0
