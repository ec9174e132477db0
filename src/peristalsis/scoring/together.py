"""What the points of a search have together: claims that hold at once, that exclude one another, that nearly hold.

A claim that holds at some point is no evidence that the model agrees with a source; claims that hold at one point are.
All tables follow from what was measured at the points that were run on everything that the objective reads.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

from .claim import Claim
from .outcome import Outcome
from .regime import SCORED, Candidate
from .rules import Finding, Measured
from .score import HOLDS, NOT_RUN, score
from .source import Table

Points = Mapping[str, Measured]
"""Name of a point to what was measured there."""


def points(candidates: Iterable[Candidate], outcomes: Iterable[Outcome] = ()) -> Points:
    """The scored points of a search, and parameter sets beside them, by name."""
    found = {one.name: one.measured for one in candidates if one.status == SCORED}
    return found | {outcome.condition.title: outcome.measured for outcome in outcomes}


def by_verdict(claims: Sequence[Claim], found: Points, verdict: str) -> dict[str, frozenset[int]]:
    """The claims with one verdict, at each point."""
    return {
        name: frozenset(one.number for one in claims if score(one, measured).verdict == verdict)
        for name, measured in found.items()
    }


def front(sets: Mapping[str, frozenset[int]]) -> dict[frozenset[int], tuple[str, ...]]:
    """The largest sets of claims that hold together, each with the points at which they do; the longest set first.

    A set is on the front if no point has all of it and more.
    """
    largest = {one for one in sets.values() if not any(one < other for other in sets.values())}
    order = sorted(largest, key=lambda one: (-len(one), sorted(one)))
    return {one: tuple(name for name, claims in sets.items() if claims == one) for one in order}


def exclusive(
    sets: Mapping[str, frozenset[int]], unknown: Mapping[str, frozenset[int]] = MappingProxyType({})
) -> tuple[tuple[int, int], ...]:
    """Pairs of claims that each hold somewhere, and never at the same point.

    unknown: claims that were not run at a point; they may hold there, so that they exclude nothing.
    """
    somewhere = sorted(frozenset().union(*sets.values())) if sets else []
    possible = [one | unknown.get(name, frozenset()) for name, one in sets.items()]
    pairs = itertools.combinations(somewhere, 2)
    return tuple(pair for pair in pairs if not any(set(pair) <= one for one in possible))


def front_table(claims: Sequence[Claim], found: Points) -> Table:
    """The front: how many claims hold together, which, which others hold elsewhere only, and at which points."""
    sets = by_verdict(claims, found, HOLDS)
    somewhere = frozenset().union(*sets.values()) if sets else frozenset()
    rows = [
        (str(len(one)), _listed(one), _listed(somewhere - one), ", ".join(names)) for one, names in front(sets).items()
    ]
    columns = ("claims", "hold together", "hold elsewhere only", "points")
    return Table("front", "Claims that hold together", "No point has all of a row and more.", columns, tuple(rows))


def exclusive_table(claims: Sequence[Claim], found: Points) -> Table:
    """Pairs of claims that were never seen to hold together, with the points at which each does."""
    sets = by_verdict(claims, found, HOLDS)
    rows = [
        (str(first), str(second), str(_times(sets, first)), str(_times(sets, second)))
        for first, second in exclusive(sets, by_verdict(claims, found, NOT_RUN))
    ]
    columns = ("claim", "excludes", "points of the first", "points of the second")
    note = "Each of the two holds somewhere, and no point has both."
    return Table("exclusive", "Claims that exclude one another", note, columns, tuple(rows))


def nearest_table(claims: Sequence[Claim], found: Points) -> Table:
    """Every part of every claim: at how many points it holds, and the point that comes nearest, with its numbers.

    margin: share of the bound by which the number lies on the right side; negative where it does not.
    """
    rows = []
    for claim in claims:
        scores = {name: score(claim, measured) for name, measured in found.items()}
        scores = {name: one for name, one in scores.items() if one.verdict != NOT_RUN}
        whole = sum(one.verdict == HOLDS for one in scores.values())
        for place, part in enumerate(claim.parts):
            judged = {name: one.findings[place] for name, one in scores.items()}
            name, best = _best(judged)
            rows.append(
                (
                    *(str(claim.number), f"{whole} of {len(scores)}", part.name),
                    f"{sum(one.holds is True for one in judged.values())} of {len(judged)}",
                    *(_share(best.margin), best.decisive or best.numbers, name),
                )
            )
    columns = ("claim", "holds at", "part", "part holds at", "best margin", "there", "point")
    return Table("nearest", "How near each claim comes", "", columns, tuple(rows))


TABLES = (front_table, exclusive_table, nearest_table)
"""What is written beside the table of a search's points."""


def _best(judged: Mapping[str, Finding]) -> tuple[str, Finding]:
    """The finding with the largest margin; of equals the first by name."""
    known = {name: one for name, one in judged.items() if not math.isnan(one.margin)}
    if not known:
        return "–", Finding(None, "not judged")
    name = min(known, key=lambda one: (-known[one].margin, one))
    return name, known[name]


def _share(margin: float) -> str:
    if math.isnan(margin):
        return "–"
    if math.isinf(margin):
        return "holds" if margin > 0.0 else "does not"
    return f"{margin:+.2%}"


def _listed(numbers: Iterable[int]) -> str:
    return " ".join(str(one) for one in sorted(numbers))


def _times(sets: Mapping[str, frozenset[int]], claim: int) -> int:
    return sum(claim in one for one in sets.values())
