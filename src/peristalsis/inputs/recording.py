"""What a run will keep in memory and write: which fields, how often, how many bytes; known before it starts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ..names import CELLS, FIELDS, OF_PLANT, OUTPUTS, PROBE, PROBES, SCALARS, outputs_of_cell
from .parts import SHIPPED, Part

ALL = "all"
ALWAYS = ("radius", "angle", "axial_position")
"""The places of the wall: without them no picture and no comparison is possible."""
CHOICES = (ALL, *(output.name for output in FIELDS if output.name not in ALWAYS))
"""What `output.fields` may name of the package's own fields."""


def choices() -> tuple[str, ...]:
    """What `output.fields` may name, fields that were registered from outside included."""
    return (ALL, *(output.name for output in FIELDS if output.name not in ALWAYS))


NUMBER = 8
"""Bytes of a number."""


ROUNDING = 1e-6
"""Share of a step below which a time is taken to be at the step."""


def whole_steps(duration: float, step: float) -> int:
    """The least number of steps that take at least `duration`, both in s."""
    return max(1, math.ceil(duration / step - ROUNDING))


def frames_apart(interval: float, step: float) -> float:
    """Steps from one frame to the next: `interval` over `step`, both in s, whole if it is so but for rounding."""
    ratio = max(1.0, interval / step)
    return float(round(ratio)) if abs(ratio - round(ratio)) < ROUNDING else ratio


def due(step: int, every: float) -> bool:
    """Whether a step is the first at or after a multiple of `every` steps."""
    return math.floor((step + ROUNDING) / every) > math.floor((step - 1 + ROUNDING) / every)


class Recording(NamedTuple):
    """How many times are stored, which fields, and how many bytes all recorded arrays take."""

    times: int
    fields: tuple[str, ...]
    size: float

    def words(self) -> str:
        """In a line, for the user."""
        return f"recording {len(self.fields)} fields at up to {self.times} times, about {_bytes(self.size)}"


Cells = Mapping[str, Part]
"""Cell model of each layer."""


def chosen(fields: Sequence[str], cells: Cells | None = None) -> tuple[str, ...]:
    """The fields that are stored, in the order of `names.FIELDS`; the places of the wall always are.

    cells: of the layers; a field that they do not have is left out.
    """
    without = _left_out(cells or {})
    found = (output.name for output in FIELDS if ALL in fields or output.name in (*ALWAYS, *fields))
    return tuple(name for name in found if name not in without)


def probe_names(cells: Cells) -> tuple[str, ...]:
    """The outputs at the probes of a run whose layers have these cells."""
    without = _left_out(cells)
    found = [output.name for output in PROBES if output.name not in without]
    for layer, cell in _others(cells):
        own = outputs_of_cell(layer, cell.states, [one.name for one in cell.channels])
        found += [output.name for output in own if output.dimensions == PROBE and output.name not in found]
    return tuple(found)


def _others(cells: Cells) -> list[tuple[str, Part]]:
    return [(layer, cell) for layer, cell in cells.items() if cell.name != SHIPPED["cell"]]


def _left_out(cells: Cells) -> set[str]:
    """Outputs that a layer does not have, since its cell is not Plant's."""
    found: set[str] = set()
    for layer, cell in _others(cells):
        own = {output.name for output in outputs_of_cell(layer, cell.states, [one.name for one in cell.channels])}
        found |= OF_PLANT[layer] - own
    return found


def planned(
    duration: float,
    interval: float,
    step: float,
    wall_nodes: int,
    cells: int,
    probes: int,
    fields: Sequence[str],
    kinds: Cells | None = None,
) -> Recording:
    """What a run of `duration` keeps [s], with fields every `interval` and numbers every `step`; kinds: of cells."""
    names = chosen(fields, kinds)
    on_cells = sum(OUTPUTS[name].dimensions == CELLS for name in names)
    frame = on_cells * cells + (len(names) - on_cells) * wall_nodes
    times = duration / max(interval, step) + 2.0
    numbers = len(SCALARS) + len(probe_names(kinds or {})) * probes
    return Recording(round(times), names, NUMBER * (times * frame + (duration / step + 1.0) * numbers))


def _bytes(size: float) -> str:
    for unit, factor in (("GB", 1e9), ("MB", 1e6)):
        if size >= factor:
            return f"{size / factor:.3g} {unit}"
    return f"{max(1.0, size / 1e3):.3g} kB"
