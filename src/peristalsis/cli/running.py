"""`peristalsis run`: compute, store, draw, and say what came out."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import ConfigurationError, DivergenceError, InterruptedRun, WriteError
from ..names import CERTAIN
from ..paths import located
from .inputs import Input
from .report import print_certainty, print_summary
from .signals import Held, held_back
from .streams import RunProgress, Screen, spelled

if TYPE_CHECKING:
    from ..results.result import Result
    from ..running.runner import KeptRun

PICTURES = ("overview", "track", "diameter_map", "wall_shapes")
"""Drawn after every run, where they apply; `peristalsis plot` draws all."""

AROUND = ("activation_maps", "surface_maps")
"""Drawn besides where anything may vary around the ring."""

MOST_NEIGHBOURS = 2
"""Runs that --certain makes besides, so no more processes than these."""

Failure = DivergenceError | InterruptedRun


@dataclass(frozen=True)
class Order:
    """What to run and where to put it."""

    input: Input
    out: str | None
    overwrite: bool
    pictures: bool
    resume: bool = False
    certain: bool = False
    workers: int = 1


def run(order: Order, screen: Screen) -> int:
    """Carry out an order; the exit code."""
    from ..running.certain import cost_words, make_certain, neighbours
    from ..running.runner import KeptRun

    configuration = order.input.configuration()
    screen.scenario = configuration.scenario
    target = Path("out", configuration.scenario) if order.out is None else located(order.out)
    refuse_target(target, order.overwrite or order.resume)
    if order.certain:
        if not 1 <= order.workers <= MOST_NEIGHBOURS:
            raise ConfigurationError(f"--workers {order.workers}: --certain makes two runs; choose 1 or 2")
        neighbours(configuration)  # refused now rather than at the end
    screen.if_interrupted = "interrupted; nothing was written"
    kept = KeptRun(configuration, target, order.resume, order.overwrite, screen.line)
    if kept.finished is not None:
        return _say_finished(kept, order, target, screen)
    if order.certain:
        screen.line(cost_words(configuration, order.workers))
    with kept:
        result, failure = _simulate(kept, screen)
        if order.certain and failure is None:
            result = make_certain(result, order.workers, screen.line)
        drawing = Drawing(result, wanted=order.pictures and not isinstance(failure, InterruptedRun))
        try:
            _save(kept, result, drawing)
        except WriteError as error:
            fields = _plain(result) | {"status": error.status, "error": str(error)}
            left = f" (a checkpoint is in {spelled(kept.workspace.folder)}: --resume goes on from it)"
            return screen.fail(error, fields, also=left if kept.workspace.has_checkpoints() else "")
    screen.if_interrupted = f"interrupted; the result is in {spelled(target)}"
    if failure is not None:
        return screen.fail(failure, _plain(result), also=f" (saved in {spelled(target)})")
    screen.answer(_plain(result))
    print_summary(result, target, drawing.names, screen)
    print_certainty(result, screen)
    if drawing.problem is not None:
        screen.warn(f"{drawing.problem}; the numbers are saved in {spelled(target)}")
    return InterruptedRun.exit_code if drawing.interrupted or left_open(result) else 0


def left_open(result: Result) -> bool:
    """Whether the neighbours of a run were interrupted."""
    verdict = result.summary.get(CERTAIN)
    return verdict is not None and verdict["agrees"] is None


def _say_finished(kept: KeptRun, order: Order, target: Path, screen: Screen) -> int:
    """What a run that needs no resuming came to; the exit code it had."""
    from ..running.certain import cost_words

    result = kept.finished
    assert result is not None
    if result.status == DivergenceError.status:
        return screen.fail(DivergenceError(result.error or ""), _plain(result), also=f" (saved in {spelled(target)})")
    screen.line(f"{spelled(target)} is finished: nothing is left to run")
    if order.certain:
        if CERTAIN not in result.summary:
            screen.line(cost_words(result.configuration, order.workers))
        pictures = order.pictures
        result = kept.finished_and_certain(
            order.workers, screen.line, lambda made, folder: _draw_again(made, folder, pictures)
        )
    screen.answer(_plain(result))
    print_summary(result, target, (), screen)
    print_certainty(result, screen)
    return InterruptedRun.exit_code if order.certain and left_open(result) else 0


def _draw_again(result: Result, folder: Path, wanted: bool) -> None:
    with held_back() as held:
        Drawing(result, wanted).draw(folder, held)


def refuse_target(target: Path, overwrite: bool) -> None:
    """Refuse, before anything is computed, a folder that may not or cannot be written."""
    from ..storing.store import check_target

    parent = target.absolute().parent
    try:
        check_target(target, overwrite)
        while not parent.exists():
            parent = parent.parent
        with tempfile.TemporaryFile(dir=parent):  # permissions alone do not tell: it may be read-only or full
            pass
    except OSError as error:
        raise WriteError(
            f"{spelled(target)} cannot be written: {error.strerror or error}; choose another one with --out"
        ) from None


def _simulate(kept: KeptRun, screen: Screen) -> tuple[Result, Failure | None]:
    from ..inputs.consistency import recording_of
    from ..inputs.preflight import disk_remarks, expected_effort

    configuration = kept.configuration
    screen.line(recording_of(configuration).words())
    with RunProgress(screen, configuration.run.duration, configuration.pellet.enabled) as progress:
        simulation = kept.begin(progress.see)
        for remark in (*simulation.remarks, *disk_remarks(configuration, kept.target)):
            screen.warn(remark)
        if configuration.solver.integrator == "explicit":
            screen.line(expected_effort(configuration, simulation.model, simulation.state).words())
        progress.start()
        result = simulation.run()
        if simulation.failure is None:
            progress.done(result.status.replace("_", " "), float(result.summary["simulated_s"]))
    for remark in result.remarks:
        if remark not in simulation.remarks:
            screen.warn(remark)
    return result, simulation.failure


def _save(kept: KeptRun, result: Result, drawing: Drawing) -> None:
    try:
        with held_back() as held:
            kept.save(result, extras=lambda folder: _add(result, folder, drawing, held))
            drawing.interrupted = drawing.interrupted or held.asked
    except WriteError:
        raise
    except Exception as error:  # the file library has errors of its own when a disk is full
        raise WriteError(f"could not write {spelled(kept.target)}: {error}; choose another folder with --out") from None


def _add(result: Result, folder: Path, drawing: Drawing, held: Held) -> None:
    from ..running.certain import write_table

    write_table(result.summary, folder)
    drawing.draw(folder, held)


def _plain(result: Result) -> dict[str, object]:
    from ..results.result import json_ready

    return dict(json_ready(result.summary))


class Drawing:
    """The pictures of a run: all of them or none; they never cost the numbers."""

    def __init__(self, result: Result, wanted: bool) -> None:
        self._result = result
        self._wanted = wanted
        self.names: tuple[str, ...] = ()
        self.problem: str | None = None
        self.interrupted = False

    def draw(self, folder: Path, held: Held) -> None:
        """Draw into a folder; what goes wrong is noted in `problem`."""
        if not self._wanted:
            return
        apart = folder / ".pictures"
        try:
            with held.released():
                apart.mkdir()
                plots = self._result.plot
                wanted = (*PICTURES, *(AROUND if self._result.configuration.grid.n_theta > 1 else ()))
                plots.save(apart, [name for name in wanted if name in plots.available()])
                drawn = sorted(apart.iterdir())
                for picture in drawn:
                    picture.replace(folder / picture.name)
                self.names = tuple(picture.name for picture in drawn)
        except KeyboardInterrupt:
            self.interrupted = True
            self.problem = "interrupted while drawing"
        except Exception as error:
            self.problem = f"the pictures could not be drawn ({' '.join(str(error).split())})"
        finally:
            shutil.rmtree(apart, ignore_errors=True)
