"""C8, C9: pellets of other shapes: contact pressure from both curvatures, forces and work along a run.

Nothing here asks a shape for its normal or curvature: they are written anew. Kernels are those bound to the shape.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peristalsis.inputs.build import build
from peristalsis.inputs.shape import shape_of
from peristalsis.model.fields import contact_pressure, corner_tensions, nodal, stretch_of_elements
from peristalsis.model.model import Model
from peristalsis.model.state import State
from peristalsis.wall.membrane import TOTAL_CIRCULAR, TOTAL_LONGITUDINAL

from .exact.runs import EXACT, IDLE, configured
from .problem import Check, Outcome, Problem, error, judged, order

Floats = NDArray[np.float64]

BODIES: Mapping[str, dict[str, Any]] = {
    "spheroid 0.7": {"pellet.shape": "spheroid", "pellet.spheroid.aspect": 0.7},
    "spheroid 1.5": {"pellet.shape": "spheroid", "pellet.spheroid.aspect": 1.5},
    "capsule 18 x 30 mm": {"pellet.shape": "capsule", "pellet.capsule.length": "3 cm"},
}
ELEMENTS = (400, 600, 800, 1600)


def held(changes: Mapping[str, Any], elements: int) -> tuple[Model, State]:
    """The passive tube on the pellet in its middle, without smoothing and bending."""
    config = configured(EXACT, IDLE, changes, {"grid.n_z_wall": elements})
    shape = shape_of(config)
    config = config.with_changes({"pellet.start_gap": f"{0.5 * config.wall.length - shape.oral:.12g} cm"})
    model, state, _ = shape.binding.module("model.initial").initial_state(build(config))
    return model, state


def curvatures(label: str, radius: float, half: float, axial: float) -> tuple[float, float]:
    """Curvatures [1/cm] of the meridian and around the axis where a body's surface is `axial` from its middle."""
    if label.startswith("capsule"):
        return 0.0, 1.0 / radius
    angle = math.acos(axial / half)  # x = (R sin, b cos)
    stretched = math.sqrt((radius * math.cos(angle)) ** 2 + (half * math.sin(angle)) ** 2)
    return radius * half / stretched**3, half / (radius * stretched)


def pressure_on_shapes() -> Outcome:
    """q = T_m k_m + T_c k_h - p at the middle of the band and off it."""
    checks: list[Check] = []
    for label, changes in BODIES.items():
        sizes: list[float] = []
        errors: list[float] = []
        for elements in ELEMENTS:
            model, state = held(changes, elements)
            corners = corner_tensions(state.wall, model.wall)[:, :, 0]
            stretch = nodal(stretch_of_elements(state.wall.position, model.wall.element_size))[:, 0]
            q = contact_pressure(state.wall, model.wall)[:, 0]
            worst = 0.0
            for k in (elements // 2, elements // 2 + elements // 50):
                mean = 0.5 * (corners[k - 1, 1] + corners[k, 0])
                rho, axial = state.wall.position[k, 0, 0], state.wall.position[k, 0, 2] - state.pellet.position
                along, around = curvatures(label, model.pellet.radius, model.pellet.anal, axial)
                exact = mean[TOTAL_LONGITUDINAL] / (rho / model.wall.radius) * along
                exact += mean[TOTAL_CIRCULAR] / stretch[k] * around - state.pressure
                worst = max(worst, abs(float(q[k]) / exact - 1.0))
            sizes.append(model.wall.element_size)
            errors.append(worst)
        checks.append(error(f"{label}: q at {ELEMENTS[-1]} elements, relative", errors[-1], 1e-4))
        if errors[-1] > 1e-9:
            checks.append(order(f"{label}: of q in space", sizes, errors, 2.0))
    return judged("q = T_m κ_m + T_c κ_h − p", checks)


def forces_on_shapes() -> Outcome:
    """Along a run: end reactions against F_z, F_z by area, and the power balance."""
    checks: list[Check] = []
    for label, changes in BODIES.items():
        config = configured(changes)
        module = shape_of(config).binding.module
        model, state, _ = module("model.initial").initial_state(build(config))
        advance, summary = module("model.guards").advance_safely, module("model.step_summary").summary_of_step
        momentum = largest = residual = work = 0.0
        off: list[float] = []
        while state.step * model.dt_wall < 1.0:
            before = state
            state, _ = advance(model, before)
            found = summary(model, before, state)
            force = state.pellet.axial_force
            momentum, largest = max(momentum, abs(found.momentum.residual)), max(largest, abs(force))
            residual, work = residual + found.work.residual, work + abs(found.work.active)
            q = contact_pressure(state.wall, model.wall)[:, 0]
            area = np.pi * state.wall.position[:, 0, 0] ** 2
            off.append(float(np.sum(0.5 * (q[1:] + q[:-1]) * np.diff(area))) - force)
        checks += [
            Check(f"{label}: largest force [mN]", largest, 100.0),
            error(f"{label}: momentum, over the largest force", momentum / largest, 1e-8),
            error(f"{label}: work, over that of the muscle", residual / work, 1e-3),
            error(f"{label}: F_z by area, root mean square", float(np.sqrt(np.mean(np.square(off)))) / largest, 5e-3),
        ]
    return judged(
        "F_z = F(anal) − F(oral) = ∫ q d(πρ²); work of the muscle = stored + lost",
        checks,
        "q and the places of the nodes are those stored; no normal enters.",
    )


PROBLEMS = (
    Problem(
        "C8", "Pressure on other shapes", "both curvatures of the body", "full", pressure_on_shapes, (12, 71, 73, 74)
    ),
    Problem("C9", "Forces on other shapes", "first law, axial balance", "full", forces_on_shapes, (29, 52, 70)),
)
