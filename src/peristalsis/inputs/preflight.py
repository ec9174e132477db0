"""What can be said of a run before it starts: grids, steps, the force of the muscle, memory and disk."""

from __future__ import annotations

import math
import os
import shutil
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ConfigurationError, DivergenceError, shown
from ..model.ends import BULGE, bulges
from ..model.explicit.limits import Limits
from ..model.model import Layer, Model
from ..model.state import State
from ..numerics.roots import find_root
from ..tissue.resolution import columns_for_speed, front_foot, relative_front_speed
from . import asked
from .build import build, diffusivity
from .config import Configuration
from .consistency import output_size
from .parts import SHIPPED
from .regions import varies_around

MEASURED_DIFFUSIVITY, MEASURED_SPEED, MEASURED_RATE = 0.0873, 4.2, 0.125
"""Wave that the error laws below were measured on: cm^2/s, cm/s, and tissue.kinetics_rate."""

CELL_ERROR = (3.3, 0.96, 4.0)
"""Cells of 0.96 foot lengths change the transit by 3.3 %, with the fourth power of their size."""
THREE_POINT_ERROR = (1.3, 0.48, 2.5)
"""Cells of the explicit scheme of 0.48 foot lengths slow the wave by 1.3 %, with the power 2.5 of their size."""
ELEMENT_ERROR = (1.5, 1.2, 2.0)
"""Wall elements of 1.2 foot lengths change it by 1.5 %, with the second power."""
CORRECTED_CELL_ERROR = (1.6, 1.6, 3.5)
"""Cells of 1.6 foot lengths change it by 1.6 % where fronts are corrected and fields reconstructed, Eqs. (85)-(88)."""
RECONSTRUCTED_ELEMENT_ERROR = (0.4, 1.2, 3.2)
"""Wall elements of 1.2 foot lengths change it by 0.4 % where fields are reconstructed."""
MEASURED_RANGE = 5.0
"""Beyond this [%] the laws are no longer those that were measured, and the warning names no number."""
ACCEPTED = 1.0
"""Error of either grid beyond which a run warns [%]; the shipped grids make 0.2 and 0.4 %."""


def foot_length(configuration: Configuration, layer: str) -> float:
    """Length over which the foot of a layer's wave rises e-fold, D/c [cm], scaled from the measured wave.

    Infinite where the layer's cells are not Plant's, whose wave was measured: nothing is foreseen of others.
    """
    if configuration.cell_of(layer) != SHIPPED["cell"]:
        return math.inf
    part = configuration.longitudinal if layer == "longitudinal" else configuration.circular
    spread = diffusivity(configuration, part, configuration.capacitance_of(layer)) / MEASURED_DIFFUSIVITY
    pace = configuration.tissue.kinetics_rate / MEASURED_RATE
    return MEASURED_DIFFUSIVITY / MEASURED_SPEED * math.sqrt(spread / pace)


def error_laws(configuration: Configuration) -> tuple[tuple[str, int, tuple[float, float, float], str], ...]:
    """Key and count of both grids along z, the law of the error that they make, and what they are made of."""
    cells, elements = CELL_ERROR, ELEMENT_ERROR
    if configuration.solver.integrator == "explicit":
        cells = THREE_POINT_ERROR
    elif configuration.grid.exchange == "reconstructed" and configuration.grid.n_theta == 1:
        elements = RECONSTRUCTED_ELEMENT_ERROR
        if configuration.tissue.front_correction == "measured":
            cells = CORRECTED_CELL_ERROR
    return (
        ("grid.n_z", configuration.grid.n_z, cells, "conduction cells"),
        ("grid.n_z_wall", configuration.grid.n_z_wall, elements, "wall elements"),
    )


def expected_error(size: float, foot: float, law: tuple[float, float, float]) -> float:
    """Error of the transit [%] that cells or elements of this size [cm] make, by a measured law."""
    percent, reference, order = law
    return percent * (size / (reference * foot)) ** order


END_LAYER_ELEMENTS = 1.3
"""Wall elements longer than this many end lengths warn; the shipped ones have 1.12, twice coarser ones 2.24."""

PEAK = 50.0
"""No action potential of the shipped cells rises above this [mV]; the highest seen in any scenario is 42."""

SHARE_OF_MEMORY = 0.5
"""Share of the machine's memory that the records of a run may take without a remark."""


