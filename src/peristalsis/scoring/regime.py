"""A search for the parameter set under which most claims of a source hold: drawn, screened, scored, refined.

A point of the space has every number but the force of muscle. First the edge is found along the force at which the norm
stops riding the wave, for all points in step, by bisection; the point's own force lies above it by a share that is part
of the point. Then few runs sort the points, and the best are run on everything that the objective reads. All of it
follows from the space and from kept runs, so that a second search, or one taken up again, gives the same table.
"""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from .. import scenarios
from .claim import Claim
from .outcome import Condition
from .rules import Measured
from .runs import Bench, carry_out
from .score import HOLDS, score
from .source import Table
from .space import Space, Values

NEVER, ALWAYS, OFF, SCREENED_OUT, SCORED = (
    "never rides",
    "rides with the least force",
    "transit out of range",
    "screened out",
    "scored",
)


@dataclass(frozen=True)
class Candidate:
    """One point: where it came from, its edge as a bracket of the force, and what was found.

    parent: name of the one it was moved from. status: how far it came. measured: run to metrics.
    """

    name: str
    values: Values
    parent: str = ""
    low: float = 0.0
    high: float = 0.0
    force: float = 0.0
    status: str = ""
    measured: Measured = field(default_factory=dict)

    def transit(self, space: Space) -> float | None:
        """Of the norm [s]."""
        return self.measured.get(space.edge.run, {}).get("transit_s")


@dataclass(frozen=True)
class Search:
    """A search in a space under one reading, with the bench on which it runs. say: told what is being done."""

    bench: Bench
    space: Space
    reading: str = "tight"
    say: Callable[[str], None] = lambda words: None

    def carry_out(self) -> tuple[Candidate, ...]:
        """All candidates, in the order in which they were made."""
        drawn = [Candidate(f"s{place:03d}", values) for place, values in enumerate(self.space.drawn())]
        found = self._round(drawn)
        for round_ in range(self.space.rounds):
            self.say(f"refined, round {round_ + 1} of {self.space.rounds}")
            found = (*found, *self._round(self._moved(found, round_)))
        return found

    def with_held_out(self, candidates: Iterable[Candidate]) -> tuple[Candidate, ...]:
        """The scored candidates with what the claims that were held out read as well: once the search is over.

        Sensitivities, of fifty runs each, are made for the best `screened` of them only.
        """
        claims, out = self.bench.source.claims, self.space.objective.held_out
        scored = [one for one in candidates if one.status == SCORED]
        best = {one.name for one in ranked(claims, self.space, scored)[: self.space.screened]}
        return tuple(self._asked(one, out, one.name in best) for one in scored)

    def _moved(self, found: Sequence[Candidate], round_: int) -> list[Candidate]:
        """Points around the best so far; the children of one parent are counted on from round to round."""
        born = Counter(one.parent for one in found)
        parents = ranked(self.bench.source.claims, self.space, found)[: self.space.parents]
        return [
            Candidate(f"{parent.name}.{born[parent.name] + child}", values, parent.name)
            for place, parent in enumerate(parents)
            for child, values in enumerate(self.space.around(parent.values, place, round_))
        ]

    def condition(self, candidate: Candidate, force: float | None = None) -> Condition:
        """Under what a candidate's experiments are made, with its own force or another."""
        at = candidate.force if force is None else force
        return Condition(self.reading, self.space.changes(candidate.values, at, self._base), candidate.name)

    @functools.cached_property
    def _base(self) -> Mapping[str, Any]:
        """The numbers of the reading, on which factors are."""
        return scenarios.configuration(reading=self.reading).flat()

    def _round(self, candidates: Sequence[Candidate]) -> tuple[Candidate, ...]:
        """Edge, screening and the whole objective for a set of candidates."""
        placed = self._edges(candidates)
        screened = self._screened([one for one in placed if not one.status])
        best = ranked(self.bench.source.claims, self.space, [one for one in screened if not one.status])
        scored = {one.name: self._whole(one) for one in best[: self.space.screened]}
        rest = {one.name: replace(one, status=one.status or SCREENED_OUT) for one in screened if one.name not in scored}
        known = {one.name: one for one in placed} | rest | scored
        return tuple(known[one.name] for one in candidates)

    def _edges(self, candidates: Sequence[Candidate]) -> list[Candidate]:
        edge = self.space.edge
        self.say(f"edge of riding: {len(candidates)} points, {edge.halvings} halvings")
        found = {one.name: replace(one, low=edge.low, high=edge.high) for one in candidates}
        for bound, expected, status in ((edge.high, True, NEVER), (edge.low, False, ALWAYS)):
            rides = self._rides({name: bound for name, one in found.items() if not one.status}, found)
            for name, riding in rides.items():
                if riding is not expected:
                    found[name] = replace(found[name], status=status)
        for _ in range(edge.halvings):
            middles = {n: _middle(one.low, one.high) for n, one in found.items() if not one.status}
            for name, riding in self._rides(middles, found).items():
                middle = middles[name]
                one = found[name]
                found[name] = replace(one, high=middle) if riding else replace(one, low=middle)
        return [
            one if one.status else replace(one, force=self.space.beyond(one.values, one.high)) for one in found.values()
        ]

    def _rides(self, forces: Mapping[str, float], found: Mapping[str, Candidate]) -> dict[str, bool]:
        norm = self.bench.source.runs[self.space.edge.run]
        rows = self.bench.records_under((self.condition(found[name], force), norm) for name, force in forces.items())
        return {name: self.space.edge.rides(rows[name, norm.name].summary) for name in forces}

    def _screened(self, candidates: Sequence[Candidate]) -> list[Candidate]:
        """The norm, and where its transit is within bounds the runs of the screening."""
        source, objective = self.bench.source, self.space.objective
        self.say(f"screening: {len(candidates)} points")
        norms = self.bench.records_under((self.condition(one), source.runs[self.space.edge.run]) for one in candidates)
        kept: list[Candidate] = []
        found: list[Candidate] = []
        for one in candidates:
            measured = {self.space.edge.run: norms[one.name, self.space.edge.run].summary}
            transit = measured[self.space.edge.run].get("transit_s")
            off = transit is None or not objective.transit[0] <= transit <= objective.transit[1]
            (found if off else kept).append(replace(one, measured=measured, status=OFF if off else ""))
        runs = [source.runs[name] for name in objective.screening]
        rows = self.bench.records_under((self.condition(one), run) for one in kept for run in runs)
        for one in kept:
            found.append(replace(one, measured={run.name: rows[one.name, run.name].summary for run in runs}))
        return found

    def _whole(self, candidate: Candidate) -> Candidate:
        """Everything that the objective reads, searches for thresholds among it."""
        return replace(self._asked(candidate, self.space.objective.claims), status=SCORED)

    def _asked(self, candidate: Candidate, numbers: Sequence[int], sensitivities: bool = True) -> Candidate:
        """A candidate with what the claims of these numbers read."""
        claims = [one for one in self.bench.source.claims if one.number in numbers]
        needed = {run for claim in claims for run in claim.runs()}
        if not sensitivities:
            needed -= set(self.bench.source.sensitivities)
        self.say(f"{candidate.name}: {len(needed)} runs and searches")
        condition, source = self.condition(candidate), self.bench.source
        outcome = carry_out(self.bench, condition, sorted(needed & set(source.runs)), searches=sorted(needed))
        return replace(candidate, measured={**candidate.measured, **outcome.measured})


