"""How sure a run is: the same run on the doubled grid, and with halved steps, and what they say otherwise.

A run that its neighbours contradict is not converged: its outcome belongs to the grid or the step, not to the model.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigurationError, DivergenceError, InterruptedRun
from ..inputs.config import Configuration
from ..names import CERTAIN
from ..results.result import UNFINISHED, Result
from .pool import Failure, carry_out
from .simulation import Simulation

Floats = NDArray[np.float64]

TABLE_FILE = "certain.csv"
"""The comparison, beside the result."""
LIMIT = 2.0
"""Largest change of transit or final position [%] between neighbours that agree."""
SELDOM = 1e4
"""Longest interval at which fields may be stored [s]."""
WORDS = {"grid": "doubled grid", "step": "halved steps"}
COLUMNS = (
    "run",
    "status",
    "transit_s",
    "final_position_cm",
    "max_axial_force_mN",
    "change_percent",
    "force_change_percent",
    "track_rms_cm",
    "error",
)


class Neighbour(NamedTuple):
    """What is kept of a run: its summary and its track (time [s], position [cm])."""

    summary: Mapping[str, Any]
    time: Floats
    position: Floats


def neighbours(configuration: Configuration) -> dict[str, Configuration]:
    """The same run on the doubled grid along the tube, and with halved steps.

    Raises ConfigurationError where one of them would be beyond what may be asked for.
    """
    grid, step = configuration.grid, configuration.step
    finer: dict[str, dict[str, Any]] = {
        "grid": {"grid.n_z": 2 * grid.n_z, "grid.n_z_wall": 2 * grid.n_z_wall},
        "step": {step.whole_key: f"{0.5 * step.whole!r} ms", "step.conduction": f"{0.5 * step.conduction!r} ms"},
    }
    if step.control == "error":
        finer["step"]["step.shortest"] = f"{0.5 * step.shortest!r} ms"
        finer["step"]["step.tolerance"] = f"{0.5 * step.tolerance!r} cm"
    if configuration.solver.integrator == "explicit" and step.explicit > 0.0:
        finer["step"]["step.explicit"] = f"{0.5 * step.explicit!r} ms"
    seldom = {"output.interval": f"{min(configuration.run.duration, SELDOM)!r} s"}  # fields are not compared
    made = {}
    for name, changes in finer.items():
        try:
            made[name] = configuration.with_changes(changes | seldom)
        except ConfigurationError as error:
            raise ConfigurationError(
                f"--certain: the neighbour with the {WORDS[name]} cannot be run: {error}"
            ) from None
    return made


def cost_words(configuration: Configuration, workers: int = 1) -> str:
    """What the neighbours will cost, in a line, to be said beforehand."""
    grid, step = configuration.grid, configuration.step
    explicit = configuration.solver.integrator == "explicit"
    more = "eight times or more" if explicit else "about four times"
    side = ", side by side" if workers > 1 else ""
    return (
        f"to be certain, the run is made again on {2 * grid.n_z} cells and {2 * grid.n_z_wall} elements, and with wall "
        f"steps of {0.5 * step.whole:g} ms: that costs {more} the run itself in addition{side}"
    )


def make_certain(result: Result, workers: int = 1, say: Callable[[str], None] | None = None) -> Result:
    """The same result with what its neighbours say under `certain` in its summary.

    workers: processes for them, 1 or 2. say: told in a line when a neighbour is done. A result that broke off is
    returned as it is. If the neighbours are interrupted the verdict says so, and the result stands.
    """
    if result.status in UNFINISHED:
        return result
    tasks = neighbours(result.configuration)
    found: dict[str, Neighbour | Failure] = {}
    try:
        for done in carry_out(tasks, _run, workers, retries=0):
            if not isinstance(done.value, Failure) and done.value.summary["status"] == InterruptedRun.status:
                raise KeyboardInterrupt
            found[done.key] = done.value
            if say is not None:
                say(f"{WORDS[done.key]}: {_outcome(done.value)}")
    except (KeyboardInterrupt, InterruptedRun):
        verdict: dict[str, Any] = {
            "agrees": None,
            "within_percent": None,
            "limit_percent": LIMIT,
            "sentence": "not known to be certain: the runs of its neighbours were interrupted",
            "runs": {},
        }
    else:
        verdict = compare(result, {name: found[name] for name in tasks})
    return replace(result, summary={**result.summary, CERTAIN: verdict})


def compare(result: Result, found: Mapping[str, Neighbour | Failure]) -> dict[str, Any]:
    """The verdict on a run: `agrees`, `within_percent`, `limit_percent`, `sentence`, and `runs` by neighbour."""
    own = kept_of(result)
    runs: dict[str, dict[str, Any]] = {}
    for name, other in found.items():
        if isinstance(other, Failure):
            runs[name] = {"status": "failed", "error": other.error, "change_percent": None}
            continue
        summary = other.summary
        runs[name] = {
            "status": summary["status"],
            "error": summary["error"],
            "transit_s": summary["transit_s"],
            "final_position_cm": summary["final_position_cm"],
            "max_axial_force_mN": summary["max_axial_force_mN"],
            "change_percent": change(own, other),
            "force_change_percent": _percent(own.summary["max_axial_force_mN"], summary["max_axial_force_mN"]),
            "track_rms_cm": _track_rms(own, other),
        }
    changes = [run["change_percent"] for run in runs.values()]
    known = [value for value in changes if value is not None]
    within = max(known) if len(known) == len(changes) else None
    agrees = within is not None and within <= LIMIT
    verdict = {"agrees": agrees, "within_percent": within, "limit_percent": LIMIT}
    return verdict | {"sentence": _sentence(own, found, runs, agrees, within), "runs": runs}


def kept_of(result: Result) -> Neighbour:
    """What is compared of a result."""
    return Neighbour(result.summary, result.arrays["time_step"], result.arrays["pellet_position"])


def change(own: Neighbour, other: Neighbour) -> float | None:
    """Change of the outcome [%]: of the transit if both expel the pellet, of its last position if neither does.

    Without a pellet, of the largest lumen pressure. None if they end in different ways.
    """
    if own.summary["status"] != other.summary["status"]:
        return None
    for key in ("transit_s", "final_position_cm", "max_lumen_pressure_kPa"):
        if own.summary[key] is not None and other.summary[key] is not None:
            return _percent(own.summary[key], other.summary[key])
    return None


def table_text(verdict: Mapping[str, Any], summary: Mapping[str, Any]) -> str:
    """The comparison as CSV: the run itself and each of its neighbours."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for name, row in ({"as asked": summary} | {WORDS[key]: run for key, run in verdict["runs"].items()}).items():
        values = [row.get(column) for column in COLUMNS[1:]]
        writer.writerow([name, *("" if value is None else value for value in values)])
    return out.getvalue()


