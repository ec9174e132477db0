"""Every output of a run, once: name, dimensions, unit, long name, and the function that gives its value.

Recorders, files, tables and figures take them from here. `register` adds one from outside the package.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

KPA = 100.0
"""mN/cm^2 in a kPa."""


class Output(NamedTuple):
    """One variable of a result: its dimensions, its unit as written in files, what it is, and where it comes from.

    value: called with what is recorded, returns the number or array in `unit`. That is a `moment.StepMoment` for
    outputs over the steps, a `moment.Moment` for fields and probes, an `events.Event` for those over "event". None for
    coordinates, and for outputs of a stored run that this process does not know.
    """

    name: str
    dimensions: tuple[str, ...]
    unit: str
    long_name: str
    value: Callable[[Any], Any] | None = None


WALL = ("time", "z", "theta")
CELLS = ("time", "z_cell", "theta_cell")
STEP = ("time_step",)
PROBE = ("time_step", "probe")

COORDINATES = (
    Output("time", ("time",), "s", "time of a stored field"),
    Output("time_step", ("time_step",), "s", "time of a wall step"),
    Output("z", ("z",), "cm", "wall node, distance from the oral end in the undeformed tube"),
    Output("z_cell", ("z_cell",), "cm", "conduction cell, distance from the oral end in the undeformed tube"),
    Output("theta", ("theta",), "rad", "angle around the undeformed tube"),
    Output("theta_cell", ("theta_cell",), "rad", "angle of the conduction cells around the undeformed tube"),
    Output("probe", ("probe",), "cm", "probe, distance from the oral end in the undeformed tube"),
)


def _tension(name: str, part: str, layer: str, long_name: str) -> Output:
    return Output(name, WALL, "mN/cm", long_name, lambda now: now.tension(part, layer))


FIELDS = [
    Output("radius", WALL, "cm", "radius of the wall", lambda now: now.wall.position[:, :, 0]),
    Output("angle", WALL, "rad", "angle of the wall point", lambda now: now.wall.position[:, :, 1]),
    Output("axial_position", WALL, "cm", "axial position of the wall point", lambda now: now.wall.position[:, :, 2]),
    Output("stretch_longitudinal", WALL, "1", "longitudinal stretch", lambda now: now.stretches.longitudinal),
    Output("stretch_circumferential", WALL, "1", "circumferential stretch", lambda now: now.stretches.circumferential),
    _tension("tension_longitudinal", "total", "longitudinal", "total longitudinal tension"),
    _tension("tension_circumferential", "total", "circular", "total circumferential tension"),
    _tension("active_tension_longitudinal", "active", "longitudinal", "active tension of the longitudinal muscle"),
    _tension("active_tension_circumferential", "active", "circular", "active tension of the circular muscle"),
    _tension("passive_tension_longitudinal", "passive", "longitudinal", "passive longitudinal tension"),
    _tension("passive_tension_circumferential", "passive", "circular", "passive circumferential tension"),
    Output(
        "contact_pressure",
        WALL,
        "kPa",
        "contact pressure between wall and pellet",
        lambda now: now.contact_pressure / KPA,
    ),
    *(
        Output(
            f"potential_{layer}",
            CELLS,
            "mV",
            f"membrane potential of the {cells}",
            lambda now, layer=layer: now.sheet(layer).potential,  # type: ignore[misc]
        )
        for layer, cells in (
            ("longitudinal", "longitudinal muscle"),
            ("circular", "circular muscle"),
            ("network", "interstitial cells"),
        )
    ),
    *(
        Output(
            f"calcium_{layer}",
            CELLS,
            "1",
            f"intracellular calcium of the {layer} muscle",
            lambda now, layer=layer: now.calcium(layer),  # type: ignore[misc]
        )
        for layer in ("longitudinal", "circular")
    ),
]
"""Stored every `output.interval`, on wall nodes or on conduction cells."""

ACTIVATION = (
    Output(
        "activation_longitudinal",
        ("z_cell", "theta_cell"),
        "s",
        "first activation of the longitudinal muscle",
        lambda now: now.state.longitudinal.first_activation * 1e-3,
    ),
    Output(
        "activation_circular",
        ("z_cell", "theta_cell"),
        "s",
        "first activation of the circular muscle",
        lambda now: now.state.circular.first_activation * 1e-3,
    ),
)
"""Taken once, from the last state."""

SCALARS = [
    Output(
        "pellet_position",
        STEP,
        "cm",
        "position of the pellet's centre",
        lambda now: now.state.pellet.position if now.model.pellet.present else math.nan,
    ),
    Output("pellet_velocity", STEP, "cm/s", "velocity of the pellet", lambda now: now.state.pellet.velocity),
    Output(
        "axial_force", STEP, "mN", "axial force of the wall on the pellet", lambda now: now.state.pellet.axial_force
    ),
    Output("normal_force", STEP, "mN", "sum of the contact forces on the pellet", lambda now: now.contact.normal_force),
    Output("viscous_force", STEP, "mN", "viscous friction on the pellet", lambda now: now.viscous_force),
    Output(
        "dry_force",
        STEP,
        "mN",
        "dry friction on the pellet",
        lambda now: now.dry_force,
    ),
    Output(
        "dry_friction_limit",
        STEP,
        "mN",
        "largest dry friction that holds or brakes the pellet",
        lambda now: now.dry_friction_limit,
    ),
    Output(
        "end_reaction",
        STEP,
        "mN",
        "axial force of a closed end of the segment on the pellet",
        lambda now: now.end_reaction,
    ),
    Output("oral_reaction", STEP, "mN", "axial force of the tube at the oral end", lambda now: now.ends.oral),
    Output("anal_reaction", STEP, "mN", "axial force of the tube at the anal end", lambda now: now.ends.anal),
    Output("lumen_pressure", STEP, "kPa", "lumen pressure", lambda now: now.state.pressure / KPA),
    Output(
        "max_contact_pressure",
        STEP,
        "kPa",
        "largest contact pressure on the pellet",
        lambda now: now.contact.largest_pressure / KPA,
    ),
    Output("contact_start", STEP, "cm", "oral edge of the contact", lambda now: now.contact.start),
    Output("contact_end", STEP, "cm", "anal edge of the contact", lambda now: now.contact.end),
    Output(
        "min_diameter",
        STEP,
        "cm",
        "smallest inner diameter of the tube",
        lambda now: 2.0 * now.contact.least_radius,
    ),
    Output(
        "slack_share",
        STEP,
        "1",
        "share of the wall that carries no tension in one direction",
        lambda now: now.ends.slack,
    ),
    Output(
        "smallest_gap",
        STEP,
        "cm",
        "smallest gap between wall and pellet; negative where they overlap",
        lambda now: now.contact.smallest_gap,
    ),
    Output("newton_iterations", STEP, "1", "Newton iterations of the step", lambda now: now.newton_iterations),
    Output("step_parts", STEP, "1", "parts that the step was made in", lambda now: now.parts),
    Output("steps_rejected", STEP, "1", "tries of step and parts that were too long", lambda now: now.rejected),
    Output("work_active", STEP, "mN*cm", "work done by the muscle since t = 0", lambda now: now.done.active),
    Output("work_gas", STEP, "mN*cm", "work done by the lumen's content since t = 0", lambda now: now.done.gas),
    Output("energy_wall", STEP, "mN*cm", "work stored in the passive wall since t = 0", lambda now: now.done.stored),
    Output("loss_wall", STEP, "mN*cm", "work lost in the viscous wall since t = 0", lambda now: now.done.lost_wall),
    Output(
        "loss_pellet",
        STEP,
        "mN*cm",
        "work lost in friction of the pellet since t = 0",
        lambda now: now.done.lost_pellet,
    ),
    Output(
        "power_residual",
        STEP,
        "mN*cm",
        "what the balance of work leaves over since t = 0",
        lambda now: now.done.residual,
    ),
    Output(
        "momentum_residual",
        STEP,
        "mN",
        "what the balance of axial momentum leaves over",
        lambda now: now.momentum.residual,
    ),
    *(
        Output(
            f"threshold_{layer}",
            STEP,
            "mV",
            f"potential above which the {layer} muscle pulls",
            lambda now, layer=layer: now.layer(layer).threshold,  # type: ignore[misc]
        )
        for layer in ("longitudinal", "circular")
    ),
]
"""Stored after every step."""


def _potential_probe(layer: str) -> Output:
    return Output(
        f"potential_{layer}_probe",
        PROBE,
        "mV",
        f"membrane potential of the {layer} muscle at the probes",
        lambda now: now.at_probes(now.sheet(layer).potential),
    )


def _gate_probe(layer: str, name: str, gate: str, text: str) -> Output:
    return Output(
        f"{name}_{layer}_probe",
        PROBE,
        "1",
        f"{text} of the {layer} muscle at the probes",
        lambda now: now.at_probes(now.gate(layer, gate)),
    )


def _calcium_probe(layer: str) -> Output:
    return Output(
        f"calcium_{layer}_probe",
        PROBE,
        "1",
        f"intracellular calcium of the {layer} muscle at the probes",
        lambda now: now.at_probes(now.calcium(layer)),
    )


def _conductance_probe(layer: str, name: str, text: str) -> Output:
    return Output(
        f"conductance_{name}_{layer}_probe",
        PROBE,
        "mS/cm^2",
        f"conductance of the {text} channel of the {layer} muscle at the probes",
        lambda now: now.conductance_at_probes(layer, name),
    )


GATES = {
    "h": ("h", "inactivation gate h"),
    "n": ("n", "potassium gate n"),
    "x": ("x", "slow calcium gate x"),
}
"""Name in files to name in the cell model, and what it is."""
CHANNELS = {
    "fast_calcium": "fast calcium",
    "slow_calcium": "slow calcium",
    "potassium": "potassium",
    "calcium_potassium": "calcium-activated potassium",
    "leak": "leak",
}

PROBES = [
    output
    for layer in ("longitudinal", "circular")
    for output in (
        _potential_probe(layer),
        *(_gate_probe(layer, name, gate, text) for name, (gate, text) in GATES.items()),
        _calcium_probe(layer),
        *(_conductance_probe(layer, name, text) for name, text in CHANNELS.items()),
    )
]
"""Stored after every step, at `output.probes`."""

OF_PLANT = {
    layer: {
        f"calcium_{layer}",
        *(f"{name}_{layer}_probe" for name in (*GATES, "calcium")),
        *(f"conductance_{name}_{layer}_probe" for name in CHANNELS),
    }
    for layer in ("longitudinal", "circular")
}
"""Outputs of a layer that there are with Plant's cell alone."""
OF_NETWORK = {"potential_network"}
"""Fields that there are with a network alone."""
CALCIUM = ("c", "calcium")
"""States that are a cell's calcium."""


