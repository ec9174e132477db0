"""The command `list`: scenarios and readings, and the parts that a configuration can choose."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from .. import scenarios, units
from ..errors import ConfigurationError, shown, suggestion
from ..inputs.choices import SLOTS
from ..inputs.parameters import READINGS
from ..inputs.parts import KINDS, Part, parts
from .streams import Screen

KINDS_OF = {f"{kind}s": kind for kind in KINDS}
WHAT = ("scenarios", "readings", "drugs", *KINDS_OF)


def listed(what: str | None, screen: Screen) -> int:
    """What there is of one kind, or scenarios and readings."""
    if what is not None and what not in WHAT:
        raise ConfigurationError(f"WHAT = {shown(what)}: nothing to list; {suggestion(what, WHAT)}")
    if what in KINDS_OF:
        return _parts(KINDS_OF[str(what)], screen)
    if what == "drugs":
        return _drugs(screen)
    answer: dict[str, Any] = {}
    if what in (None, "scenarios"):
        known = [scenarios.get(name) for name in scenarios.names()]
        screen.table(("scenario", "title", "expected"), ((each.name, each.title, each.expected) for each in known))
        keys = ("name", "title", "description", "expected")
        answer["scenarios"] = [{key: getattr(each, key) for key in keys} for each in known]
    if what in (None, "readings"):
        screen.table(("reading", "why"), ((reading.name, reading.why) for reading in READINGS.values()))
        answer["readings"] = [{"name": reading.name, "why": reading.why} for reading in READINGS.values()]
    screen.answer(answer)
    return 0


def _drugs(screen: Screen) -> int:
    from ..inputs.drugs import NOT_ADVICE, amount, library

    known = library()
    rows = [
        (
            one.name,
            one.target if known.targets[one.target].channels else f"{one.target} (not in the model)",
            amount(one.ic50),
            f"{amount(one.range[0])} to {amount(one.range[1])}" if one.range else "",
            f"{one.slope:g}" + ("" if one.slope_stated else " (not stated)"),
            "blocks" if one.maximum < 1.0 else f"opens, up to x {one.maximum:g}",
            one.tissue,
            f"{one.tag}: {one.source}",
        )
        for one in known.agents
    ]
    screen.table(("agent", "target", "IC50", "range", "slope", "effect", "preparation", "source"), rows)
    screen.table(
        ("intervention", "multiplies", "by", "range", "source"),
        (
            (one.name, ", ".join(one.parameters), f"{one.factor:g}", f"{one.range[0]:g} to {one.range[1]:g}",
             f"{one.tag}: {one.source}")
            for one in known.interventions.values()
        ),
    )  # fmt: skip
    screen.say(
        f"Given by --drug 'AGENT AMOUNT'; of several preparations the first is taken. {NOT_ADVICE.capitalize()}."
    )
    answer = {
        "agents": [asdict(one) for one in known.agents],
        "interventions": [asdict(one) for one in known.interventions.values()],
        "targets": [asdict(one) for one in known.targets.values()],
    }
    screen.answer({**answer, "note": NOT_ADVICE})
    return 0


def _parts(kind: str, screen: Screen) -> int:
    known = list(parts(kind).values())
    screen.table((kind, "what it is", "from"), ((part.name, part.title, part.origin) for part in known))
    slots = [slot for slot, own in SLOTS.items() if own == kind]
    section = slots[0].partition(".")[0]
    rows = [
        (f"{section}.{part.name}.{one.name}", units.written(float(one.value), one.unit), one.tag, one.description)
        for part in known
        for one in part.numbers
    ]
    if rows:
        screen.table(
            ("parameter", "value", "tag", "what it is"), ((key, str(value), *more) for key, value, *more in rows)
        )
    screen.say(f"Choose one by {', '.join(slots)}.")
    screen.answer({f"{kind}s": [_plain(part) for part in known], "chosen by": slots})
    return 0


def _plain(part: Part) -> dict[str, Any]:
    return {
        "name": part.name,
        "title": part.title,
        "from": part.origin,
        "states": list(part.states),
        "calcium": dict(zip(("state", "unit"), part.calcium, strict=True)) if part.calcium[0] else None,
        "channels": [one.name for one in part.channels],
        "parameters": [
            {"name": one.name, "value": one.value, "unit": one.unit, "tag": one.tag, "source": one.source}
            for one in part.numbers
        ],
    }
