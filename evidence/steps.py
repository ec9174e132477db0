"""Steps whose length follows their error, against fixed ones, in every scenario of one column.

Writes docs/evidence/steps.md; about half an hour on one core. Each run is made with the shipped fixed steps, with steps
by error, and with fixed steps of a quarter of the longest, which the two are compared with. The last table is the
scenario that depends on a few instants, at four tolerances, against steps of 0.5 ms.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from common import save_text, table

import peristalsis as ps
from peristalsis.scenarios import configuration, names

BY_ERROR = {"step.control": "error", "step.conduction": "1 ms", "trigger.timing": "within"}
QUARTER = {"step.control": "fixed", "step.wall": "2 ms", "step.conduction": "0.25 ms", "trigger.timing": "within"}
FINE = {**QUARTER, "step.wall": "0.5 ms"}
HANGING = "fig3f"
TOLERANCES = ("0.0025 cm", "0.005 cm", "0.01 cm", "0.02 cm")
FURTHER: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    "slow: viscous friction x 4": ("baseline", {"pellet.viscous_friction": "920 mN*s/cm", "run.duration": "8 s"}),
    "stick and slip: dry friction 700 mN": ("baseline", {"pellet.dry_friction": "700 mN", "run.duration": "8 s"}),
    "stick and slip: Coulomb 0.3": ("baseline", {"pellet.friction_coefficient": 0.3, "run.duration": "6 s"}),
    "spontaneous: fast calcium x 1.5, no pacemaker": (
        "baseline",
        {"longitudinal.fast_calcium": "0.015 mS/cm^2", "pacemaker.kind": "none", "run.duration": "6 s"},
    ),
    "left behind: viscous friction 1200": (
        "baseline",
        {"pellet.viscous_friction": "1200 mN*s/cm", "run.duration": "6 s"},
    ),
}


class Run(NamedTuple):
    """What is kept of a run: status, transit [s], track, processor seconds, parts and rejected tries."""

    status: str
    transit: float | None
    time: np.ndarray
    position: np.ndarray
    seconds: float
    parts: int
    rejected: int


def run(scenario: str, changes: Mapping[str, Any]) -> Run:
    """One run, with fields stored seldom."""
    begun = configuration(scenario, changes=dict(changes))
    simulation = ps.Simulation(begun.with_changes({"output.interval": f"{min(begun.run.duration, 1.0)!r} s"}))
    begin = time.process_time()
    result = simulation.run()
    seconds = time.process_time() - begin
    arrays = result.arrays
    return Run(
        result.status,
        result.summary["transit_s"],
        arrays["time_step"],
        arrays["pellet_position"],
        seconds,
        int(arrays["step_parts"].sum()),
        int(arrays["steps_rejected"].sum()),
    )


def compared(one: Run, with_: Run) -> tuple[float | None, float]:
    """By how much the transit differs [%], and the track, rms over the common time [mm]."""
    change = None
    if one.transit is not None and with_.transit is not None:
        change = 100.0 * (one.transit / with_.transit - 1.0)
    until = min(one.time[-1], with_.time[-1])
    common = with_.time[with_.time <= until]
    track = np.interp(common, one.time, one.position) - with_.position[: common.size]
    return change, 10.0 * float(np.sqrt(np.mean(track**2)))


def cases() -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Label, scenario and changes of every run of one column."""
    for name in sorted(names()):
        begun = configuration(name)
        if begun.grid.n_theta == 1 and begun.solver.integrator == "implicit":
            yield name, name, {}
    for label, (scenario, changes) in FURTHER.items():
        yield label, scenario, dict(changes)


def row(label: str, scenario: str, changes: dict[str, Any]) -> tuple[Any, ...]:
    """A line of the first table."""
    shipped, by_error, quarter = (run(scenario, {**changes, **steps}) for steps in ({}, BY_ERROR, QUARTER))
    before, after = compared(shipped, quarter), compared(by_error, quarter)
    kept = by_error.status == quarter.status == shipped.status
    status = quarter.status if kept else f"**{shipped.status}, {by_error.status}, {quarter.status}**"
    times = shipped.seconds, by_error.seconds, quarter.seconds
    return label, status, quarter.transit, *before, *after, *times, by_error.parts, by_error.rejected


def hanging() -> list[tuple[Any, ...]]:
    """Lines of the second table."""
    fine = run(HANGING, FINE)
    last = min(6.0, float(fine.time[-1]))

    def line(label: str, one: Run) -> tuple[Any, ...]:
        places = (float(np.interp(at, one.time, one.position)) for at in (2.0, last, one.time[-1]))
        return label, one.status, *places, compared(one, fine)[1], one.seconds, one.parts, one.rejected

    lines = [line("fixed, 0.5 ms", fine)]
    for step in ("2 ms", "4 ms", "5 ms", "8 ms"):
        lines.append(line(f"fixed, {step}", run(HANGING, {**BY_ERROR, "step.control": "fixed", "step.wall": step})))
    for tolerance in TOLERANCES:
        lines.append(line(f"by error, {tolerance}", run(HANGING, {**BY_ERROR, "step.tolerance": tolerance})))
    return lines


def main() -> None:
    """Make the runs and write the page."""
    rows = []
    for label, scenario, changes in cases():
        rows.append(row(label, scenario, changes))
        print(*rows[-1], flush=True)
    head = ("run", "status", "transit, quarter (s)", "shipped (%)", "shipped, track (mm)", "by error (%)")
    head += ("by error, track (mm)", "shipped (s)", "by error (s)", "quarter (s)", "parts", "rejected")
    instants = ("steps", "status", "at 2 s (cm)", "at 6 s (cm)", "at the end (cm)", "track, rms (mm)")
    instants += ("processor (s)", "parts", "rejected")
    same = sum(not line[1].startswith("**") for line in rows)
    worst = max(abs(line[5]) for line in rows if line[5] is not None)
    text = f"""# Steps whose length follows their error

Made by `python evidence/steps.py`. *Shipped*: fixed steps, as the scenario has them; *by error*:
`step.control = error` with its shipped numbers, conduction in steps of 1 ms; *quarter*: fixed steps
of 2 ms, a quarter of the longest, conduction in steps of 0.25 ms. Errors are differences from
*quarter*; the seconds are of the processor, for the run with its records.

{same} of {len(rows)} runs end alike in all three. The largest change of a transit by steps by error is
{worst:.2g} %: the lag of the wall behind its muscle ([0033](../decisions/0033-steps-by-error.md)).

{table(head, rows)}
## A run that depends on a few instants

`{HANGING}`: the contraction slips over the pellet between 1.3 and 1.6 s, and once more later. Fixed
steps of 8 ms end it elsewhere (with the numerics before (85)-(88), those of 5 ms too); steps by error
end it as short steps do, at every tolerance.

{table(instants, hanging())}"""
    save_text("steps.md", text)


if __name__ == "__main__":
    main()
