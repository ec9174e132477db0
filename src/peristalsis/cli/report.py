"""The numbers of a run as a table for a person."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..inputs.drugs import NOT_ADVICE
from ..many.comparing import NUMBERS, Number, value_of
from ..names import CERTAIN
from .streams import Screen, spelled

if TYPE_CHECKING:
    from ..inputs.config import Entry
    from ..results.result import Result

FRICTION = {
    "pellet.viscous_friction": ("viscous friction", "N*s/m", 0.1),
    "pellet.dry_friction": ("dry friction", "N", 1e-3),
}
"""Friction in its own unit and in that of the paper, whose printed unit is in doubt (docs/decisions/0002)."""


def print_summary(result: Result, target: Path, pictures: tuple[str, ...], screen: Screen) -> None:
    """The outcome, the numbers in two units, friction beside what the paper prints, and where it all is."""
    summary = result.summary
    title = f"{summary['scenario']}, reading {summary['reading']}: {str(summary['status']).replace('_', ' ')}"
    screen.table(("quantity", "value", "in other units"), _rows(result), title)
    friction = (
        [_friction_row(entry) for entry in result.configuration.items() if entry.key in FRICTION]
        if result.configuration.pellet.enabled
        else []
    )
    if friction:
        screen.table(("friction of the pellet", "used", "in other units", "printed in the paper"), friction)
    if result.configuration.drugs:
        screen.table((f"drugs ({NOT_ADVICE})",), ((dose.words(),) for dose in result.configuration.drugs))
    for layer, reason in (summary.get("wave_speed_reason") or {}).items():
        if reason is not None:
            screen.say(f"no wave speed, {layer} layer: {reason}")
    screen.say(f"saved in {spelled(target)}")
    if pictures:
        screen.say(f"pictures there: {', '.join(pictures)}; all others: peristalsis plot {spelled(target)}")


def print_certainty(result: Result, screen: Screen) -> None:
    """What the doubled grid and the halved steps came to, and whether the run may be used; nothing if not asked."""
    from ..running.certain import WORDS

    verdict = result.summary.get(CERTAIN)
    if verdict is None:
        return
    rows = [("as asked", result.summary), *((WORDS[name], run) for name, run in verdict["runs"].items())]
    if verdict["runs"]:
        screen.table(("run", "status", "transit", "last position", "largest force", "change"), map(_certain_row, rows))
    screen.say(str(verdict["sentence"]))


def _certain_row(named: tuple[str, Mapping[str, Any]]) -> tuple[str, ...]:
    name, run = named
    return (
        name,
        str(run["status"]).replace("_", " "),
        number_text(run.get("transit_s"), "s"),
        number_text(run.get("final_position_cm"), "cm"),
        number_text(run.get("max_axial_force_mN"), "mN"),
        number_text(run.get("change_percent"), "%"),
    )


def number_text(value: float | None, unit: str, scale: float = 1.0) -> str:
    """A number with its unit, or a dash."""
    if value is None:
        return "-"
    text = f"{value * scale:.4g}" if isinstance(value, float) else str(value)
    return text if unit == "1" else f"{text} {unit}"


def _rows(result: Result) -> Iterator[tuple[str, str, str]]:
    for number in NUMBERS:
        value = value_of(result.summary, number)
        if value is not None and not (number.seldom and value == 0):
            yield number.label, number_text(value, number.unit), _other(value, number)


def _other(value: float, number: Number) -> str:
    return number_text(value, number.other, number.factor) if number.other else ""


def _friction_row(entry: Entry) -> tuple[str, str, str, str]:
    label, other, factor = FRICTION[entry.key]
    value = float(str(entry.value))
    printed = f"{entry.printed}, read as {number_text(float(str(entry.shipped)), entry.unit)}"
    return label, number_text(value, entry.unit), number_text(value, other, factor), printed
