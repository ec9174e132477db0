"""Why a tube finds no start: the cause that the last state on the way shows, how far it came, and what to change."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..numerics.roots import find_root
from ..wall.constants import WallConstants
from ..wall.membrane import LARGEST_STRETCH, nominal_tensions
from ..wall.passive import LIMIT, STIFFER_ALONG, STIFFER_AROUND, admissible, passive_tension, strain_energy
from .model import Model

Floats = NDArray[np.float64]

PLACES = 400
"""Stretches at which the wall's law is looked at."""
NEAR = 0.95
"""A stretch, or the square of a strain, above this share of its limit counts as at the limit."""
LARGEST_TENSION = 1e9
"""Hoop tension [mN/cm] from which rounding can be too large for a state of rest to be told."""
ALONG = "tension along the tube"
"""Words of causes that a wall stiffer along the tube would end."""
OVERHANG = 0.1
"""Share of r0 beyond its clamped ends from which a wall counts as swelling over them."""
NECK = 0.5
"""Circumferential stretch below which a ring counts as a neck."""


def largest_pressure(wall: WallConstants) -> tuple[float, float]:
    """(pressure [mN/cm^2], circumferential stretch) that a uniform passive tube at length 1 holds at most, Eq. (1).

    The largest T_c/rho over the stretches up to where the law is cut off.
    """
    stretches = np.linspace(1.0, trusted_stretch(wall), PLACES + 1)[1:]
    held = [held_pressure(wall, float(stretch)) for stretch in stretches]
    best = int(np.argmax(held))
    return held[best], float(stretches[best])


def held_pressure(wall: WallConstants, stretch: float) -> float:
    """Pressure [mN/cm^2] in a long passive tube at a circumferential stretch and longitudinal stretch 1, Eq. (1)."""
    return nominal_tensions(1.0, stretch, 0.0, 0.0, 0.0, 0.0, 0.0, wall)[1] / (wall.radius * stretch)


def hoop_tension(wall: WallConstants, radius: float) -> float:
    """Nominal passive hoop tension [mN/cm] of the wall around a radius [cm] at longitudinal stretch 1, Eq. (3)."""
    return nominal_tensions(1.0, radius / wall.radius, 0.0, 0.0, 0.0, 0.0, 0.0, wall)[1]


def trusted_stretch(wall: WallConstants) -> float:
    """Circumferential stretch at which the passive law ends, at longitudinal stretch 1."""
    low, high = 1.0, LARGEST_STRETCH
    if admissible(1.0, high, wall.passive):
        return high
    while high - low > 1e-12:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if admissible(1.0, middle, wall.passive) else (low, middle)
    return low


def of_pressure(model: Model, reached: float, state: tuple[Floats, Floats, Floats]) -> str:
    """The sentence of a tube that cannot be inflated.

    reached: largest pressure [mN/cm^2] at which it rests, minus infinity if at none. state: radius, axial place [cm]
    and speed [cm/s] of the nodes beyond that.
    """
    wall, pressure = model.wall, model.lumen.pressure
    most, stretch = largest_pressure(wall)
    cause = (
        f"a uniform tube of this wall, at its own length, holds at most {most / 100.0:.4g} kPa (at a circumferential "
        f"stretch of {stretch:.3g})"
        if pressure > most
        else _cause(model, state, pressure)
    )
    return (
        f"lumen.pressure = {pressure / 100.0:g} kPa: the tube finds no equilibrium, for {cause}; {_came(reached)}; "
        f"{_fix(cause)}"
    )


def of_pellet(model: Model, reached: float, state: tuple[Floats, Floats, Floats]) -> str:
    """The sentence of a tube that cannot hold its pellet. reached: largest radius [cm] of a pellet that rests in it."""
    wall, radius = model.wall, model.pellet.radius
    stretch = radius / wall.radius
    trusted = trusted_stretch(wall)
    tension = hoop_tension(wall, radius)
    if stretch > trusted:
        cause = f"its circumferential stretch of {stretch:.3g} is beyond {trusted:.3g}, where {LIMIT}"
    elif tension > LARGEST_TENSION:
        cause = (
            f"at its circumferential stretch of {stretch:.3g} the passive hoop tension is {tension:.2g} mN/cm, whose "
            "rounding outweighs the other forces"
        )
    else:
        cause = _cause(model, state, model.lumen.pressure)
    fix = "use a smaller pellet, a wider tube (wall.radius) or a higher lumen.pressure"
    if ALONG in cause:
        fix = f"use a smaller pellet, or {_fix(cause)}"
    return (
        f"pellet.radius = {radius:g} cm: the tube cannot hold this pellet: no equilibrium beyond a radius of "
        f"{max(reached, 0.0):.5g} cm on the way to pellet.radius = {radius:g} cm, for {cause}; {fix}"
    )


