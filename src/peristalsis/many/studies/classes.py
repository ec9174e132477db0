"""Classes of rows: what became of a point, in a word, by a function of its status and outputs that has a name."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any

from ...errors import ConfigurationError, DivergenceError, PeristalsisError, shown, suggestion
from ..rows import Row

Classifier = Callable[[Mapping[str, Any]], str]
"""From a row (what was varied, `status`, every output) to the name of its class."""

WITHOUT = {"refused": "refused", PeristalsisError.status: "failed", DivergenceError.status: "diverged"}


def expelled(row: Mapping[str, Any]) -> str:
    """Whether the pellet left the tube anally within the run."""
    return "expelled" if row.get("transit_s") is not None else "not expelled"


def status(row: Mapping[str, Any]) -> str:
    """The status of the run."""
    return str(row["status"]).replace("_", " ")


RIDES, CAUGHT, LEFT, ARRESTED = REGIMES = ("rides the wave", "slips and is caught", "left behind", "arrested")
"""How a pellet travels: out with the wave, out but later than it, moved and not out, hardly moved."""
WITHIN = 1.25
"""Transit over the wave's own time for the pellet's way up to which it rides [1]: 1.1 riding, 1.4 caught again."""
MOVED = 0.5
"""Travel from which a pellet that does not arrive was moved and left behind [cm]."""


def rides(row: Mapping[str, Any], within: float = WITHIN) -> bool:
    """Whether the pellet of a run leaves with the circular wave, and not after it."""
    transit, travel, speed = row.get("transit_s"), row.get("travel_cm"), row.get("wave_speed_cm_s")
    speed = speed.get("circular") if isinstance(speed, Mapping) else row.get("wave_speed_cm_s.circular", speed)
    if transit is None or not travel or not speed:
        return False
    return bool(transit * speed / travel <= within)


def motion(row: Mapping[str, Any], within: float = WITHIN) -> str:
    """How a run moves its pellet: one of `REGIMES`, or expelled orally; "" for a run that says nothing of a pellet."""
    if row.get("oral_exit_s") is not None:
        return "expelled orally"
    if row.get("travel_cm") is None:
        return ""
    if row.get("transit_s") is not None:
        return RIDES if rides(row, within) else CAUGHT
    return LEFT if row["travel_cm"] >= MOVED else ARRESTED


_known: dict[str, Classifier] = {"expelled": expelled, "motion": motion, "status": status}


def register(name: str, classifier: Classifier) -> None:
    """Make a classifier known by a name, for this process. Raises ConfigurationError if the name is taken."""
    if _known.get(name, classifier) is not classifier:
        raise ConfigurationError(f"classes: there are classes named {shown(name)}; choose another name")
    _known[name] = classifier


def forget(name: str) -> None:
    """Take a classifier out again."""
    _known.pop(name)


def get(name: str) -> Classifier:
    """The classifier of a name: a known one, or `module:function`. Raises ConfigurationError if there is none."""
    if name in _known:
        return _known[name]
    module, colon, function = name.partition(":")
    if not colon:
        raise ConfigurationError(
            f"classes = {shown(name)}: no such classes; {suggestion(name, _known)} Your own are module:function"
        )
    try:
        found = getattr(importlib.import_module(module), function)
    except (ImportError, AttributeError) as error:
        raise ConfigurationError(f"classes = {shown(name)}: {error}; name a function that can be imported") from None
    if not callable(found):
        raise ConfigurationError(f"classes = {shown(name)} is no function; name one of a row")
    made: Classifier = found
    return made


def class_of(row: Row, classifier: Classifier) -> str:
    """The class of a row; those without a result have one of their own, whatever the classifier."""
    if row.status in WITHOUT:
        return WITHOUT[row.status]
    return classifier({**row.point.values, **row.summary})
