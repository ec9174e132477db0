"""One case in a process: what came of it, as a row of plain values. Nothing that happens there ends the bench."""

from __future__ import annotations

import io
import math
import time
import traceback
import warnings
from collections.abc import Callable, Mapping
from contextlib import redirect_stderr, redirect_stdout
from typing import Any

import numpy as np

from peristalsis import PeristalsisError, Simulation, configuration
from peristalsis.errors import ConfigurationError

from .plan import Case

Row = dict[str, Any]
Tell = Callable[[float], None]

LIMIT = 300.0
"""Processor seconds a run may take."""


class TooSlow(Exception):
    """A run has used up its processor time."""


def of_case(case: Case) -> Row:
    """What every row of a case says of it, whatever became of it."""
    return {
        "index": case.index,
        "group": case.group,
        "variant": case.variant,
        "key": case.key(),
        "scenario": case.scenario,
        "reading": case.reading,
        "changes": case.all_changes(),
    }


def carry_out(case: Case, limit: float = LIMIT, tell: Tell = lambda _: None) -> Row:
    """Run one case and return its row: `outcome` is one of finished, refused, diverged, too_slow, traceback."""
    row: Row = {
        **of_case(case),
        "outcome": "traceback",
        "stage": "configuration",
        "words": "",
    }
    begin = time.process_time()
    reached = [0.0]

    def progress(simulated: float, _: float) -> None:
        reached[0] = simulated
        tell(simulated)
        if time.process_time() - begin > limit:
            raise TooSlow

    said = io.StringIO()
    simulation: Simulation | None = None
    with warnings.catch_warnings(record=True) as caught, redirect_stderr(said), redirect_stdout(said):
        warnings.simplefilter("always")
        try:
            chosen = configuration(case.scenario, reading=case.reading, changes=case.all_changes())
            row |= {"digest": chosen.digest()[:16], "duration_s": chosen.run.duration, "stage": "start"}
            simulation = Simulation(chosen, progress=progress)
            row |= {"stage": "run", "start_cpu_s": time.process_time() - begin}
            result = simulation.run()
            row |= _measured(result)
            row["outcome"] = "finished" if row["status"] not in ("diverged", "interrupted") else str(row["status"])
            row["words"] = result.error or ""
        except TooSlow:
            row |= {"outcome": "too_slow", "words": f"used up {limit:g} s of processor time at t = {reached[0]:.4g} s"}
        except PeristalsisError as error:
            row |= {"outcome": "refused", "words": str(error)}
            if isinstance(error, ConfigurationError):
                row["stage"] = "configuration" if row["stage"] == "configuration" else row["stage"]
        except Exception:  # whatever it is, it is a row
            row |= {"outcome": "traceback", "words": traceback.format_exc()[-4000:]}
    cpu = time.process_time() - begin
    simulated = float(row.get("simulated_s", reached[0]) or 0.0)
    row |= {"cpu_s": round(cpu, 3), "simulated_s": simulated, "cpu_per_s": None}
    if row["outcome"] in ("finished", "too_slow") and simulated > 0.0:
        row["cpu_per_s"] = round((cpu - row.get("start_cpu_s", 0.0)) / simulated, 3)
    if simulation is not None and "remarks" not in row:
        row["remarks"] = [str(text) for text in getattr(simulation, "remarks", [])]
    row["warnings"] = sorted({f"{one.category.__name__}: {' '.join(str(one.message).split())[:200]}" for one in caught})
    row["said"] = said.getvalue()[-500:]
    return row


