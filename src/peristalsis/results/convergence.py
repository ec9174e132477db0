"""What makes the outcome of a run a matter of grid and step, read from the run itself: sentences for the user.

Each sign was checked against runs on doubled grids and with halved steps (docs/evidence/converged.md). None of them
says how wrong a run is: `--certain` does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..inputs.config import Configuration
from ..inputs.preflight import ACCEPTED, error_laws, expected_error, foot_length
from ..inputs.shape import shape_of
from ..model.inflation import LOPSIDED
from ..model.model import ACTIVATION_LEVEL, Model

Floats = NDArray[np.float64]

RECEPTOR_MARGIN = 0.02
"""The receptors' threshold is near where the pellet's girth meets it within this share."""
FORCE_MARGIN = 0.1
"""A pellet whose largest force and dry friction differ by less than this share is near the threshold of moving."""
END_MARGIN = 0.02
"""A pellet that leaves, or is about to leave, within this share of the duration: its status depends on the duration."""
MOVED = 0.05
"""Travel [cm] of a pellet that has been moved."""
LEFT_SPEED = 0.1
"""Share of its largest speed below which a pellet that is not expelled counts as left behind."""
PARTS_SHARE = 0.02
"""Share of the wall's steps made in parts beyond which a run is hard going."""
USUAL_ITERATIONS = 4.0
"""Iterations of the wall in a step, as 84 random runs needed them: a mean of 2 to 9.5."""
MANY = 3.0
"""Times the usual iterations beyond which a run says so."""
EARLIER = 0.02
"""Time by which a cell fires before its neighbours on both sides where a wave begins [s]."""
APART = 0.3
"""Distance over which neighbours are looked at [cm]."""

CERTAIN_HINT = "compare with --certain"


def start_remarks(model: Model) -> list[str]:
    """What the start of a run already shows: a lopsided tube, receptors at their threshold."""
    found = []
    apart = np.abs(model.free_radius - model.free_radius[::-1])
    if apart.max() > LOPSIDED:
        found.append(
            f"start: the inflated tube is lopsided, though nothing in it is (its pellet-free radius and that of its "
            f"mirror image differ by up to {10.0 * apart.max():.2g} mm): the pressure lengthens it beyond its clamped "
            "rings, there is more than one equilibrium, and grid and rounding chose this one; lower lumen.pressure or "
            "stiffen the passive wall, and take no number from this run"
        )
    if model.trigger.gate.kind == "stretch" and model.pellet.present and model.reflex.enabled:
        found += _closed_gate(model)
    if model.pellet.present and model.reflex.enabled:
        threshold = model.reflex.threshold
        beyond = model.pellet.radius / float(np.median(model.free_radius)) - threshold
        if abs(beyond) < RECEPTOR_MARGIN * threshold:
            side = "above" if beyond > 0.0 else "below"
            found.append(
                f"near a threshold: the pellet stretches the receptors to {100.0 * abs(beyond) / threshold:.2g} % "
                f"{side} reflex.threshold = {threshold:g}; whether they discharge depends on grid and step: "
                f"{CERTAIN_HINT}"
            )
    return found


def _closed_gate(model: Model) -> list[str]:
    """Whether the pellet is too narrow to stretch any receptor; its girth stays a radius off the clamped rings."""
    nodes, reach = model.grid.nodes, model.pellet.radius
    inner = model.free_radius[(nodes >= nodes[0] + reach) & (nodes <= nodes[-1] - reach)]
    if inner.size == 0 or reach > model.reflex.threshold * inner.min():
        return []
    return [
        f"trigger.gate = stretch: the pellet is {reach / float(inner.min()):.4g} times as wide as the pellet-free tube "
        f"where that is narrowest, and reflex.threshold = {model.reflex.threshold:g}; the gate never opens"
    ]


def remarks(configuration: Configuration, arrays: Mapping[str, Any], summary: Mapping[str, Any]) -> list[str]:
    """What the run shows of itself when it is over; empty for a run whose outcome grid and step hardly touch."""
    found = [
        *_spontaneous(configuration, arrays),
        *_stretched_front(configuration, arrays),
        *_hard_going(configuration, arrays),
    ]
    if configuration.pellet.enabled:
        found += [*_threshold(configuration, arrays), *_left_behind(configuration, arrays, summary)]
        found += _end_decides(configuration, arrays, summary)
    return found


# --- tissue ---------------------------------------------------------------------------------------