def _came(reached: float) -> str:
    if not np.isfinite(reached):
        return "it found none at lower pressures either"
    return f"at {reached / 100.0:.4g} kPa it still finds one"


def _cause(model: Model, state: tuple[Floats, Floats, Floats], pressure: float) -> str:
    """What the wall shows where it finds no rest."""
    wall, (rho, zeta, speed) = model.wall, state
    along = np.hypot(np.diff(rho), np.diff(zeta)) / wall.element_size
    around = rho / wall.radius
    worst = _at_the_end_of_the_law(wall, along, around)
    if worst is not None:
        return (
            f"at z = {zeta[worst]:.3g} cm its stretches, {along[worst]:.3g} along and {around[worst]:.3g} around the "
            f"tube, come to where {LIMIT}"
        )
    for name, values in (("longitudinal", along), ("circumferential", around)):
        worst = int(np.argmax(values))
        if values[worst] > NEAR * LARGEST_STRETCH:
            return f"the wall blows out: its {name} stretch passes {values[worst]:.3g} at z = {zeta[worst]:.3g} cm"
    outside = max(zeta[0] - float(zeta.min()), float(zeta.max()) - zeta[-1])
    if outside > OVERHANG * wall.radius:
        return (
            f"the {ALONG} is too small to hold the wall, which swells over its clamped ends (by "
            f"{outside:.2g} cm, and on)"
        )
    tension, stretch = resting_tension_along(model, pressure)
    narrow = int(np.argmin(around))
    where = f"at z = {zeta[narrow]:.3g} cm (circumferential stretch {around[narrow]:.2g})"
    if tension <= wall.slack_blend:
        return (
            f"at {pressure / 100.0:.3g} kPa the passive wall carries no {ALONG} ({tension:.2g} mN/cm at "
            f"a circumferential stretch of {stretch:.3g}, Eq. (3)) and slides into folds, the narrowest {where}"
        )
    if around[narrow] < NECK:
        return f"the wall slides into a neck {where}, which the {ALONG} does not prevent"
    fastest = int(np.argmax(speed))
    return f"the wall keeps moving, by {speed[fastest]:.2g} cm/s at z = {zeta[fastest]:.3g} cm, in whatever step"


def _at_the_end_of_the_law(wall: WallConstants, along: Floats, around: Floats) -> int | None:
    """The element of largest energy among those whose strains, a little larger, would be beyond the passive law."""
    further = NEAR**-0.5
    energies: dict[int, float] = {}
    for e, stretch in enumerate(along):
        for hoop in (float(around[e]), float(around[e + 1])):
            if not admissible(1.0 + further * (stretch - 1.0), 1.0 + further * (hoop - 1.0), wall.passive):
                energies[e] = max(energies.get(e, -math.inf), strain_energy(stretch, hoop, wall.passive))
    return max(energies, key=lambda e: energies[e]) if energies else None


def resting_tension_along(model: Model, pressure: float) -> tuple[float, float]:
    """(T_l [mN/cm] of Eq. (3), circumferential stretch) of the long passive tube at a pressure and length 1."""
    wall = model.wall
    high = largest_pressure(wall)[1]
    stretch = 1.0
    if held_pressure(wall, 1.0) < pressure < held_pressure(wall, high):
        stretch = find_root(lambda value: held_pressure(wall, value) - pressure, 1.0, high)
    return float(passive_tension(1.0, stretch, wall.passive)[0]), stretch


def _fix(cause: str) -> str:
    if ALONG in cause:
        return f"lower the pressure, or let the wall resist along the tube ({STIFFER_ALONG}, wall.slack_slope)"
    return f"lower the pressure or stiffen the wall ({STIFFER_AROUND})"
