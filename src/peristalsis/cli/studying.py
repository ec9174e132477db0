"""What the commands of studies do: run, draw, and say what came out."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ConfigurationError, DivergenceError
from ..paths import located
from .streams import Screen, spelled

if TYPE_CHECKING:
    from ..many.rows import Step
    from ..many.studies.table import Table
    from .orders import StudyOrder


class Progress:
    """Lines on stderr: how many runs are done, and how long the rest will take at the pace so far."""

    EVERY = 5.0
    """Seconds between two lines."""

    def __init__(self, screen: Screen, clock: Callable[[], float] = time.monotonic) -> None:
        self._screen, self._clock = screen, clock
        self._begin = self._said = clock()
        self._made = self._kept = 0

    def __call__(self, step: Step) -> None:
        """A row is there."""
        if step.kept:
            self._kept += 1
        elif step.row.status != "refused":
            self._made += 1
        last = step.done == step.count
        if step.row.summary.get("error") and not step.kept:
            self._screen.line(f"point {step.row.point.name}: {step.row.status}: {step.row.summary['error']}")
        if not last and self._clock() - self._said < self.EVERY:
            return
        self._said = self._clock()
        left = ""
        if self._made and not last:
            left = f", {in_words((self._said - self._begin) / self._made * (step.count - step.done))} left"
        self._screen.line(f"{step.done}/{step.count} points, {self._kept} of them kept{left}")


def in_words(seconds: float) -> str:
    """A time in one or two units."""
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"


def target_of(order: StudyOrder, screen: Screen) -> Path:
    """Folder of the tables of a study; what to say if it is interrupted is told to the screen."""
    target = Path("out", located(order.file).stem) if order.out is None else located(order.out)
    screen.if_interrupted = "interrupted; finished runs are kept: call again to go on"
    return target


def drawn(order: StudyOrder, draw: Callable[[], list[Path]]) -> list[str]:
    """Names of the pictures that were drawn, if any were asked for."""
    return [path.name for path in draw()] if order.plots else []


def ended(table: Table, screen: Screen) -> int:
    """The exit code of a table; points without result are said."""
    if table.status == "finished":
        return 0
    from ..many.studies.table import WITHOUT_RESULT

    without = sum(table.statuses[one] for one in WITHOUT_RESULT)
    screen.line(f"error: {without} of {len(table)} points have no result; the table says why")
    return DivergenceError.exit_code


def sweep(order: StudyOrder, screen: Screen) -> int:
    """Carry out a study; the exit code."""
    from ..many.studies.pictures import draw_sweep
    from ..many.studies.sweep import sweep as carry_out

    begin = time.monotonic()
    target = target_of(order, screen)
    progress = Progress(screen)
    table = carry_out(
        located(order.file),
        target,
        workers=order.workers,
        kept=order.kept,
        reading=order.reading,
        parquet=order.parquet,
        progress=progress,
        say=screen.warn,
    )
    pictures = drawn(order, lambda: draw_sweep(table, target))
    _answer(table, target / "table.csv", pictures, begin, screen)
    return ended(table, screen)


def stall_map(order: StudyOrder, screen: Screen) -> int:
    """Carry out a map of classes; the exit code."""
    from ..many.studies.pictures import draw_map
    from ..many.studies.stall_map import NODES
    from ..many.studies.stall_map import stall_map as carry_out

    begin = time.monotonic()
    target = target_of(order, screen)
    found = carry_out(
        located(order.file),
        target,
        workers=order.workers,
        kept=order.kept,
        reading=order.reading,
        progress=Progress(screen),
        say=screen.warn,
    )
    pictures = drawn(order, lambda: draw_map(found, target))
    share = f"{found.runs} runs for {found.nodes} nodes ({100 * found.refined.share:.0f} %)"
    screen.say(share)
    more = {"nodes": found.nodes, "runs_made": found.runs}
    _answer(found.table, target / NODES, pictures, begin, screen, more)
    return ended(found.table, screen)


def sensitivity(order: StudyOrder, method: str | None, screen: Screen) -> int:
    """Carry out a sensitivity; the exit code."""
    from ..many.studies.pictures import draw_sensitivity
    from ..many.studies.sensitivity import INDICES, cost_words, method_of, read_sensitivity
    from ..many.studies.sensitivity import sensitivity as carry_out

    begin = time.monotonic()
    target = target_of(order, screen)
    study = read_sensitivity(located(order.file), order.reading)
    screen.line(cost_words(study, method_of(study, method)))
    found = carry_out(
        study,
        target,
        method=method,
        workers=order.workers,
        kept=order.kept,
        progress=Progress(screen),
        say=screen.warn,
    )
    pictures = drawn(order, lambda: draw_sensitivity(found, target))
    for output in study.outputs:
        rows = [(one.variable, f"{one.value:.3g}", f"{one.low:.3g} to {one.high:.3g}") for one in found.ranked(output)]
        screen.table(("parameter", found.ranks, "band of 95 %"), rows, output)
    ranks = {output: {one.variable: one.value for one in found.ranked(output)} for output in study.outputs}
    _answer(found.table, target / INDICES, pictures, begin, screen, {"method": found.method, "ranks": ranks})
    return ended(found.table, screen)


def cohort(order: StudyOrder, screen: Screen) -> int:
    """Carry out a cohort; the exit code."""
    from ..many.studies.cohort import SHIFTS
    from ..many.studies.cohort import cohort as carry_out
    from ..many.studies.pictures import draw_cohort

    begin = time.monotonic()
    target = target_of(order, screen)
    found = carry_out(
        located(order.file),
        target,
        workers=order.workers,
        kept=order.kept,
        reading=order.reading,
        progress=Progress(screen),
        say=screen.warn,
    )
    pictures = drawn(order, lambda: draw_cohort(found, target))
    rows = [
        (
            one.name,
            *map(str, found.classes(one.name).values()),
            "" if one.median is None else f"{one.median:.3g} s",
            ""
            if one.shift is None or one.band is None
            else f"{one.shift:.3g} ({one.band[0]:.3g} to {one.band[1]:.3g}) s",
        )
        for one in found.shifts
    ]
    screen.table(("", "normal", "slow", "not expelled", "median transit", "median shift (95 %)"), rows)
    screen.say(f"{found.accepted} of {len(found.table)} members pass the rules. A research model, not medical advice.")
    more = {"accepted": found.accepted, "classes": {one.name: found.classes(one.name) for one in found.shifts}}
    _answer(found.table, target / SHIFTS, pictures, begin, screen, more)
    return 0


def _answer(
    table: Table, written: Path, pictures: list[str], begin: float, screen: Screen, more: dict[str, Any] | None = None
) -> None:
    spent = time.monotonic() - begin
    counted = table.statuses
    screen.table(("status", "runs"), ((one.replace("_", " "), str(count)) for one, count in counted.items()))
    answer: dict[str, Any] = {"status": table.status, "runs": dict(counted), "written": str(written)}
    screen.answer(answer | (more or {}) | {"pictures": pictures, "wall_s": round(spent, 1)})
    screen.say(f"written: {spelled(written)} ({spent:.0f} s)")


def kept(folder: str, clean: str | None, screen: Screen) -> int:
    """Count kept runs, and remove those that are not wanted; the exit code."""
    from ..many.kept import CHOICES, clean_up, count

    if clean is not None and clean not in CHOICES:
        raise ConfigurationError(f"--clean {clean}: choose one of {', '.join(CHOICES)}")
    place = located(folder)
    found = count(place) if clean is None else clean_up(place, clean)
    screen.table(
        ("kept runs", "number", "MB"),
        ((name, str(one.number), f"{one.bytes / 1e6:.1f}") for name, one in found.items()),
    )
    screen.answer(
        {"status": "finished", "kept": {name: {"runs": one.number, "bytes": one.bytes} for name, one in found.items()}}
    )
    return 0