def _spontaneous(configuration: Configuration, arrays: Mapping[str, Any]) -> list[str]:
    """Waves of the longitudinal layer that no pacemaker started: only the graded reflex starts that layer besides."""
    if configuration.grid.n_theta > 1 or "input_changed" in arrays["event_kind"]:
        return []  # a front may go around the ring, and what drove the tissue before is not known any more
    if configuration.reflex.kind == "graded" and configuration.reflex.longitudinal_intensity > 0.0:
        return []  # the reflex starts this layer too, wherever the pellet is
    place = _own_source(configuration, arrays)
    if place is not None:
        where = f"at z = {place:.2g} cm"
    else:
        upstrokes, driven = _most_upstrokes(arrays), _drives(configuration, float(arrays["time_step"][-1]))
        if driven is None or upstrokes <= driven:
            return []
        where = f"{upstrokes} upstrokes at a probe for {driven} pulses"
    return [
        f"the tissue fires by itself ({where}): when and where depends on grid and step in detail, so a single run is "
        f"one of many; look at statistics over many runs, or {CERTAIN_HINT}"
    ]


def _own_source(configuration: Configuration, arrays: Mapping[str, Any]) -> float | None:
    """Where the longitudinal layer fired before its surroundings, away from every stimulus [cm]; None if nowhere."""
    z = arrays["z_cell"]
    first = arrays["activation_longitudinal"][:, 0]
    if not np.isfinite(first).any():
        return None
    known = np.where(np.isfinite(first), first, np.inf)
    reach = max(2, round(APART / float(z[1] - z[0])))
    p = configuration.pacemaker
    own = [one for one in configuration.stimuli if one.layer == "longitudinal"]
    driven = np.zeros(z.size, dtype=bool)
    paced = [] if p.kind == "none" else [(p.place, p.place + p.width)]
    for low, high in paced + [(one.low, one.high) for one in own]:
        driven |= (z >= low - APART) & (z <= high + APART)
    if not driven.any():
        return float(z[np.argmin(known)])
    for k in range(z.size):
        if driven[k] or not np.isfinite(known[k]):
            continue
        low, high = max(0, k - reach), min(z.size, k + reach + 1)
        if known[k] > known[low:high].min():
            continue
        before = known[low] if k > low else np.inf
        after = known[high - 1] if k < high - 1 else np.inf
        if min(before, after) - known[k] > EARLIER:
            return float(z[k])
    return None


def _most_upstrokes(arrays: Mapping[str, Any]) -> int:
    """Largest number of upstrokes of the longitudinal layer at any probe."""
    potential = arrays["potential_longitudinal_probe"]
    if potential.size == 0:
        return 0
    above = potential > ACTIVATION_LEVEL
    return int((above[1:] & ~above[:-1]).sum(axis=0).max())


def _drives(configuration: Configuration, until: float) -> int | None:
    """Pulses of pacemaker and stimuli up to a time [s]; None where a cell of its own rhythm or a protocol drives."""
    p = configuration.pacemaker
    if p.kind == "cell" or any(key.startswith("pacemaker.") for key in configuration.protocols):
        return None
    listed = sum(one.layer == "longitudinal" and one.onset <= until for one in configuration.stimuli)
    if p.kind == "none" or until < p.onset:
        return listed
    return listed + (1 if p.kind == "pulse" else min(p.count, 1 + math.floor((until - p.onset) / p.period)))


def _stretched_front(configuration: Configuration, arrays: Mapping[str, Any]) -> list[str]:
    """Whether grids that do for the undeformed wave are coarse for it where the wall is stretched.

    A wall stretched lambda times conducts 1/lambda as well, so the foot is shorter by the root of that, Eq. (30).
    """
    found = []
    length = configuration.wall.length
    times, z = arrays["time"], arrays["z_cell"]
    stretch = _stretch(arrays)
    middles = 0.5 * (arrays["z"][1:] + arrays["z"][:-1])
    for layer, part in (("longitudinal", configuration.longitudinal), ("circular", configuration.circular)):
        if not part.conduction:
            continue
        first = arrays[f"activation_{layer}"][:, 0]
        reached = np.flatnonzero(np.isfinite(first))
        if reached.size < 3:
            continue
        frame = np.clip(np.searchsorted(times, first[reached], side="right") - 1, 0, times.size - 1)
        element = np.clip(np.searchsorted(middles, z[reached]), 0, middles.size - 1)
        there = stretch[frame, element]
        foot = foot_length(configuration, layer)
        for key, count, law, _ in error_laws(configuration):
            flat = expected_error(length / count, foot, law)
            error = flat * float(np.mean(there ** (0.5 * law[2])))
            if flat <= ACCEPTED < error:
                needed = math.ceil(count * (error / ACCEPTED) ** (1.0 / law[2]))
                found.append(
                    f"{key} = {count}: the {layer} wave ran over wall stretched to {float(np.mean(there)):.2f} on the "
                    f"mean, where its foot is shorter than on the undeformed tube; expect about {error:.1g} % of error "
                    f"in its speed, and use {needed} or more for {ACCEPTED:g} %"
                )
    return found