def end_length(model: Model, stretch: float = 1.0) -> float | None:
    """Length [cm] over which the passive tube at rest forgets its clamped end: shape decays as exp(-Z/length).

    From the equations of a uniform tube at pressure p0 and a longitudinal stretch, linearised, without bending:
    l^2 = (N_l/lambda_l) / (A - B_l B_c / N_ll) with A = (N_cc - N_c/lambda_c)/R^2, B_l = (N_lc - N_c/lambda_l)/R,
    B_c = (N_cl - N_c/lambda_l)/R, where N are the tensions that the wall carries, smoothed and in its convention,
    Eqs. (14), (15) and (35). None where the tube is slack along z, or has no stable state.
    """
    wall, pressure = model.wall, model.lumen.pressure
    nominal_tensions = model.binding.module("wall.membrane").nominal_tensions

    def tensions(hoop: float) -> tuple[float, float, float, float, float, float]:
        found: tuple[float, float, float, float, float, float] = nominal_tensions(
            stretch, hoop, 0.0, 0.0, 0.0, 0.0, 0.0, wall
        )
        return found

    def excess(hoop: float) -> float:
        return float(tensions(hoop)[1] - pressure * wall.radius * stretch * hoop)

    high = 1.0
    while excess(high) <= 0.0:
        high += 0.05
        if high > 4.0:
            return None
    hoop = find_root(excess, 1.0, high) if excess(1.0) < 0.0 else 1.0
    along, around, n_ll, n_lc, n_cl, n_cc = tensions(hoop)
    radial = (n_cc - around / hoop) / wall.radius**2
    coupling = (n_lc - around / stretch) * (n_cl - around / stretch) / wall.radius**2
    stiffness = radial - coupling / n_ll if n_ll > 0.0 else 0.0
    return math.sqrt(along / stretch / stiffness) if along > 0.0 and stiffness > 0.0 else None


def largest_pull(model: Model) -> float:
    """A force on the pellet [mN] that its muscle cannot exceed: both layers fully active at their best stretch.

    The longitudinal layer pulls on the whole circumference, 2 pi r0 N_l, at no more than its undeformed length, for
    its ends are held; the ring squeezes the pellet out by at most pi R N_c, at no more than the pellet's girth.
    """
    pellet, wall = model.pellet, model.wall
    active_tension = model.binding.module("wall.active").active_tension

    def best(muscle: Any, layer: Layer, longest: float) -> float:
        tension = max(active_tension(float(stretch), muscle)[0] for stretch in np.linspace(0.2, longest, 200))
        drive = layer.activation.kernels.largest_drive(PEAK, layer.activation_constants)
        return float(np.max(layer.force_factor)) * drive * tension

    along = best(wall.longitudinal, model.longitudinal, 1.0)
    girth = max(pellet.radius / wall.radius, 1.0)
    around = best(wall.circular, model.circular, girth)
    return 2.0 * math.pi * wall.radius * along + math.pi * pellet.radius * around


def remarks(configuration: Configuration) -> list[str]:
    """Warnings before a run, with its inputs as they are at t = 0; none for the shipped settings."""
    said = asked.remarks(configuration)
    configuration = configuration.at_start()
    model = build(configuration)
    found = [*_unseen_regions(configuration), *_around(configuration, model)]
    found += [*_grids(configuration), *_end_layer(configuration, model), *_steps(model)]
    return [*said, *found, *_forces(configuration, model), *_memory(configuration)]


def disk_remarks(configuration: Configuration, folder: Path) -> list[str]:
    """A warning if the disk of a folder has no room for a result of a run and its two checkpoints, uncompressed."""
    place = folder.absolute()
    while not place.exists() and place != place.parent:
        place = place.parent
    needed, free = 3.0 * output_size(configuration), shutil.disk_usage(place).free
    if needed <= free:
        return []
    return [
        f"{shown(str(place))} has {free / 1e9:.2g} GB free, and the run may take {needed / 1e9:.2g} GB with its "
        "checkpoints; make room, or lengthen output.interval"
    ]


