"""Tables of the bench beside those of every source: speed and force by girth and by load, a row a choice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..outcome import Outcome
from ..source import Table
from ..tables import number
from .runs import ABOVE, BELOW, CONTROL, HELD, LOADS, diameter_run, load_run

SPEED, FORCE = "middle_speed_mm_s", "isometric_force_mN"
NATURAL = 8.0 / 7.0
"""Girth of the natural pellet over that of the tube: 0.40 over 0.35 cm."""


def _by_girth(held: bool) -> Mapping[str, str]:
    """Heading to run, from the narrowest pellet to the widest."""
    natural = {f"{NATURAL:.3g}": HELD if held else CONTROL}
    low, high = ({f"{one:g}": diameter_run(one, held) for one in group} for group in (BELOW, ABOVE))
    return {**low, **natural, **high}


def _table(
    name: str, title: str, note: str, runs: Mapping[str, str], metric: str, outcomes: Sequence[Outcome]
) -> Table:
    rows = []
    for outcome in outcomes:
        found = [outcome.measured.get(run, {}) for run in runs.values()]
        rows.append((outcome.condition.title, *(_cell(one.get(metric), str(one.get("status", ""))) for one in found)))
    return Table(name, title, note, ("preparation", *runs), tuple(rows))


def _cell(value: float | None, status: str) -> str:
    """A number to three digits; that of a run that broke off says so."""
    text = number(value, 3)
    return f"{text} ({status.replace('_', ' ')})" if status in ("diverged", "failed", "refused") else text


def speeds_by_girth(outcomes: Sequence[Outcome]) -> Table:
    """Speed of pellets of six girths under every choice."""
    note = "mm/s over the middle 3 cm, over the pellet's girth as a share of the tube's."
    return _table("girths", "Speed against girth", note, _by_girth(False), SPEED, outcomes)


def forces_by_girth(outcomes: Sequence[Outcome]) -> Table:
    """Isometric force on held pellets of six girths under every choice."""
    note = "mN on a held pellet, over its girth as a share of the tube's."
    return _table("forces", "Isometric force against girth", note, _by_girth(True), FORCE, outcomes)


def speeds_by_load(outcomes: Sequence[Outcome]) -> Table:
    """Speed of the natural pellet against weights on its string under every choice."""
    runs = {"none": CONTROL, **{f"{weight} mN": load_run(weight) for weight in LOADS}}
    return _table("loads", "Speed against load", "mm/s over the middle 3 cm.", runs, SPEED, outcomes)


TABLES = (speeds_by_girth, speeds_by_load, forces_by_girth)