def _stretch(arrays: Mapping[str, Any]) -> Floats:
    """Longitudinal stretch of the elements at the stored times, by the first column: (n_times, n_z_wall)."""
    rho, zeta = arrays["radius"][:, :, 0], arrays["axial_position"][:, :, 0]
    size = float(arrays["z"][1] - arrays["z"][0])
    stretch: Floats = np.hypot(np.diff(rho, axis=1), np.diff(zeta, axis=1)) / size
    return stretch


# --- pellet ---------------------------------------------------------------------------------------


def _threshold(configuration: Configuration, arrays: Mapping[str, Any]) -> list[str]:
    """A pellet that hardly moved, or hardly did not."""
    force, dry = np.abs(arrays["axial_force"]), np.abs(arrays["dry_force"])
    position = arrays["pellet_position"]
    friction = configuration.pellet.dry_friction * configuration.pellet.static_friction_factor
    if configuration.pellet.friction_coefficient > 0.0:
        friction = max(friction, float(dry.max()))
    largest = float(force.max())
    if friction <= 0.0 or largest <= 0.0:
        return []
    margin = largest / friction - 1.0
    if abs(margin) >= FORCE_MARGIN:
        return []
    moved = float(position.max() - position.min()) > MOVED
    return [
        f"near a threshold: the largest force on the pellet, {largest:.4g} mN, and the dry friction, {friction:.4g} "
        f"mN, are within {100.0 * abs(margin):.2g} % of one another; whether {'it moves on' if moved else 'it moves'} "
        f"depends on grid and step: {CERTAIN_HINT}"
    ]


def _left_behind(configuration: Configuration, arrays: Mapping[str, Any], summary: Mapping[str, Any]) -> list[str]:
    """A pellet that was carried some way and then left: where it stays is decided while the ring slips over it."""
    if summary["transit_s"] is not None:
        return []
    time, position = arrays["time_step"], arrays["pellet_position"]
    if float(position.max() - position[0]) < MOVED:
        return []
    speed = np.abs(arrays["pellet_velocity"])
    fastest = int(np.argmax(speed))
    slow = np.flatnonzero(speed[fastest:] < LEFT_SPEED * speed[fastest])
    if slow.size == 0:
        return []
    k = fastest + int(slow[0])
    return [
        f"the wave left the pellet behind at t = {time[k]:.3g} s, z = {position[k]:.3g} cm: how far it is carried is "
        f"decided while the ring slips over it, and depends on grid and step; {CERTAIN_HINT}"
    ]


def _end_decides(configuration: Configuration, arrays: Mapping[str, Any], summary: Mapping[str, Any]) -> list[str]:
    """Whether the pellet leaves depends on how long the run is."""
    duration, transit = configuration.run.duration, summary["transit_s"]
    if transit is not None:
        if transit < (1.0 - END_MARGIN) * duration:
            return []
        return [
            f"the pellet was expelled at {transit:.4g} s, just before the end of the run at {duration:g} s: lengthen "
            "run.duration before comparing with other runs, which may not get there in time"
        ]
    goal = configuration.wall.span - shape_of(configuration).anal
    left = goal - float(arrays["pellet_position"][-1])
    coming = float(arrays["pellet_velocity"][-1]) * END_MARGIN * duration
    if summary["status"] != "in_transit" or not 0.0 <= left <= coming:
        return []
    return [
        f"the run ended when the pellet was {10.0 * left:.2g} mm from being expelled: lengthen run.duration before "
        "comparing with other runs"
    ]


# --- solver ---------------------------------------------------------------------------------------


def _hard_going(configuration: Configuration, arrays: Mapping[str, Any]) -> list[str]:
    """Whether many steps had to be made in parts, or the wall took far more iterations than usual."""
    iterations = arrays["newton_iterations"][1:]
    if iterations.size == 0:
        return []
    kinds = np.asarray(arrays["event_kind"], dtype=object)
    cut = int(np.sum(kinds == "step_halved")) + int(np.sum(iterations > configuration.solver.max_newton))
    mean = float(np.mean(iterations))
    if cut > PARTS_SHARE * iterations.size:
        return [
            f"{cut} of {iterations.size} steps had to be made in parts ({mean:.2g} iterations a step, usual are "
            f"{USUAL_ITERATIONS:g}): the wall is close to having no equilibrium and its path depends on the step, "
            f"which also makes the run slow; lower step.wall, or {CERTAIN_HINT}"
        ]
    if mean > MANY * USUAL_ITERATIONS:
        return [
            f"the wall took {mean:.2g} iterations a step where {USUAL_ITERATIONS:g} are usual, so the run took about "
            f"{mean / USUAL_ITERATIONS:.2g} times as long as others: much of it folds, or goes slack and taut in every "
            f"step; lower step.wall, or {CERTAIN_HINT}"
        ]
    return []
