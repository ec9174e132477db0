"""Method of lines, time: diagonally implicit Runge-Kutta steps of wall, contact, pressure and pellet as one DAE.

The wall without inertia is an implicit ODE in the places, contact (12) and the law of friction (27) are complementarity
conditions at every stage. Alexander's stiffly accurate, L-stable schemes of two or three stages; a semismooth Newton
method with coloured differences for the tangent, contact pressure q as an unknown of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_banded

from reference import mol_wall as wall
from reference.constants import Constants

# R. Alexander, SIAM J. Numer. Anal. 14 (1977) 1006: stiffly accurate, so the last stage is the new state.
TWO = 1.0 - 1.0 / np.sqrt(2.0)
THREE = 0.435866521508459
TABLEAUX = {
    1: np.array([[1.0]]),
    2: np.array([[TWO, 0.0], [1.0 - TWO, TWO]]),
    3: np.array(
        [
            [THREE, 0.0, 0.0],
            [(1.0 - THREE) / 2.0, THREE, 0.0],
            [-(6 * THREE**2 - 16 * THREE + 1) / 4.0, (6 * THREE**2 - 20 * THREE + 5) / 4.0, THREE],
        ]
    ),
}
CONTACT_WEIGHT = 1.0e4  # [mN/cm^3] weighs gap against q in the choice of the touching nodes only
TOLERANCE = 1.0e-7  # largest residual, over 10 mN/cm^2 (about p0), gaps over 1e-2 cm
ITERATIONS = 40


class Diverged(RuntimeError):
    """No step small enough converged."""


@dataclass(frozen=True)
class WallState:
    """Places and q at the nodes, pellet and pressure at one time."""

    place: np.ndarray
    contact: np.ndarray
    centre: float
    velocity: float
    pressure: float
    force: float
    speed: np.ndarray  # of the nodes, cm/s: the first guess of the next step


@dataclass(frozen=True)
class Setting:
    """What a solve holds fixed."""

    shell: wall.Shell
    h: float
    pellet_radius: float
    viscous: float
    dry: float
    exponent: float
    start_pressure: float
    start_volume: float
    held: bool


def shell_of(c: Constants) -> wall.Shell:
    """Constants of the compiled functions."""
    left, right = c.longitudinal, c.circular
    return wall.Shell(
        c.radius, c.viscosity, c.c1, c.c2, c.c3, c.c4, c.c5, c.c6, c.c10, c.published, c.blend, c.slope, c.fold_stretch,
        c.fold_tension, c.bending, c.bending_viscosity, left.c7, left.c8, left.c9, right.c7, right.c8, right.c9,
    )  # fmt: skip


def pellet_volume(radius: float) -> float:
    """Volume of the sphere [cm^3]."""
    return 4.0 / 3.0 * np.pi * radius**3


def solve_stage(
    s: Setting,
    first: WallState,
    speed: np.ndarray,
    base: np.ndarray,
    base_centre: float,
    lag: float,
    faces: np.ndarray,
    nodes: np.ndarray,
) -> tuple[WallState, np.ndarray]:
    """One implicit stage: places base + lag * rates in balance, from the guesses `first` and `speed`; the rates too."""
    n = base.shape[0] - 1
    inner = slice(1, n)
    unknowns = 3 * (n - 1)
    # The rates are the unknowns: the viscous tension then carries no rounding error of the places over a short step.
    contact = first.contact.copy()
    centre, pressure = first.centre, first.pressure
    band = np.zeros((17, unknowns))

    def law(force: float) -> tuple[float, float]:
        if s.held or not np.any(contact > 0.0):
            return 0.0, 0.0
        excess = abs(force) - s.dry
        return (np.sign(force) * excess / s.viscous, 1.0 / s.viscous) if excess > 0.0 else (0.0, 0.0)

    def gas(place: np.ndarray) -> tuple[float, float]:
        if s.exponent == 0.0:
            return s.start_pressure, 0.0
        volume = wall.lumen(place) - pellet_volume(s.pellet_radius)
        value = s.start_pressure * (s.start_volume / volume) ** s.exponent
        return value, -s.exponent * value / volume

    def merit(speed, contact, centre, pressure):
        """Residual rows, (touching), and their weighted norm; None out of bounds."""
        place = base + lag * speed
        out = np.zeros_like(place)
        if not wall.residual(place, speed, pressure, contact, faces, nodes, s.h, s.shell, out):
            return None
        gap = wall.gaps(place, centre, s.pellet_radius) if s.pellet_radius > 0.0 else np.full(n + 1, 1e9)
        touching = contact - CONTACT_WEIGHT * gap > 0.0
        rows = np.empty((n - 1, 3))
        rows[:, :2] = out[inner]
        rows[:, 2] = np.where(touching, gap, contact)[inner]
        force = wall.axial_force(place, contact, s.shell.radius)
        velocity, slope = law(force)
        equation = (centre - base_centre) / lag - velocity
        target, dgas = gas(place)
        scaled = np.concatenate(
            [
                rows[:, :2].ravel() / 10.0,
                np.where(touching[inner], rows[:, 2] / 1e-2, rows[:, 2] / 10.0),
                [equation, (pressure - target) / 10.0],
            ]
        )
        return rows, out, touching, force, velocity, slope, equation, pressure - target, dgas, scaled

    state = merit(speed, contact, centre, pressure)
    if state is None:
        raise Diverged("the guess is out of bounds")
    sizes = [np.inf, np.linalg.norm(state[-1])]
    for _ in range(ITERATIONS):
        rows, balance, touching, force, velocity, slope, equation, defect, dgas, scaled = state
        if np.max(np.abs(scaled)) < TOLERANCE:
            place = base + lag * speed
            return WallState(place, np.where(touching, contact, 0.0), centre, velocity, pressure, force, speed), speed
        place = base + lag * speed
        wall.tangent(
            place, speed, pressure, contact, faces, nodes, s.h, s.shell, lag, balance, centre, s.pellet_radius,
            touching, band,
        )  # fmt: skip
        right = np.zeros((unknowns, 3))
        right[:, 0] = -rows.ravel()
        hoop = place[inner, 0] / s.shell.radius / (2.0 * s.h)
        right[0::3, 1] = -hoop * (place[2:, 1] - place[:-2, 1])
        right[1::3, 1] = hoop * (place[2:, 0] - place[:-2, 0])
        distance = np.hypot(place[inner, 0], place[inner, 1] - centre)
        right[2::3, 2] = np.where(touching[inner], (place[inner, 1] - centre) / distance, 0.0)
        try:
            found = solve_banded((8, 8), band, right, check_finite=False)
        except np.linalg.LinAlgError:
            band[8, 2::3] += 1e-9  # a trace of compliance under contact, in the direction of the search only
            found = solve_banded((8, 8), band, right, check_finite=False)
        if not np.all(np.isfinite(found)):
            raise Diverged("the tangent is singular")
        # Border: rows of the pellet and of the gas, gradients of F_z and of the volume by place and q.
        gradient_force = np.zeros((n - 1, 3))
        qr = contact * place[:, 0] * np.pi
        gradient_force[:, 0] = np.pi * contact[inner] * (place[2:, 0] - place[:-2, 0])
        gradient_force[1:, 0] += qr[1 : n - 1]
        gradient_force[:-1, 0] -= qr[2:n]
        gradient_force[:, 2] = np.pi * place[inner, 0] * (place[2:, 0] - place[:-2, 0])
        gradient_volume = np.zeros((n - 1, 3))
        gradient_volume[:, 0] = np.pi * place[inner, 0] * (place[2:, 1] - place[:-2, 1])
        gradient_volume[:, 1] = 0.5 * np.pi * (place[:-2, 0] ** 2 - place[2:, 0] ** 2)
        by_force, by_volume = gradient_force.ravel() @ found, gradient_volume.ravel() @ found
        # unknowns of the border: δp, δZ; δ(places, q) = found0 + found1 δp + found2 δZ
        small = np.array(
            [
                [1.0 - dgas * by_volume[1], -dgas * by_volume[2]],
                [-slope * by_force[1], 1.0 / lag - slope * by_force[2]],
            ]
        )
        border = np.linalg.solve(small, [-defect + dgas * by_volume[0], -equation + slope * by_force[0]])
        change = (found[:, 0] + found[:, 1] * border[0] + found[:, 2] * border[1]).reshape(n - 1, 3)
        best = None
        allowed = max(sizes[-2:]) if np.isfinite(sizes[-2]) else 2.0 * sizes[-1]
        for length in (1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125):
            new_speed = speed.copy()
            new_speed[inner] += length / lag * change[:, :2]
            new_contact = contact.copy()
            new_contact[inner] += length * change[:, 2]
            kept, contact = contact, new_contact  # the law of friction looks at the contact of the trial
            trial = merit(new_speed, new_contact, centre + length * border[1], pressure + length * border[0])
            contact = kept
            if trial is None:
                continue
            size = np.linalg.norm(trial[-1])
            if best is None or size < best[0]:
                best = (size, length, new_speed, new_contact, trial)
            if size < allowed:
                break
        if best is None:
            raise Diverged("no trial within bounds")
        size, length, speed, contact, state = best
        centre += length * border[1]
        pressure += length * border[0]
        sizes.append(size)
    raise Diverged(f"{ITERATIONS} iterations leave a residual of {np.max(np.abs(state[-1])):.1e}")


def advance(s: Setting, before: WallState, dt: float, drives, stages: int, depth: int = 0) -> WallState:
    """One step of `dt` from `before`; `drives(fraction)` gives φ⁺ at faces and nodes within the step.

    A step that fails is cut in two, at most eight times over.
    """
    table = TABLEAUX[stages]
    rates, pellet_rates = [], []
    now = before
    try:
        for row in table:
            base, centre = before.place.copy(), before.centre
            for weight, rate, pellet_rate in zip(row, rates, pellet_rates, strict=False):
                base += dt * weight * rate
                centre += dt * weight * pellet_rate
            lag = dt * row[len(rates)]
            faces, nodes = drives(float(row.sum()))
            guess = rates[-1] if rates else before.speed
            first = replace(now, centre=centre + lag * now.velocity)
            now, speed = solve_stage(s, first, guess, base, centre, lag, faces, nodes)
            rates.append(speed)
            pellet_rates.append((now.centre - centre) / lag)
    except Diverged as error:
        if depth >= 8:
            raise Diverged(f"step of {dt:.1e} s: {error}") from None
        half = advance(s, before, dt / 2, lambda f: drives(f / 2), stages, depth + 1)
        return advance(s, half, dt / 2, lambda f: drives(0.5 + f / 2), stages, depth + 1)
    return now


def relaxed(s: Setting, state: WallState) -> WallState:
    """Static equilibrium without drive: backward Euler with growing steps."""
    n = state.place.shape[0] - 1
    faces, nodes = np.zeros(n), np.zeros(n + 1)
    for dt in (1e-3, 1e-2, 0.1, 1.0, 10.0, 1e3, 1e6, 1e6):
        at_rest = replace(state, speed=np.zeros((n + 1, 2)))
        state = advance(s, at_rest, dt, lambda _: (faces, nodes), 1)
    return replace(state, speed=np.zeros((n + 1, 2)))


def start(c: Constants, n: int) -> tuple[Setting, WallState, np.ndarray]:
    """Inflated tube with the pellet in it, at rest; the setting of the run; the pellet-free radii [cm]."""
    z = np.linspace(0.0, c.length, n + 1)
    centre = c.start_gap + c.pellet_radius
    state = WallState(
        np.column_stack([np.full(n + 1, c.radius), z]),
        np.zeros(n + 1),
        centre,
        0.0,
        c.pressure,
        0.0,
        np.zeros((n + 1, 2)),
    )
    s = Setting(shell_of(c), c.length / n, 0.0, c.viscous_friction, c.dry_friction, 0.0, c.pressure, 1.0, True)
    state = relaxed(s, state)
    free = state.place[:, 0].copy()
    faces, nodes = np.zeros(n), np.zeros(n + 1)
    for radius in np.linspace(0.85 * c.pellet_radius, c.pellet_radius, 16):
        s = replace(s, pellet_radius=float(radius))
        at_rest = replace(state, speed=np.zeros((n + 1, 2)))
        state = advance(s, at_rest, 0.05, lambda _: (faces, nodes), 1)
    state = relaxed(s, state)
    volume = wall.lumen(state.place) - pellet_volume(c.pellet_radius)
    s = replace(s, exponent=c.exponent, start_volume=volume, held=False)
    return s, state, free