def outputs_of_cell(layer: str, states: Sequence[str], channels: Sequence[str]) -> list[Output]:
    """Outputs of a layer whose cell has these states and channels, besides its potential; known from now on.

    Each state and the conductance of each channel at the probes, and calcium as a field where the cell has one.
    """
    found = [_gate_probe(layer, name, name, f"state {name}") for name in states]
    found += [_conductance_probe(layer, name, name) for name in channels]
    if layer == "network":
        return [OUTPUTS.setdefault(output.name, output) for output in (_potential_probe(layer), *found)]
    calcium = [name for name in states if name in CALCIUM]
    if calcium:
        found.append(OUTPUTS[f"calcium_{layer}"])
    return [OUTPUTS.setdefault(output.name, output) for output in found]


EVENTS = (
    Output("event_time", ("event",), "s", "time of an event", lambda event: event.time),
    Output("event_place", ("event",), "cm", "place of an event, distance from the oral end", lambda event: event.place),
    Output("event_kind", ("event",), "", "kind of an event", lambda event: event.kind),
    Output("event_words", ("event",), "", "what happened", lambda event: event.words),
)

WAVES = (
    Output("wave_layer", ("wave",), "", "layer of a wave", lambda found: found.layer),
    Output("wave_time", ("wave",), "s", "time at which a wave began", lambda found: found.wave.time),
    Output(
        "wave_start",
        ("wave",),
        "cm",
        "place where a wave began, from the oral end of the undeformed tube",
        lambda found: found.wave.start,
    ),
    Output(
        "wave_end",
        ("wave",),
        "cm",
        "place where a wave ended, from the oral end of the undeformed tube",
        lambda found: found.wave.end,
    ),
    Output(
        "wave_direction",
        ("wave",),
        "",
        "direction of a wave: antegrade, retrograde, standing or local",
        lambda found: found.wave.direction,
    ),
    Output(
        "wave_speed",
        ("wave",),
        "cm/s",
        "speed of a wave, positive towards the anal end",
        lambda found: found.wave.speed,
    ),
    Output(
        "wave_origin",
        ("wave",),
        "",
        "what a wave began with: a stimulus, or no stimulus (spontaneous)",
        lambda found: found.wave.origin,
    ),
)