def remarks_of_start(configuration: Configuration, state: State) -> list[str]:
    """Whether the inflated tube bulges over its clamped rings before anything happens."""
    oral, anal = (float(part[0]) for part in bulges(state.wall.position[None, :, :, 2], configuration.wall.span))
    worst = max(oral, anal)
    if worst <= BULGE * configuration.wall.radius:
        return []
    widest = float(state.wall.position[:, :, 0].max())
    return [
        f"lumen.pressure = {configuration.lumen.pressure:g} kPa: the inflated tube, {2.0 * widest:.2g} cm wide, bulges "
        f"{worst:.2g} cm over its clamped rings of {2.0 * configuration.wall.radius:.2g} cm; read nothing from its "
        "shape near the ends, or lower the pressure"
    ]


def _memory(configuration: Configuration) -> list[str]:
    needed = 2.0 * output_size(configuration)  # once while it is recorded, once more when it is put together
    there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if needed <= SHARE_OF_MEMORY * there:
        return []
    return [
        f"output.interval = {configuration.output.interval:g} s: the records will take about {needed / 1e9:.2g} GB of "
        f"this machine's {there / 1e9:.2g} GB of memory; lengthen the interval or shorten the run"
    ]


def _end_layer(configuration: Configuration, model: Model) -> list[str]:
    """Whether wall elements are short enough for the shape of the passive tube near its ends and its pellet."""
    length, size = end_length(model), model.grid.element_size
    if length is None:
        return [
            f"lumen.pressure = {configuration.lumen.pressure:g} kPa: the wall at rest carries no tension along the "
            "tube, so its shape near ends and pellet is set by the regularisers (bending, slack) alone; raise the "
            "pressure, or do not read anything from that shape"
        ]
    if size <= END_LAYER_ELEMENTS * length:
        return []
    needed = math.ceil(model.grid.length / (END_LAYER_ELEMENTS * length))
    return [
        f"grid.n_z_wall = {configuration.grid.n_z_wall}: wall elements of {10.0 * size:.2g} mm are coarse for the "
        f"passive wall, whose shape near its ends changes over {10.0 * length:.2g} mm; use {needed} or more"
    ]


def check_explicit_step(configuration: Configuration, model: Model, state: State) -> None:
    """Refuse an explicit step beyond the stability limit of the inflated tube with its pellet, Eq. (57).

    The limit may still fall in a run, where the wall shortens or widens; the guards watch for that.
    """
    given = configuration.step.explicit
    allowed = model.binding.module("model.explicit.limits").limits(model, state)
    if given * 1e-3 <= allowed.least:
        return
    least = 1e3 * configuration.solver.explicit_safety * allowed.least
    raise ConfigurationError(
        f"step.explicit = {given:g} ms exceeds {1e3 * allowed.least:.4g} ms, the explicit scheme's limit of stability "
        f"at t = 0, Eq. (57) ({allowed.words()}); use at most {least:.3g} ms, 0 to have it chosen, or "
        "solver.integrator = implicit"
    )


@dataclass(frozen=True)
class Effort:
    """What an explicit run will take: its limits at t = 0, the micro-step [s], their number, seconds for each."""

    limits: Limits
    step: float
    count: float
    seconds: float

    def words(self) -> str:
        """In a line, for the user."""
        total = self.count * self.seconds
        shown_time = f"{total:.2g} s" if total < 100.0 else f"{total / 60.0:.2g} min"
        if total >= 7200.0:
            shown_time = f"{total / 3600.0:.2g} h"
        return (
            f"explicit steps of {1e3 * self.step:.3g} ms (limits at t = 0: {self.limits.words()}): up to "
            f"{self.count:.2g} of {1e6 * self.seconds:.2g} us, about {shown_time} on this machine"
        )


TIMED = 2000
"""Micro-steps that are timed to foresee a run."""


def expected_effort(configuration: Configuration, model: Model, state: State) -> Effort:
    """Time a short piece of an explicit run, to say beforehand how long all of it would take if it ran to its end."""
    scheme, allowed = model.explicit, model.binding.module("model.explicit.limits").limits(model, state)
    if scheme is None:
        raise ValueError("the model has no explicit scheme: set solver.integrator = explicit")
    dt_cell = model.dt_wall / model.substeps
    micro = scheme.micro or max(1, math.ceil(dt_cell / (scheme.safety * allowed.shell)))
    if micro > TIMED:  # a shorter step of conduction holds fewer: time that
        share = TIMED / micro
        piece = replace(model, dt_wall=dt_cell * share, substeps=1, explicit=scheme._replace(micro=TIMED))
    else:
        piece = model
    advance = model.binding.module("model.step").advance
    advance(piece, state)  # tables and memory are made in the first one
    begin = time.perf_counter()
    _, report = advance(piece, state)
    each = (time.perf_counter() - begin) / report.assemblies
    return Effort(allowed, dt_cell / micro, configuration.run.duration / dt_cell * micro, each)


