"""What was asked in time and place, and steps and cells carry otherwise: found before a run, and said.

Everything is asked in seconds and centimetres, and happens in steps and cells. What is honoured exactly, such as the
charge of a pulse between steps, needs no word; the rest is decided here for every input (table in docs/protocols.md).
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Iterator

import numpy as np

from .. import units
from ..control.sequence import GATED
from .choices import LAYERS
from .config import Configuration
from .consistency import PARAMETERS_OF_PLANT
from .drugs import doubtful, mixed, without_target
from .parameters import PARAMETERS, shipped
from .parts import SHIPPED
from .protocols import Protocol
from .recording import ROUNDING, frames_apart, whole_steps
from .shape import shape_of

ARREST_TRAVEL, ARREST_WINDOW = 0.01, 1.0
"""A pellet is arrested when it moved less than 0.01 cm over the last second (0.1 mm/s), so never earlier."""


def remarks(configuration: Configuration) -> list[str]:
    """One sentence for everything asked that steps or cells carry otherwise, or that can never come to pass."""
    c = configuration
    return [*_lengths(c), *_courses(c), *_ends(c), *_drivers(c), *_places(c), *_parts(c), *_drugs(c)]


def _drugs(c: Configuration) -> Iterator[str]:
    yield from without_target(c.drugs, {layer: cell.name for layer, cell in c.cells().items()})
    yield from (f"drugs: {one}" for one in doubtful(c.drugs, [cell.name for cell in c.cells().values()]))
    said = mixed(c.drugs)
    if said is not None:
        yield f"drugs: {said}"


def _step(c: Configuration) -> float:
    return units.to_internal(c.step.whole, "ms")


def _lengths(c: Configuration) -> Iterator[str]:
    step = _step(c)
    count = whole_steps(c.run.duration, step)
    if abs(c.run.duration - count * step) > ROUNDING * step:
        yield (
            f"run.duration = {c.run.duration:g} s is no whole number of steps of {c.step.whole:g} ms: the run goes on "
            f"to {count * step:.12g} s"
        )
    if not float(frames_apart(c.output.interval, step)).is_integer():
        yield (
            f"output.interval = {c.output.interval:g} s is no whole number of steps of {c.step.whole:g} ms: fields are "
            "stored at the first step at or after each multiple of it"
        )
    if c.solver.integrator == "explicit" and c.step.explicit > 0.0:
        parts = math.ceil(c.step.conduction / c.step.explicit * (1.0 - 1e-9))
        if abs(parts * c.step.explicit - c.step.conduction) > 1e-6 * c.step.conduction:
            yield (
                f"step.explicit = {c.step.explicit:g} ms is no whole part of step.conduction = {c.step.conduction:g} "
                f"ms: {parts} steps of {c.step.conduction / parts:.6g} ms are made of it"
            )


def _courses(c: Configuration) -> Iterator[str]:
    step = _step(c)
    end = whole_steps(c.run.duration, step) * step
    for course in c.time_courses():
        skipped = unseen(course, step)
        if skipped:
            yield (
                f"protocols: {len(skipped)} of {len(course.times)} values of {course.parameter} lie within a step of "
                f"{c.step.whole:g} ms with a later one, first that at {course.times[skipped[0]]:g} s, and are not "
                f"seen; shorten {c.step.whole_key} if they matter"
            )
        late = len(course.times) - bisect.bisect_left(course.times, end)
        if late and course.times[0] < course.times[-1]:
            yield (
                f"protocols: {late} of {len(course.times)} values of {course.parameter} lie at or beyond the end of "
                f"the run at {end:g} s"
            )
        stepped = course.times[1:] if course.shape == "step" else ()
        between = [time for time in stepped if abs(time / step - round(time / step)) > ROUNDING]
        if between:
            yield (
                f"protocols: {course.parameter} changes between two steps, first at {between[0]:.12g} s, and takes its "
                f"value at the next, less than {c.step.whole:g} ms later"
            )


def unseen(course: Protocol, step: float) -> list[int]:
    """Values that no step begins with, because a later one rules or has passed by then: their numbers."""
    first = np.ceil(np.asarray(course.times) / step - ROUNDING)
    return [int(k) for k in np.flatnonzero(first[1:] == first[:-1])]


def _ends(c: Configuration) -> Iterator[str]:
    run, place = c.run, c.run.stop_position
    shipped = place == PARAMETERS["run.stop_position"].value
    if not c.pellet.enabled:
        if run.stop_when_arrested or not shipped:
            yield "run.stop_when_arrested and run.stop_position wait for a pellet, and there is none"
        return
    start = c.pellet.start_gap + shape_of(c).oral
    if place <= start:
        yield (
            f"run.stop_position = {place:g} cm: the pellet starts at {start:g} cm, at it or beyond it, and stops the "
            "run only if it comes back to it; give a place on its way"
        )
    elif not shipped and place >= c.wall.span:
        yield f"run.stop_position = {place:g} cm lies beyond the tube of {c.wall.span:g} cm: it stops no run"
    if run.stop_when_arrested and run.duration <= ARREST_WINDOW:
        yield (
            f"run.stop_when_arrested: rest is judged over {ARREST_WINDOW:g} s, and run.duration = {run.duration:g} s "
            "is no longer"
        )


LAW_NUMBERS = ("c1", "c2", "c3", "c4", "c5", "c6", "c10")


def _parts(c: Configuration) -> Iterator[str]:
    """Numbers of the shipped parts that were changed where another part is chosen."""
    plain = shipped(c.reading)
    ours = c.flat()
    others = [layer for layer in ("longitudinal", "circular") if c.cell_of(layer) != SHIPPED["cell"]]
    keys = {f"{layer}.{name}": f"{layer}.cell = {c.cell_of(layer)}" for layer in others for name in PARAMETERS_OF_PLANT}
    if len(others) == 2 and c.pacemaker.kind != "cell":
        keys |= {key: f"the cells of both layers are {c.cell_of('longitudinal')}" for key in ours if key[:5] == "cell."}
        keys |= dict.fromkeys(("tissue.kinetics_rate", "tissue.capacitance"), f"tissue.cell = {c.cell_of('circular')}")
    if c.wall.law != SHIPPED["law"]:
        keys |= {f"wall.{name}": f"wall.law = {c.wall.law}" for name in LAW_NUMBERS}
    if c.wall.muscle != SHIPPED["muscle"]:
        keys |= {f"{layer}.{name}": f"wall.muscle = {c.wall.muscle}" for layer in LAYERS for name in ("c7", "c8", "c9")}
    for layer in LAYERS:
        driven = c.activation_of(layer).name
        if driven != SHIPPED["activation"]:
            keys[f"{layer}.threshold"] = f"{layer}.activation = {driven}"
    for key, why in keys.items():
        if ours[key] != plain[key].value:
            yield f"{key} is set and has no effect: {why}"


def _drivers(c: Configuration) -> Iterator[str]:
    under_protocol = {course.parameter for course in c.time_courses()}
    pulses = c.pacemaker.kind in ("pulse", "periodic")
    if pulses and "pacemaker.onset" not in under_protocol and c.pacemaker.onset >= c.run.duration:
        yield (
            f"pacemaker.onset = {c.pacemaker.onset:g} s: the run ends at {c.run.duration:g} s, before the first pulse"
        )

    if c.trigger.gate == "stretch":
        yield from _gate(c, under_protocol)

    late = [one for one in c.stimuli if one.onset >= c.run.duration]
    if late:
        yield (
            f"stimuli: {len(late)} of {len(c.stimuli)} begin at or beyond the end of the run at {c.run.duration:g} s, "
            f"first that at {min(one.onset for one in late):g} s"
        )


def _gate(c: Configuration, under_protocol: set[str]) -> Iterator[str]:
    """A gate that can never open, or has nothing to keep back."""
    if not c.pellet.enabled:
        yield "trigger.gate = stretch: without a pellet no receptor is stretched, and the gate never opens"
    elif not c.reflex.enabled and "reflex.enabled" not in under_protocol:
        yield (
            "trigger.gate = stretch: its receptors are those of the reflex, and reflex.enabled = false; the gate never "
            "opens"
        )
    if c.trigger.rule not in GATED and "trigger.rule" not in under_protocol:
        yield (
            f"trigger.gate = stretch: under trigger.rule = {c.trigger.rule} the circular layer is not started place by "
            "place, and the gate has nothing to keep back"
        )


def _places(c: Configuration) -> Iterator[str]:
    cell = c.wall.length / c.grid.n_z
    narrow = [one for one in c.stimuli if one.high - one.low < cell * (1.0 - 1e-9)]
    if narrow:
        yield (
            f"stimuli: {len(narrow)} of {len(c.stimuli)} are narrower than a cell of {cell:.4g} cm (grid.n_z = "
            f"{c.grid.n_z}), first that at {narrow[0].onset:g} s: the cells there get their share of it"
        )
    widths = [("pacemaker.width", c.pacemaker.width, c.pacemaker.kind != "none")]
    widths.append(("rings.width", c.rings.width, c.rings.enabled))
    for key, width, used in widths:
        if used and width < cell * (1.0 - 1e-9):
            yield (
                f"{key} = {width:g} cm is less than a cell of {cell:.4g} cm (grid.n_z = {c.grid.n_z}): the cells there "
                "get their share of it, over their whole length"
            )
    for place in c.rings.positions if c.rings.enabled else ():
        low, high = place - 0.5 * c.rings.width, place + 0.5 * c.rings.width
        if low < -1e-9 or high > c.wall.length + 1e-9:
            yield (
                f"rings.positions: the ring at {place:g} cm reaches beyond the end of the tube by "
                f"{max(-low, high - c.wall.length):.4g} cm, which is lost"
            )
    seen: dict[int, float] = {}
    for place in c.output.probes:
        at = min(int(place / cell), c.grid.n_z - 1)
        if at in seen:
            yield (
                f"output.probes: {seen[at]:g} cm and {place:g} cm lie in one cell, whose middle is at "
                f"{(at + 0.5) * cell:.6g} cm; both hold the same"
            )
        seen.setdefault(at, place)