def _measured(result: Any) -> Row:
    """What the rules and the table need of a result."""
    arrays, summary = result.arrays, dict(result.summary)
    length = result.configuration.wall.length
    events: dict[str, int] = {}
    for kind in np.asarray(arrays["event_kind"]).tolist():
        events[str(kind)] = events.get(str(kind), 0) + 1
    row: Row = {
        "status": str(summary["status"]),
        "summary": summary,
        "remarks": [str(text) for text in result.remarks],
        "events": events,
        "event_words": sorted({str(words) for words in np.asarray(arrays["event_words"]).tolist()})[:20],
        "simulated_s": float(arrays["time_step"][-1]),
        "not_finite": not_finite(arrays),
        "length_cm": length,
    }
    place, wide = np.asarray(arrays["axial_position"]), np.asarray(arrays["radius"])
    row["bulge_cm"] = float(max(-np.nanmin(place), np.nanmax(place) - length))
    row["bulge_end"] = "oral" if -np.nanmin(place) > np.nanmax(place) - length else "anal"
    row["max_diameter_cm"] = 2.0 * float(np.nanmax(wide))
    row["min_diameter_cm"] = float(np.nanmin(arrays["min_diameter"]))
    row["newton_a_step"] = float(np.nanmean(arrays["newton_iterations"]))
    if result.configuration.pellet.enabled:
        from peristalsis.inputs.shape import shape_of

        centre, shape = np.asarray(arrays["pellet_position"]), shape_of(result.configuration)
        row |= {
            "oral_pole_cm": float(np.nanmin(centre)) - shape.oral,
            "oral_centre_cm": float(np.nanmin(centre)),
            "anal_pole_cm": float(np.nanmax(centre)) + shape.anal,
            "last_cm": float(centre[-1]),
        }
    return row


MAY_BE_NAN = (
    "activation_",
    "contact_start",
    "contact_end",
    "event_place",
    "momentum_residual",
    "smallest_gap",
    "theta",
    "wave_",
)
"""Outputs that are nan where there is nothing to tell."""


def not_finite(arrays: Mapping[str, Any]) -> list[str]:
    """Names of outputs that hold what is not finite and should be."""
    found = []
    for name, values in arrays.items():
        numbers = np.asarray(values)
        if numbers.dtype.kind != "f" or name.startswith(MAY_BE_NAN):
            continue
        if name.startswith("pellet_position") and np.isnan(numbers).all():  # no pellet
            continue
        if not np.isfinite(numbers).all():
            found.append(name)
    return found


# --- other ways ------------------------------------------------------------------------------------


def other_ways(case: Case, row: Row) -> list[Case]:
    """The same tube and drive by other means, for a case that was refused or broke off; runs end soon after t."""
    chosen = configuration(case.scenario, reading=case.reading, changes=case.all_changes())
    grid, step, solver = chosen.grid, chosen.step, chosen.solver

    def grids(factor: float) -> dict[str, str]:
        return {name: str(max(8, round(getattr(grid, key) * factor))) for name, key in GRIDS.items()}

    ends = {"run.duration": f"{step.wall:g} ms"}
    if row["stage"] == "run":
        ends = {"run.duration": f"{min(chosen.run.duration, row['simulated_s'] + BEYOND):.6g} s"}
    looser = min(1e-2, 100.0 * solver.residual_tolerance)
    ways = {"grids x 0.5": grids(0.5), "tolerance x 100": {"solver.residual_tolerance": f"{looser:.3g}"}}
    if row["stage"] == "run":
        ways["steps x 0.5"] = {
            "step.wall": f"{0.5 * step.wall:.8g} ms",
            "step.conduction": f"{0.5 * step.conduction:.8g} ms",
        }
    ways["grids x 2"] = grids(2.0)
    return [case.varied(name, {**changes, **ends}) for name, changes in ways.items()]


GRIDS = {"grid.n_z": "n_z", "grid.n_z_wall": "n_z_wall"}
BEYOND = 0.5
"""How far beyond the time at which a run broke off another way must get [s]."""


def second_opinion(case: Case, row: Row, limit: float, tell: Tell = lambda _: None) -> dict[str, str]:
    """Way to its outcome, until one gets through; none for what the configuration itself refuses."""
    if row["outcome"] not in ("refused", "diverged") or row["stage"] == "configuration":
        return {}
    found: dict[str, str] = {}
    for other in other_ways(case, row):
        tell(math.nan)
        tried = carry_out(other, limit, tell)
        found[other.variant] = tried["outcome"]
        if tried["outcome"] == "finished":
            break
    return found