def _middle(low: float, high: float) -> float:
    return float(f"{(low * high) ** 0.5:.5g}")


def merit(claims: Sequence[Claim], space: Space, candidate: Candidate) -> tuple[int, int, float]:
    """Claims asked that hold, their parts that hold, and minus the distance of the transit from its target."""
    scores = [score(claim, candidate.measured) for claim in claims if claim.number in space.objective.claims]
    parts = sum(found.holds is True for one in scores for found in one.findings)
    transit = candidate.transit(space)
    distance = abs(transit - space.objective.target) if transit is not None else space.objective.target
    return sum(one.verdict == HOLDS for one in scores), parts, -distance


def ranked(claims: Sequence[Claim], space: Space, candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best first; those that were run on everything before those that were not; equals by name."""

    def order(one: Candidate) -> tuple[bool, int, int, float, str]:
        holds, parts, distance = merit(claims, space, one)
        return one.status != SCORED, -holds, -parts, -distance, one.name

    return sorted(candidates, key=order)


def table(claims: Sequence[Claim], space: Space, candidates: Sequence[Candidate]) -> Table:
    """Every candidate as a row: the best first, its numbers, how far it came, and the verdict of each claim asked."""
    asked = [claim for claim in claims if claim.number in space.objective.claims]
    names = [*(one.name for one in space.free), *(one.name for one in space.choices)]
    rows = []
    for one in ranked(claims, space, candidates):
        holds, parts, _ = merit(claims, space, one)
        verdicts = [score(claim, one.measured).verdict if one.measured else "" for claim in asked]
        transit = one.transit(space)
        rows.append(
            (
                *(one.name, one.parent, one.status, f"{one.low:.5g}", f"{one.high:.5g}", f"{one.force:.6g}"),
                f"{transit:.4f}" if transit is not None else "",
                *(str(holds), str(parts)),
                *(str(one.values[name]) for name in names),
                *verdicts,
            )
        )
    head = ("point", "moved from", "came to", "edge above", "edge below", "force", "transit (s)", "hold", "parts")
    columns = (*head, *names, *(f"claim {claim.number}" for claim in asked))
    return Table("candidates", "Points of the search", "", columns, tuple(rows))