def _steps(model: Model) -> list[str]:
    """Whether the explicit steps of both layers have enough stages on the undeformed tube."""
    if model.explicit is not None:  # they are made of as many parts as they need
        return []
    try:
        for layer in (model.longitudinal, model.circular):
            model.stages(layer, np.ones((model.grid.n_z_wall, model.grid.n_theta)))
    except DivergenceError as error:
        return [str(error)]
    return []


def _around(configuration: Configuration, model: Model) -> list[str]:
    """How much too slow a front runs around the ring on this many columns, where anything varies around it."""
    c, grid = configuration, model.grid
    driven_in_part = c.pacemaker.kind != "none" and c.pacemaker.angular_width < 360.0
    if not grid.is_surface or not (driven_in_part or varies_around(c.regions)):
        return []
    found = []
    for name, layer in (("longitudinal", model.longitudinal), ("circular", model.circular)):
        if not layer.conducts or layer.cell.name != SHIPPED["cell"] or layer.front_corrected:
            continue
        g = layer.conductivities
        foot = front_foot(layer.diffusivity * g.effective_around / g.effective_axial, layer.constants.kinetics_rate)
        share = relative_front_speed(grid.column_width(model.wall.radius), foot)
        if share >= 1.0 - ACCEPTED / 100.0:
            continue
        columns = grid.n_theta * math.ceil(columns_for_speed(model.wall.radius, foot) / grid.n_theta)
        slow = f"runs {100.0 * (1.0 - share):.0f} % too slowly" if share > 0.0 else "does not pass from cell to cell"
        found.append(
            f"grid.n_theta_conduction = {grid.n_theta_conduction}: a front around the ring {slow} in the {name} layer "
            f"(undeformed); {columns} columns bring it within {ACCEPTED:g} %"
        )
    return found


def _forces(configuration: Configuration, model: Model) -> list[str]:
    """Whether any muscle force could overcome dry friction."""
    if not model.pellet.present:
        return []
    pull = largest_pull(model)
    if model.pellet.dry < pull:
        return []
    return [
        f"pellet.dry_friction = {configuration.pellet.dry_friction:g} mN: the muscle of this wall pulls with less than "
        f"{pull:.3g} mN at its best, so the pellet cannot move; lower the friction or strengthen the muscle"
    ]


def _grids(configuration: Configuration) -> list[str]:
    """Warnings about grids too coarse for the wave."""
    found = []
    length = configuration.wall.length
    conducting = [
        layer
        for layer, part in (("longitudinal", configuration.longitudinal), ("circular", configuration.circular))
        if part.conduction
    ]
    for key, count, law, what in error_laws(configuration):
        if not conducting:
            break
        foot = min(foot_length(configuration, layer) for layer in conducting)
        error = expected_error(length / count, foot, law)
        if error > ACCEPTED:
            needed = math.ceil(count * (error / ACCEPTED) ** (1.0 / law[2]))
            expected = f"about {error:.1g} %" if error < MEASURED_RANGE else "several per cent or more"
            found.append(
                f"{key} = {count}: {what} of {10.0 * length / count:.2g} mm are coarse for a wave whose foot is "
                f"{10.0 * foot:.2g} mm long; expect the transit to be off by {expected}. "
                f"Use {needed} or more for {ACCEPTED:g} %"
            )
    return found


def _unseen_regions(configuration: Configuration) -> list[str]:
    """Regions so small that no conduction cell has its centre in them."""
    import numpy as np

    from .regions.sampling import reached

    grid, wall = configuration.grid, configuration.wall
    z = (np.arange(grid.n_z) + 0.5) * wall.length / grid.n_z
    angle = 2.0 * np.pi * np.arange(grid.conduction_columns) / grid.conduction_columns
    return [
        f"region {region.name}: no conduction cell lies in it, so it has no effect; enlarge it, or raise grid.n_z or "
        "grid.n_theta_conduction"
        for region in configuration.regions
        if not reached(region, z, angle, wall.radius)
    ]
