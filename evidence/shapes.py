"""Pellets of other shapes: forces and energy of each run told independently, transit against the aspect ratio.

Runs are marched through the kernels bound to each shape. Writes docs/evidence/shapes.md and shapes.png. About ten
minutes on one core, and two more for each shape whose kernels are not in the cache yet.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from common import FOLDER, save_text, table

from peristalsis.inputs.build import build
from peristalsis.inputs.shape import PelletShape, shape_of
from peristalsis.scenarios import configuration

RADIUS = 0.9
ASPECTS = (0.6, 0.7, 0.85, 1.0, 1.2, 1.5, 1.8, 2.2)
SMALL_TUBE = {"wall.radius": "0.486 cm"}
"""A tube that an 11 mm capsule stretches as much as the shipped pellet stretches the shipped tube."""
CAPSULE = {"pellet.shape": "capsule", "pellet.radius": "0.55 cm", "pellet.capsule.length": "2.6 cm"}
FIRST = 20
"""Steps that are not timed."""
CASES: dict[str, dict[str, Any]] = {
    "sphere": {},
    "spheroid 1": {"pellet.shape": "spheroid", "pellet.spheroid.aspect": 1.0},
    "spheroid 0.7": {"pellet.shape": "spheroid", "pellet.spheroid.aspect": 0.7},
    "spheroid 1.5": {"pellet.shape": "spheroid", "pellet.spheroid.aspect": 1.5},
    "stool 1.5, n = 3": {"pellet.shape": "stool", "pellet.stool.aspect": 1.5, "pellet.stool.exponent": 3.0},
    "capsule 11 x 26 mm, r0 = 4.86 mm": CAPSULE | SMALL_TUBE,
    "capsule 18 x 30 mm": {"pellet.shape": "capsule", "pellet.capsule.length": "3 cm"},
}


class March(NamedTuple):
    """A run: its shape, states, what was recorded after every step, when the pellet was expelled [s] or None.

    seconds: of processor time for a step."""

    shape: PelletShape
    model: Any
    states: list[Any]
    summaries: list[Any]
    transit: float | None
    seconds: float

    @property
    def momentum(self) -> float:
        """Largest residual of (52) over the largest axial force."""
        force = max(abs(state.pellet.axial_force) for state in self.states)
        return max(abs(one.momentum.residual) for one in self.summaries) / force

    @property
    def energy(self) -> float:
        """Sum of the residuals of (29) over the work of the muscle."""
        return abs(sum(one.work.residual for one in self.summaries)) / sum(
            abs(one.work.active) for one in self.summaries
        )

    @property
    def by_area(self) -> float:
        """Root mean square difference of F_z and int q d(pi rho^2) over the contact, over the largest F_z."""
        contact_pressure = self.shape.binding.module("model.fields").contact_pressure
        off, forces = [], []
        for state in self.states[1:]:
            pressure = contact_pressure(state.wall, self.model.wall)[:, 0]
            area = np.pi * state.wall.position[:, 0, 0] ** 2
            off.append(np.sum(0.5 * (pressure[1:] + pressure[:-1]) * np.diff(area)) - state.pellet.axial_force)
            forces.append(state.pellet.axial_force)
        return float(np.sqrt(np.mean(np.square(off))) / np.abs(forces).max())


def march(changes: Mapping[str, Any], duration: float = 6.0, elements: int = 200) -> March:
    """The baseline with these changes, until the pellet is expelled or `duration` [s]."""
    chosen = configuration("baseline", changes={"grid.n_z": 2 * elements, "grid.n_z_wall": elements, **changes})
    shape = shape_of(chosen)
    module = shape.binding.module
    advance, summary = module("model.guards").advance_safely, module("model.step_summary").summary_of_step
    passages = module("model.ends").passages
    model, state, _ = module("model.initial").initial_state(build(chosen))
    states, summaries, transit = [state], [], None
    begun, timed = time.process_time(), 0
    while transit is None and state.step * model.dt_wall < duration:
        before = state
        if len(states) == FIRST:  # what is compiled or loaded is by now
            begun, timed = time.process_time(), len(states)
        state, _ = advance(model, before)
        summaries.append(summary(model, before, state))
        states.append(state)
        transit = passages(model, before, state).anal
    return March(shape, model, states, summaries, transit, (time.process_time() - begun) / (len(states) - timed))


def checked() -> tuple[str, dict[str, March]]:
    """The table of checks, and its runs."""
    rows, runs = [], {}
    for label, changes in CASES.items():
        print(f"running {label} ...", file=sys.stderr, flush=True)
        run = runs[label] = march(changes)
        rows.append(
            [
                label,
                run.shape.volume,
                run.transit,
                run.states[-1].pellet.position,
                f"{run.momentum:.1e}",
                f"{run.energy:.1e}",
                f"{run.by_area:.1e}",
                f"{min(one.contact.smallest_gap for one in run.summaries):.1e}",
                1e3 * run.seconds,
            ]
        )
    head = [
        "pellet",
        "volume [cm³]",
        "transit [s]",
        "last place [cm]",
        "momentum (52)",
        "energy (29)",
        "force by area",
        "smallest gap [cm]",
        "ms a step",
    ]
    return table(head, rows), runs


def series() -> tuple[str, dict[str, list[float | None]]]:
    """Transit against the aspect ratio, at equal girth and at equal volume."""
    found: dict[str, list[float | None]] = {"equal girth": [], "equal volume": []}
    for aspect in ASPECTS:
        for kind in found:
            radius = RADIUS if kind == "equal girth" else RADIUS * aspect ** (-1.0 / 3.0)
            print(f"running aspect {aspect}, {kind} ...", file=sys.stderr, flush=True)
            changes = {
                "pellet.shape": "spheroid",
                "pellet.spheroid.aspect": aspect,
                "pellet.radius": f"{radius:.10g} cm",
            }
            found[kind].append(march(changes).transit)
    rows = [[aspect, *(found[kind][k] for kind in found)] for k, aspect in enumerate(ASPECTS)]
    return table(["aspect", *(f"{kind}: transit [s]" for kind in found)], rows), found


def picture(runs: Mapping[str, March], transits: Mapping[str, list[float | None]]) -> None:
    """The tube around each pellet at 1.2 s, and the transits."""
    from matplotlib.figure import Figure

    from peristalsis.plots import style

    with style.applied():
        figure = Figure(figsize=(9.0, 9.0), dpi=130, layout="constrained")
        grid = figure.subplots(4, 2)
        for axes, (label, run) in zip(grid.flat, runs.items(), strict=False):
            state = run.states[min(600, len(run.states) - 1)]
            z, rho = state.wall.position[:, 0, 2], state.wall.position[:, 0, 0]
            axial, radii = run.shape.outline()
            for side in (1.0, -1.0):
                axes.plot(z, side * rho, color=style.BLUE)
                axes.plot(axial + state.pellet.position, side * radii, color=style.BLACK)
            axes.set_aspect("equal")
            axes.set_title(f"{label}, t = {state.step * run.model.dt_wall:.1f} s", fontsize=9)
        axes = grid[3, 1]
        for kind, colour in (("equal girth", style.BLUE), ("equal volume", style.GREEN)):
            values = [np.nan if value is None else value for value in transits[kind]]
            axes.plot(ASPECTS, values, "o-", color=colour, label=kind)
        axes.set_xlabel("half length over girth radius")
        axes.set_ylabel("transit (s)")
        axes.legend()
        FOLDER.mkdir(parents=True, exist_ok=True)
        figure.savefig(FOLDER / "shapes.png")


def main() -> None:
    """Run everything and write the page."""
    checks, runs = checked()
    one, two = runs["sphere"], runs["spheroid 1"]
    apart = max(
        float(np.abs(a.wall.position[:, 0] - b.wall.position[:, 0]).max())
        for a, b in zip(one.states, two.states, strict=True)
    )
    transits, found = series()
    picture(runs, found)
    save_text(
        "shapes.md",
        f"""# Pellets of other shapes

Made by `python evidence/shapes.py`: the baseline on 400 cells and 200 elements, marched through the kernels bound to
each shape ([shapes](../shapes.md)). Girth radius 0.9 cm unless it says otherwise.

{checks}
- *momentum*: largest residual of (52), end reactions against the pellet's force, over the largest force.
- *energy*: sum of the residuals of (29) over the work of the muscle. First order in the step wherever friction sticks.
- *force by area*: the force on the pellet from the stored contact pressure and the places of the nodes alone,
  ∫ q d(πρ²) by the trapezoidal rule, against F_z; root mean square over the largest force, without a normal or a shape.
- Sphere and spheroid of ratio 1 find their distances in different ways; nodes are never further apart than
  {apart:.1e} cm.

## Transit against the aspect ratio

{transits}
At equal volume the girth radius is {RADIUS} cm × aspect^(−1/3); a slender pellet stretches the tube less. – means not
expelled within 6 s. The pellet starts with its oral pole in one place, so a longer one has a shorter way to go: from
half its length + 0.3 cm to the tube's length less half its length.

![Tubes around pellets (lengths in cm), and transits](shapes.png)
""",
    )


if __name__ == "__main__":
    main()
