"""What the explicit scheme of the paper costs, and what it costs at the error of the default.

Writes docs/evidence/explicit.md. About five minutes on one core. Times are of the processor; the ratios travel.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from common import save_text, table

import peristalsis as ps
from peristalsis.inputs.build import build
from peristalsis.model.explicit.limits import limits
from peristalsis.model.initial import initial_state
from peristalsis.model.model import Model
from peristalsis.model.state import State
from peristalsis.model.step import advance

EXPLICIT = {"solver.integrator": "explicit", "step.conduction": "0.125 ms"}
PRINTED = {"wall.surface_density": "26.14 g/cm^2"}
FINEST = {"grid.n_z": 2000, "grid.n_z_wall": 1600, "step.wall": "1 ms", "step.conduction": "0.125 ms"}
READ, HEAVY = "26.14 mg/cm2 (read)", "26.14 g/cm2 (printed)"
SHELLS = (100, 200, 400, 800)
COARSE = (100, 200, 400)
TIMED, TRIES = 4000, 5


def started(elements: int, density: dict[str, str]) -> tuple[Model, State]:
    """Model and state before t = 0."""
    changes = EXPLICIT | density | {"grid.n_z_wall": elements}
    model, state, _ = initial_state(build(ps.configuration("baseline", changes=changes)))
    return model, state


def cost_of_micro_step(model: Model, state: State) -> float:
    """Seconds that a micro-step of the wall takes, least of several pieces; the sheets' share is left out."""
    assert model.explicit is not None
    dt = 0.5 * limits(model, state).shell

    def clock(micro: int) -> float:
        piece = replace(model, dt_wall=dt * micro, substeps=1, explicit=model.explicit._replace(micro=micro))
        advance(piece, state)
        spent = []
        for _ in range(TRIES):
            begin = time.process_time()
            advance(piece, state)
            spent.append(time.process_time() - begin)
        return min(spent)

    return (clock(TIMED) - clock(TIMED // 4)) / (0.75 * TIMED)


def counts() -> tuple[list[tuple[object, ...]], dict[tuple[str, int], float]]:
    """Rows of the table of costs, and seconds for a second of simulated time by density and elements."""
    rows, seconds = [], {}
    for elements in SHELLS:
        each = cost_of_micro_step(*started(elements, PRINTED))
        for label, density in ((HEAVY, PRINTED), (READ, {})):
            model, state = started(elements, density)
            found, scheme = limits(model, state), model.explicit
            assert scheme is not None
            step = scheme.safety * found.shell
            seconds[label, elements] = each / step
            rows.append(
                (
                    elements,
                    label,
                    f"{found.dashpot:.2e}",
                    f"{found.wave:.2e}",
                    f"{found.pellet:.2e}",
                    f"{step:.2e}",
                    f"{1.0 / step:.2e}",
                    1e6 * each,
                    1e9 * each / (elements + 1),
                    each / step,
                )
            )
    return rows, seconds


def main() -> None:
    """Measure, run, and write the page."""
    rows, seconds = counts()
    finest_heavy = ps.run("baseline", FINEST | PRINTED | {"wall.inertia": True})
    finest = ps.run("baseline", FINEST)

    def error(result: ps.Result, limit: ps.Result) -> float:
        """Largest distance of the track from that of the finest grids, in percent of the travel."""
        ends = (result.arrays["time_step"][-1], limit.arrays["time_step"][-1])
        moment = np.linspace(0.0, min(ends), 4001)
        one, other = (np.interp(moment, r.arrays["time_step"], r.arrays["pellet_position"]) for r in (result, limit))
        return 100.0 * float(np.abs(one - other).max()) / float(limit.summary["travel_cm"])

    def timed(changes: dict[str, object]) -> tuple[ps.Result, float]:
        """A run and its processor time [s], records included, kernels compiled before."""
        begin = time.process_time()
        result = ps.run("baseline", changes)
        return result, time.process_time() - begin

    runs: list[tuple[object, ...]] = []
    for elements in COARSE:
        same = {"grid.n_z": 2000, "grid.n_z_wall": elements}
        pairs = (
            ("explicit, printed mass", EXPLICIT | PRINTED | same, finest_heavy),
            ("implicit, printed mass", PRINTED | same | {"wall.inertia": True}, finest_heavy),
            ("implicit, no inertia", same, finest),
        )
        for label, changes, limit in pairs:
            result, took = timed(changes)
            runs.append((elements, label, result.summary["transit_s"], error(result, limit), took))
    default, default_took = timed({})
    transit = float(default.summary["transit_s"])
    told = []
    for label in (HEAVY, READ):
        total = seconds[label, SHELLS[-1]] * transit
        told.append((label, total, total / 3600.0, f"{total / default_took:.2g}"))
    head = (
        "wall elements",
        "mass",
        "dashpot limit (s)",
        "wave and contact limit (s)",
        "pellet limit (s)",
        "step at 0.9 (s)",
        "steps for a second",
        "µs for a step",
        "ns for a step and node",
        "seconds for a second, wall alone",
    )
    text = "# The explicit scheme: cost\n\nMade by `python evidence/explicit.py`; Eqs. (53)-(57). Baseline, `tight`.\n"
    text += "\n## A micro-step\n\nLimits at t = 0 and the cost of a step, **measured**; the last column is cost times "
    text += "number.\n\n" + table(head, rows)
    text += "\n## On equal grids\n\n2000 conduction cells, **measured**. Error: largest distance of the pellet's track "
    text += "from that at 1600 elements\n(same mass), over the travel. Explicit and implicit share their elements, and "
    text += "so their error.\n\n"
    text += table(("wall elements", "scheme", "transit (s)", "error of the track (%)", "processor time (s)"), runs)
    text += f"\n## At the error of the default\n\nOn its 800 elements. The default run (transit {transit:.4g} s, "
    text += (
        f"{error(default, finest):.2g} % from the finest without inertia) takes {default_took:.2g} s, **measured**.\n"
    )
    text += (
        "The explicit run there is **extrapolated**: the measured cost of a step times the steps until expulsion, wall "
    )
    text += "alone.\n\n" + table(("mass", "time (s)", "time (h)", "over the default's time"), told)
    text += (
        "\nThe implicit wall's step is bound by accuracy, 2 ms; the explicit one's by the dashpots, with the square of "
    )
    text += "the element.\n"
    save_text("explicit.md", text)


if __name__ == "__main__":
    main()