CERTAIN = "certain"
"""Where a summary holds what `--certain` found; no number of the run itself, so no fingerprint sees it."""

OUTPUTS = {output.name: output for output in (*COORDINATES, *FIELDS, *ACTIVATION, *SCALARS, *PROBES, *EVENTS, *WAVES)}

SHIPPED = frozenset(OUTPUTS)  # what others register is in the results of who registers it
HOMES = {STEP: SCALARS, PROBE: PROBES, WALL: FIELDS, CELLS: FIELDS}
"""Dimensions of an output to the list that the recorders go through."""


def register(output: Output) -> Output:
    """Add an output to all runs begun from now on in this process; it is then in results, files and tables.

    Its dimensions say when `value` is called and what it returns: STEP a number after every step, PROBE an array
    (n_probes,) after every step, WALL or CELLS an array over the wall's nodes or the cells every `output.interval`.
    Raises ValueError if the name is taken or no name, or if it has other dimensions or no function.
    """
    if output.name in OUTPUTS or not output.name.isidentifier():
        raise ValueError(f"{output.name!r} is taken or no identifier; choose another name for the output")
    if output.dimensions not in HOMES or output.value is None:
        raise ValueError(
            f"output {output.name} needs a function and one of the dimensions STEP, PROBE, WALL, CELLS, not "
            f"{output.dimensions}"
        )
    HOMES[output.dimensions].append(output)
    OUTPUTS[output.name] = output
    return output


def forget(name: str) -> None:
    """Take an output out again; runs begun from now on do not have it. Raises KeyError if there is none."""
    output = OUTPUTS.pop(name)
    HOMES[output.dimensions].remove(output)
