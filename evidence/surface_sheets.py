"""Sheets of the whole surface on coarse cells: fronts around the ring, a point source, what a step takes.

`python evidence/surface_sheets.py` writes docs/evidence/surface_sheets.md. A quarter of an hour on one core.
"""

from __future__ import annotations

import statistics
import sys
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from common import save_text, table
from numpy.typing import NDArray

from peristalsis import scenarios
from peristalsis.inputs.build import build
from peristalsis.model.initial import initial_state
from peristalsis.model.model import Model
from peristalsis.model.scheme import Ahead
from peristalsis.model.schemes.surface import conduction
from peristalsis.model.sheets import advance_layer
from peristalsis.model.state import SheetState, State
from peristalsis.model.stimulation import stimuli_of_step
from peristalsis.tissue.bidomain import Bidomain

Floats = NDArray[np.float64]

LENGTH, COLUMNS, ELEMENTS = 2.0, 16, 40
"""Of the tube [cm], and of its wall, which is held: the sheets alone are run."""
SECONDS, SHORT = 0.7, 0.2
"""Of tissue: for times of activation, and for what a step takes."""
TUBE = {
    "wall.length": f"{LENGTH} cm",
    "grid.n_z_wall": ELEMENTS,
    "grid.n_theta": COLUMNS,
    "pellet.enabled": False,
    "reflex.enabled": False,
    "trigger.rule": "pacemaker",
    "output.probes": ["1 cm"],
    "run.stop_position": "1.8 cm",
}
CORRECTED = {"tissue.front_correction": "measured"}
PSEUDO = {"tissue.bidomain": "pseudo"}
LOOSE = {"solver.elliptic_tolerance": 1e-4}
REFERENCE = (160, 1024, 0.5, "corrected", CORRECTED)
CASES = (
    (160, 1024, 0.5, "as it is", {}),
    (80, 256, 0.5, "as it is", {}),
    (80, 256, 0.5, "corrected", CORRECTED),
    (80, 256, 1.0, "corrected", CORRECTED),
    (80, 128, 1.0, "corrected", CORRECTED),
    (80, 64, 1.0, "corrected", CORRECTED),
    (80, 256, 1.0, "corrected, pseudo", CORRECTED | PSEUDO),
    (80, 128, 1.0, "corrected, pseudo", CORRECTED | PSEUDO),
)
COSTS = (
    (80, 512, 0.25, "as it is", {}),
    (80, 512, 1.0, "as it is", {}),
    (80, 256, 1.0, "corrected", CORRECTED),
    (80, 256, 1.0, "corrected, to 1e-4", CORRECTED | LOOSE),
    (80, 256, 1.0, "corrected, pseudo", CORRECTED | PSEUDO),
    (80, 128, 1.0, "corrected, to 1e-4", CORRECTED | LOOSE),
    (80, 128, 1.0, "corrected, pseudo", CORRECTED | PSEUDO),
)
SPREAD = 0.2
"""Of the stretches around the ring, where they vary."""
Case = tuple[int, int, float, str, dict[str, object]]


class Run(NamedTuple):
    """Activation of the longitudinal layer [s] at its cells, and what the sheet took."""

    model: Model
    sheet: SheetState
    active: Floats
    stages: int
    solves: int
    seconds: float


def prepared(case: Case, spread: float) -> tuple[Model, State, Ahead]:
    """Model and resting state of a case, and the wall that the sheets see."""
    n_z, n_theta, step, _, changes = case
    cells = {"grid.n_z": n_z, "grid.n_theta_conduction": n_theta, "step.conduction": f"{step} ms"}
    model = build(scenarios.configuration("point_pacemaker", changes=TUBE | cells | changes))
    model, state, _ = initial_state(model)
    around = 1.0 + spread * np.cos(model.grid.columns)
    axial, hoop = np.tile(around, (ELEMENTS, 1)), np.tile(around, (ELEMENTS + 1, 1))
    return model, state, Ahead(axial, float(axial.min()), hoop)


def run(case: Case, spread: float = 0.0, seconds: float = SECONDS, layer: str = "longitudinal") -> Run:
    """A layer driven from a patch at the oral end, on a wall that is held."""
    print(case, spread, file=sys.stderr, flush=True)
    model, state, ahead = prepared(case, spread)
    part, sheet = getattr(model, layer), getattr(state, layer)
    operator = conduction(model, part, ahead)
    stages = len(model.stages(part, ahead.least, 0.0, operator.ring_rate))
    solves, spent = 0, []
    kept: list[Bidomain] = []
    make = Bidomain.__init__

    def noted(self: Bidomain, *given: object) -> None:
        make(self, *given)  # type: ignore[arg-type]
        kept.append(self)

    Bidomain.__init__ = noted  # type: ignore[method-assign]
    try:
        for step in range(round(seconds / model.dt_wall)):
            now = step * model.dt_wall
            state = replace(state, step=step, sources=followed(model, state, now))
            stimulus = getattr(stimuli_of_step(model, state, now, now + model.dt_wall), layer)
            begin = time.process_time()
            sheet = advance_layer(model, layer, part, sheet, ahead, stimulus, now)
            spent.append(time.process_time() - begin)
            solves += sum(one.solves for one in kept)
            kept.clear()
    finally:
        Bidomain.__init__ = make  # type: ignore[method-assign]
    return Run(model, sheet, 1e-3 * sheet.first_activation, stages, solves, statistics.median(spent) / model.dt_wall)