def write_table(summary: Mapping[str, Any], folder: Path) -> None:
    """Put the table of a summary's verdict into a folder, if it has one."""
    verdict = summary.get(CERTAIN)
    if verdict is not None:
        (folder / TABLE_FILE).write_text(table_text(verdict, summary), encoding="utf-8")


def _run(configuration: Configuration) -> Neighbour:
    """One neighbour, in whatever process."""
    return kept_of(Simulation(configuration).run())


def _percent(own: float | None, other: float | None) -> float | None:
    if own is None or other is None:
        return None
    if own == other:
        return 0.0
    return 100.0 * abs(other - own) / abs(own) if own != 0.0 else math.inf


def _track_rms(own: Neighbour, other: Neighbour) -> float | None:
    if own.summary["final_position_cm"] is None:
        return None
    common = own.time <= other.time[-1]
    apart = np.interp(own.time[common], other.time, other.position) - own.position[common]
    return float(np.sqrt(np.mean(apart**2)))


def _outcome(one: Neighbour | Failure) -> str:
    if isinstance(one, Failure):
        return f"failed ({one.error})"
    summary = one.summary
    words = str(summary["status"]).replace("_", " ")
    if summary["status"] == DivergenceError.status:
        return f"{words} ({summary['error']})"
    if summary["transit_s"] is not None:
        return f"{words} at {summary['transit_s']:.4g} s"
    if summary["final_position_cm"] is not None:
        return f"{words} at {summary['final_position_cm']:.4g} cm"
    return words


def _sentence(
    own: Neighbour,
    found: Mapping[str, Neighbour | Failure],
    runs: Mapping[str, Mapping[str, Any]],
    agrees: bool,
    within: float | None,
) -> str:
    parts = ", ".join(
        f"{WORDS[name]} {run['change_percent']:.2g} %"
        for name, run in runs.items()
        if run["change_percent"] is not None
    )
    if agrees and within is not None:
        return f"certain: agrees with its neighbours within {within:.2g} % ({parts})"
    others = "; ".join(f"{WORDS[name]}: {_outcome(one)}" for name, one in found.items())
    return (
        f"NOT certain: the run does NOT agree with its neighbours within {LIMIT:g} % (as asked: {_outcome(own)}; "
        f"{others}): do not use it; refine grid.n_z, grid.n_z_wall and step.wall until they agree, or look for what "
        "makes the outcome a matter of chance"
    )
