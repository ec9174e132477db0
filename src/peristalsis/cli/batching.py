"""`peristalsis batch` and `peristalsis check`: many runs, and whether what is stored is whole."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ConfigurationError, DamagedResult, DivergenceError, WriteError, shown
from ..paths import located
from .inputs import under_drugs
from .streams import Screen, spelled

if TYPE_CHECKING:
    from ..many.rows import Point, Step


def batch(
    file: str,
    out: str | None,
    workers: int | str,
    screen: Screen,
    drugs: Sequence[str] = (),
    library: str | None = None,
) -> int:
    """Carry out a batch file; the exit code."""
    from ..many.batch import WITHOUT_RESULT
    from ..many.batch import batch as carry_out
    from ..many.plan import as_text, read_plan

    begin = time.monotonic()
    plan = read_plan(located(file))
    if drugs or library is not None:
        plan = replace(plan, points=tuple(_under_drugs(point, drugs, library) for point in plan.points))
    target = Path("out", located(file).stem) if out is None else located(out)
    screen.if_interrupted = f"interrupted; finished runs are kept in {spelled(target)}: call again to go on"

    def progress(step: Step) -> None:
        summary = step.row.summary
        transit = summary.get("transit_s")
        ended = f"expelled at {transit:.4g} s" if transit is not None else step.row.status.replace("_", " ")
        values = ", ".join(f"{key} = {as_text(value)}" for key, value in step.row.point.values.items())
        screen.line(
            f"{step.done:4d}/{step.count} {step.row.point.name} ({values}): {ended}{' (kept)' if step.kept else ''}"
        )

    made = carry_out(plan, target, workers=workers, progress=progress, say=screen.warn)
    counted = Counter(row.status for row in made.rows)
    screen.table(("status", "runs"), ((status.replace("_", " "), str(count)) for status, count in counted.items()))
    spent = time.monotonic() - begin
    answer: dict[str, Any] = {"status": made.status, "runs": dict(counted), "written": str(made.table)}
    screen.answer(answer | {"wall_s": round(spent, 1)})
    screen.say(f"written: {spelled(made.table)} ({spent:.0f} s)")
    if made.status == "finished":
        return 0
    without = sum(row.status in WITHOUT_RESULT for row in made.rows)
    screen.line(f"error: {without} of {len(made.rows)} points have no result; the table says why")
    return DivergenceError.exit_code


def _under_drugs(point: Point, drugs: Sequence[str], library: str | None) -> Point:
    """A point of a batch with the drugs of its command line; refused ones stay as they are."""
    if point.configuration is None:
        return point
    return replace(point, configuration=under_drugs(point.configuration, drugs, library))


def check(folders: Sequence[str], aside: bool, screen: Screen) -> int:
    """Check stored runs against their manifests; exit code 1 if one is not whole."""
    from ..results import result
    from ..storing import store

    states: list[dict[str, str]] = []
    for folder in folders:
        path = located(folder)
        try:
            found = result.check(path)
            states.append({"folder": folder, "state": "whole", "said": f"{found.status}, {len(found.files)} files"})
        except DamagedResult as error:
            said = str(error)
            if aside:
                try:
                    said = f"moved to {spelled(store.quarantine(path))}"
                except OSError as problem:
                    raise WriteError(
                        f"could not move {shown(folder)} aside: {problem.strerror or problem}; check the permissions"
                    ) from None
            states.append({"folder": folder, "state": "damaged", "said": said})
        except ConfigurationError as error:
            states.append({"folder": folder, "state": "not verified", "said": str(error)})
    screen.table(("folder", "state", ""), ((one["folder"], one["state"], one["said"]) for one in states))
    whole = all(one["state"] == "whole" for one in states)
    screen.answer({"status": "finished" if whole else "failed", "results": states})
    return 0 if whole else 1