def followed(model: Model, state: State, now: float) -> tuple[object, ...]:
    """The sources in the coming step."""
    from peristalsis.control.pacemaker import follow

    return follow(model.sources, state.sources, now, now + model.dt_wall)


def at_places(found: Run, z: Floats, theta: Floats) -> Floats:
    """Activation at other places, linear along z and around; nan where a neighbour is not active."""
    grid, active = found.model.grid, found.active
    i = np.clip(z / grid.cell_size - 0.5, 0.0, grid.n_z - 1.001)
    j = theta / (2.0 * np.pi) * grid.n_theta_conduction
    low, left = i.astype(int), j.astype(int)
    a, b = (i - low)[:, None], (j - left)[None, :]
    right = (left + 1) % grid.n_theta_conduction
    left = left % grid.n_theta_conduction
    return np.asarray(
        (1 - a) * ((1 - b) * active[np.ix_(low, left)] + b * active[np.ix_(low, right)])
        + a * ((1 - b) * active[np.ix_(low + 1, left)] + b * active[np.ix_(low + 1, right)])
    )


def speed_around(found: Run) -> float:
    """Speed of the front around the ring at the oral end, from 50 to 85 degrees [cm/s]."""
    grid = found.model.grid
    row = np.argmin(np.abs(grid.cells - 0.1))
    here = (grid.cell_columns > np.radians(50.0)) & (grid.cell_columns < np.radians(85.0))
    times = found.active[row, here]
    if not np.isfinite(times).all():
        return float("nan")
    return float(np.polyfit(times, grid.cell_columns[here] * found.model.wall.radius, 1)[0])


def speed_along(found: Run) -> float:
    """Speed of the front along the tube on the driven side [cm/s]."""
    grid = found.model.grid
    here = (grid.cells > 0.9) & (grid.cells < 1.7)
    return float(np.polyfit(found.active[here, 0], grid.cells[here], 1)[0])


def compared(case: Case, found: Run, true: Run) -> list[object]:
    """A row: speeds over those of the reference, activation against it where that is active, work."""
    z, theta = np.linspace(0.2, 1.8, 60), np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
    here, there = at_places(found, z, theta), at_places(true, z, theta)
    active = np.isfinite(there) & (there < 0.9 * SECONDS)
    apart = 1e3 * (here - there)[active]
    met = np.isfinite(apart)
    return [
        f"{case[0]} × {case[1]}",
        case[2],
        case[3],
        speed_around(found) / speed_around(true),
        speed_along(found) / speed_along(true),
        float(np.sqrt(np.mean(apart[met] ** 2))),
        float(np.abs(apart[met]).max()),
        f"{100.0 * (1.0 - met.mean()):.0f} %",
        f"{found.model.substeps * found.stages}",
        found.solves / round(SECONDS / found.model.dt_wall),
    ]


HEAD = [
    *("cells", "step (ms)", "scheme", "speed around", "speed along", "activation, rms (ms)", "largest (ms)"),
    *("not reached", "stages a wall step", "solves a wall step"),
]


def cost(case: Case, first: Run, found: Run) -> list[object]:
    """A row: what a wall step of an uneven wall takes, and seconds of the processor over those of the first."""
    return [
        f"{case[0]} × {case[1]}",
        case[2],
        case[3],
        f"{found.model.substeps * found.stages}",
        found.solves / round(SHORT / found.model.dt_wall),
        found.seconds / first.seconds,
    ]


def page() -> str:
    """The whole page."""
    true = run(REFERENCE)
    rows = [compared(case, run(case), true) for case in CASES]
    short = [run(case, SPREAD, SHORT) for case in COSTS]
    costs = [cost(case, short[0], found) for case, found in zip(COSTS, short, strict=True)]
    return f"""# Sheets of the whole surface

Made by `python evidence/surface_sheets.py`.

## Fronts from a point

The longitudinal layer of a tube {LENGTH:g} cm long on a wall that is held at stretches of 1, driven over 60 degrees and
5 mm at the oral end as in `point_pacemaker`, for {SECONDS:g} s. Speeds and times of activation against the bidomain on
{REFERENCE[0]} × {REFERENCE[1]} cells with steps of {REFERENCE[2]} ms, corrected, which changes little there (the first
row is without it). *Corrected*: `tissue.front_correction = measured`; *pseudo*: `tissue.bidomain = pseudo`; *to 1e-4*:
`solver.elliptic_tolerance`. *Not reached*: of what the reference has active by nine tenths of the run.

{table(HEAD, rows)}
## What a wall step takes

The same for {SHORT:g} s on a wall whose stretches vary around the ring by ±{100 * SPREAD:.0f} %: stages of conduction,
solves of the elliptic problem, and seconds of the processor over those of the first row (medians over the steps).

{table([*HEAD[:3], *HEAD[-2:], "time"], costs)}"""


if __name__ == "__main__":
    save_text("surface_sheets.md", page())
