"""One implicit step of the wall on the whole surface: from states to `surface_equilibrium` and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.surface import from_frames, rates_from_frames, rates_to_frames, to_frames
from ..numerics.rates import RateFormula, carried_on, rate_formula
from ..numerics.ring_blocks import pad
from ..pellet.friction import held_by_ends, sliding_velocity
from ..pellet.surface_contact import force_on_pellet, measure_contact, no_contact
from ..wall.constants import SurfaceConstants
from ..wall.surface import measure_edges, new_edges
from ..wall.surface_mixed import tensions_of_state
from ..wall.surface_regularisers import patch_shear
from .equilibrium import CONVERGED, OUT_OF_RANGE, ROUNDED, History, Limits, Step, Unknowns, solve_equilibrium
from .friction import friction_ahead
from .model import Model
from .scheme import Solved
from .state import PelletState, WallState
from .surface_equilibrium import Sideways, SurfaceProblem, SurfaceVerdict, merit_of, solve_surface
from .surface_mixed import solve_mixed

Floats = NDArray[np.float64]

UNIFORM = 1e-6
"""Share of its largest value by which drive or wall may vary around the ring and the step be one of the ring."""


@dataclass(frozen=True)
class Kinematics:
    """Stretches of a surface: of the edges along z (n - 1, m), around (n, m), and the shear of patches (n - 1, m)."""

    stretch: Floats
    hoop: Floats
    shear: Floats


def kinematics(model: Model, places: Floats) -> Kinematics | None:
    """Stretches and shear at places (n, 3, m); None when one is out of range."""
    n, _, m = places.shape
    padded, edges, shear = np.empty((n, 3, m + 2)), new_edges(n, m), np.empty((n - 1, m))
    pad(places, padded)
    if not measure_edges(padded, model.wall, edges):
        return None
    patch_shear(padded, model.wall, shear)
    return Kinematics(edges.stretch[:, 1:-1].copy(), edges.hoop[:, 1:-1].copy(), shear)


def try_surface_wall(
    model: Model,
    wall: WallState,
    pellet: PelletState,
    pressure: float,
    drive: Floats,
    dt: float,
    surface: SurfaceConstants,
    sideways_friction: float | None = None,
    mean_first: bool = True,
) -> tuple[int, Solved | None]:
    """One implicit step `dt` [s]; None with the reason's code (`equilibrium.REASONS`) when it does not converge.

    drive: (2, 2 n_z_wall, n_theta) [mV] at the end of the step. The pellet moves across the axis only if
    `sideways_friction` [mN s/cm] is given, by backward Euler. mean_first: begin with the axisymmetric step of the mean
    around the ring where that is nearer to the solution; it changes the way there and not the solution.
    """
    formula = rate_formula(dt, wall.step_before, model.second_order)
    places, before = to_frames(wall.position), to_frames(wall.position_before)
    velocity = rates_to_frames(wall.position, wall.velocity)
    velocity_before = rates_to_frames(wall.position_before, wall.velocity_before)
    now, past = kinematics(model, places), kinematics(model, before)
    if now is None or past is None:
        return OUT_OF_RANGE, None
    history = formula.history(places, before)
    varies = _varies(places, drive)
    mixed = varies and model.mixed_newton
    # Carried on with their rates alone, places are nearer to the solution where wall goes slack and taut.
    trend = 1.0 if mixed else carried_on(dt, wall.step_before)
    guess = places + dt * (trend * velocity - (trend - 1.0) * velocity_before)
    guess[[0, -1]] = places[[0, -1]]  # the clamped ends, to the last bit
    density = wall.contact.copy()
    dry, weight = friction_ahead(model, wall, pellet)
    second = model.second_order and wall.step_before > 0.0
    pellet_history = pellet.position + (0.5 * dt * pellet.velocity if second else 0.0)
    pellet_weight = 0.5 * dt if second else dt
    scalars = np.array([pressure, pellet.position + dt * pellet.velocity, pellet.axial_force])
    aside = None
    if sideways_friction is not None:
        aside = Sideways(sideways_friction, *pellet.across, dt)
        scalars = np.concatenate([scalars, pellet.across])
    problem = SurfaceProblem(
        history=history,
        velocity_history=formula.history(velocity, velocity_before),
        stretch_history=formula.history(now.stretch, past.stretch),
        hoop_history=formula.history(now.hoop, past.hoop),
        shear_history=formula.history(now.shear, past.shear),
        drive=np.ascontiguousarray(drive),
        friction_weight=weight,
        step=Step(formula.inverse, model.inertia, pellet_history, pellet_weight),
        wall=model.wall,
        surface=surface,
        pellet=model.pellet._replace(dry=dry),
        lumen=model.lumen,
        sideways=aside,
        tolerance=model.surface_tolerance if varies else model.tolerance,
        gap_tolerance=model.gap_tolerance,
        max_iterations=model.max_newton,
        modes=model.coupled_modes if varies else 0,
    )
    if mixed:
        tensions = _tensions(model, wall, now)
        verdict = solve_mixed(guess, density, scalars, tensions, problem)
    else:
        if mean_first:
            guess, density, scalars = _better_guess(model, problem, formula, places, before, guess, density, scalars)
        verdict = solve_surface(guess, density, scalars, problem)
    if verdict.code != CONVERGED:
        return verdict.code, None
    return CONVERGED, _state_after(model, wall, problem, verdict, guess, density, scalars, drive, dt)


def _varies(places: Floats, drive: Floats) -> bool:
    """Whether wall or drive vary around the ring by more than rounding and noise."""

    def spread(field: Floats) -> float:
        return float(np.ptp(field, axis=2).max()) / float(np.abs(field).max(initial=1e-300))

    return spread(drive) > UNIFORM or spread(places) > UNIFORM


def _tensions(model: Model, wall: WallState, now: Kinematics) -> Floats:
    """Tensions before the floor at the start of a step, (2, 4 n_z_wall, m)."""
    n, m = now.hoop.shape
    carried = np.empty((2, 4 * (n - 1), m))
    rates = (np.ascontiguousarray(wall.stretch_rate), np.ascontiguousarray(wall.hoop_rate))
    tensions_of_state(now.stretch, now.hoop, *rates, np.ascontiguousarray(wall.drive), model.wall, carried)
    return carried


def _better_guess(
    model: Model,
    problem: SurfaceProblem,
    formula: RateFormula,
    places: Floats,
    before: Floats,
    guess: Floats,
    density: Floats,
    scalars: Floats,
) -> tuple[Floats, Floats, Floats]:
    """The guess moved by what the axisymmetric solver makes of its mean around the ring, if its merit is lower.

    On a ring-uniform wall this is the solution. Slack wall and the front of the wave make Newton's method search, and
    the search is a hundred times cheaper on one column.
    """

    def mean(field: Floats) -> Floats:
        return np.ascontiguousarray(field[:, [0, 2]].mean(axis=2).T)

    def stretch(profile: Floats) -> Floats:
        return np.asarray(np.hypot(*np.diff(profile, axis=1)) / model.wall.element_size)

    start, now, past, history = mean(guess), mean(places), mean(before), mean(problem.history)
    rho, zeta = start[0].copy(), start[1].copy()
    contact, axial = density.mean(axis=1), scalars[:3].copy()
    hoop = history[0] / model.wall.radius
    verdict = solve_equilibrium(
        Unknowns(rho, zeta, contact, axial),
        History(history, mean(problem.velocity_history), formula.history(stretch(now), stretch(past)), hoop),
        np.ascontiguousarray(problem.drive.mean(axis=2)),
        problem.friction_weight.sum(axis=1),
        problem.step,
        model.wall,
        problem.pellet,
        model.lumen,
        Limits(model.tolerance, model.gap_tolerance, model.max_newton),
    )
    if verdict.code not in (CONVERGED, ROUNDED):
        return guess, density, scalars
    moved = guess.copy()
    moved[:, 0] += (rho - start[0])[:, None]
    moved[:, 2] += (zeta - start[1])[:, None]
    pressed = np.maximum(density + (contact - density.mean(axis=1))[:, None], 0.0)
    found = np.concatenate([axial, scalars[3:]])
    merit = merit_of(moved, pressed, found, problem)
    if merit <= problem.tolerance or merit < merit_of(guess, density, scalars, problem):
        return moved, pressed, found
    return guess, density, scalars


def _state_after(
    model: Model,
    wall: WallState,
    problem: SurfaceProblem,
    verdict: SurfaceVerdict,
    places: Floats,
    density: Floats,
    scalars: Floats,
    drive: Floats,
    dt: float,
) -> Solved:
    slope = problem.step.slope
    velocity = (places - problem.history) * slope
    velocity[[0, -1]] = 0.0
    position = from_frames(places)
    position[[0, -1]] = wall.position[[0, -1]]
    new = kinematics(model, places)
    assert new is not None, "a converged state is within range"
    after = WallState(
        position=position,
        position_before=wall.position,
        velocity=rates_from_frames(places, velocity),
        velocity_before=wall.velocity,
        contact=density,
        stretch_rate=(new.stretch - problem.stretch_history) * slope,
        hoop_rate=(new.hoop - problem.hoop_history) * slope,
        drive=drive,
        step_before=dt,
    )
    x, y = (float(scalars[3]), float(scalars[4])) if problem.sideways is not None else (0.0, 0.0)
    moved = _move_pellet(model, problem, places, density, velocity, (x, y, float(scalars[1])))
    return Solved(after, moved, float(scalars[0]), verdict.iterations, verdict.assemblies, 1, verdict.krylov)


def _move_pellet(
    model: Model,
    problem: SurfaceProblem,
    places: Floats,
    density: Floats,
    velocity: Floats,
    centre: tuple[float, float, float],
) -> PelletState:
    """Velocity from the stored contact by the friction law, and the position that goes with it, Eqs. (13), (34)."""
    x, y, z = centre
    if not model.pellet.present:
        return PelletState(z, 0.0, 0.0)
    n, _, m = places.shape
    found = no_contact(n, m)
    measure_contact(places, density, x, y, z, model.pellet.shape, found)
    area = 2.0 * np.pi * model.wall.radius / m * model.wall.element_size
    _, _, force = force_on_pellet(density, found.normal, area)
    sliding, _ = sliding_velocity(force, model.pellet.viscous, problem.pellet.dry)
    drift = model.pellet.frame * float((problem.friction_weight * velocity[:, 2]).sum())
    velocity_now = sliding + drift
    place = problem.step.pellet_history + problem.step.pellet_weight * velocity_now
    if held_by_ends(place, model.pellet.lowest, model.pellet.highest):
        place, velocity_now = min(max(place, model.pellet.lowest), model.pellet.highest), 0.0
    return PelletState(
        place,
        velocity_now,
        force,
        problem.pellet.dry,
        (x, y),
    )
