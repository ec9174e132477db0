"""Compile every kernel once, on a tube too small to matter, so that no run pays for it unseen."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..inputs.config import Configuration
    from ..inputs.parts import Part

TINY = {"grid.n_z": 200, "grid.n_z_wall": 100}
QUIET_SECONDS = 2.0
"""How long nobody is told that kernels are compiled."""
TISSUE = "from peristalsis.running.warm_up import compile_tissue; compile_tissue()"


def _tiny(changes: dict[str, object]) -> Configuration:
    from ..inputs.config import Configuration

    return Configuration().with_changes({**TINY, **changes})


def compile_tissue() -> None:
    """Compile what a step takes besides the wall's equilibrium: kernels of the sheets, of balances and of records."""
    from ..inputs.build import build
    from ..model.initial import straight_state
    from ..model.step import advance_tissue
    from .observers import FieldRecorder, ScalarRecorder

    model = build(_tiny({}))
    state = straight_state(model)
    advance_tissue(model, state)
    for recorder in (ScalarRecorder(), FieldRecorder(1)):
        recorder.start(model, state)


@contextlib.contextmanager
def _second_process() -> Iterator[subprocess.Popen[bytes] | None]:
    """Where nothing is compiled yet and a processor is free, another process compiles the tissue meanwhile.

    It leaves its kernels in the cache, and this process loads or compiles whatever it comes to, so a process that
    fails, or takes its time, costs nothing but the help.
    """
    from ..numerics.compiled import CACHE_FOLDER
    from ..numerics.sources import PACKAGE, kernel_digest
    from ..storing.environment import processors

    # numba makes the folder when a kernel is decorated; what it has compiled are files in it.
    folder = None if CACHE_FOLDER is None else CACHE_FOLDER / kernel_digest(PACKAGE / "tissue" / "sheet.py")
    cold = folder is not None and next(folder.rglob("*.advance_sheet-*.nbc"), None) is None
    if not cold or processors() < 2 or not sys.executable:
        yield None
        return
    paths = os.pathsep.join(filter(None, (str(PACKAGE.parent), os.environ.get("PYTHONPATH"))))
    quiet = subprocess.DEVNULL
    try:
        helper = subprocess.Popen(
            [sys.executable, "-c", TISSUE],
            env={**os.environ, "PYTHONPATH": paths},
            stdin=quiet,
            stdout=quiet,
            stderr=quiet,
        )
    except OSError:
        yield None
        return
    try:
        yield helper
    finally:
        helper.kill()
        helper.wait()


@contextlib.contextmanager
def _said_if_long(columns: int, bound: str = "") -> Iterator[threading.Timer]:
    """A line on stderr if compiling takes more than a moment; loading what was compiled before does not.

    bound: the chosen parts, where they are not those that the package ships in their slots.
    """
    span = "some minutes" if columns > 1 else "about two minutes" if bound else "about a minute"
    kernels = f"the kernels of {bound}" if bound else "the kernels"
    text = f"peristalsis: preparing {kernels}, which are compiled once, for {span}"
    timer = threading.Timer(QUIET_SECONDS, lambda: print(text, file=sys.stderr, flush=True))
    timer.daemon = True
    timer.start()
    try:
        yield timer
    finally:
        timer.cancel()


@cache
def _compile(columns: int, integrator: str = "implicit") -> float:
    begin = time.perf_counter()
    changes: dict[str, object] = {"grid.n_theta": columns}
    if integrator == "explicit":
        changes |= {"solver.integrator": integrator, "wall.surface_density": "26.14 g/cm^2"}
    if columns > 1:
        changes["pacemaker.angular_width"] = "90 deg"
    with _said_if_long(columns), _second_process():
        _step(_tiny(changes))
    return time.perf_counter() - begin


def _step(tiny: Configuration) -> None:
    """The start of a run and its first steps, with all that is recorded of them."""
    from dataclasses import replace

    from ..inputs.build import build
    from ..inputs.preflight import remarks
    from .observers import FieldRecorder, ScalarRecorder

    remarks(tiny)
    model = build(tiny)
    module = model.binding.module
    model, before, _ = module("model.initial").initial_state(model)
    columns = model.grid.n_theta
    if columns > 1:
        # One side pulls at once: a wall that varies around the ring takes ways that a uniform one does not.
        potential = before.circular.potential.copy()
        potential[:, 0] = model.circular.threshold + 5.0
        before = replace(before, circular=replace(before.circular, potential=potential))
    recorders = ScalarRecorder(), FieldRecorder(1)
    for recorder in recorders:
        recorder.start(model, before)
    for _ in range(1 if columns == 1 else 2):  # the sheets see a wall that varies from the second step on
        after, report = module("model.guards").advance_safely(model, before)
        for recorder in recorders:
            recorder.see(model, before, after, report)
        before = after


def warm_up(surface: bool = False, explicit: bool = False) -> float:
    """Compile or load all kernels; seconds it took the first time in this process.

    surface: those of the wall and the sheets on the whole surface too, which take some minutes to compile. explicit:
    those of the explicit scheme too.
    """
    return _compile(1) + (_compile(8) if surface else 0.0) + (_compile(1, "explicit") if explicit else 0.0)


def combination(configuration: Configuration) -> tuple[Part, ...]:
    """The parts of a run that are not those which the package ships in their slots."""
    from ..inputs.parts import SHIPPED, find

    wall, pellet = find("law", configuration.wall.law), find("shape", configuration.pellet.shape)
    used = dict.fromkeys([*configuration.cells().values(), wall, pellet])
    return tuple(part for part in used if part.name != SHIPPED[part.kind])


_combinations: dict[tuple[object, ...], float] = {}


def warm_up_for(configuration: Configuration) -> float:
    """As `warm_up`, for the kernels of this run: where it has parts of other files, those that are bound to them.

    They are compiled on the run itself, on a small grid. What the run is refused for, it says when it begins.
    """
    surface, explicit = configuration.grid.n_theta > 1, configuration.solver.integrator == "explicit"
    chosen = combination(configuration)
    if not chosen:
        return warm_up(surface=surface, explicit=explicit)
    key = (*(part.file for part in chosen), surface, explicit)
    if key not in _combinations:
        begin = time.perf_counter()
        columns = 8 if surface else 1
        words = ", ".join(f"{part.kind} {part.name}" for part in chosen)
        failing = contextlib.suppress(Exception)  # whatever a part of the user's does: the run comes to it again
        with failing, _said_if_long(columns, words), _second_process():
            _step(configuration.with_changes({**TINY, "grid.n_theta": columns, "grid.n_theta_conduction": 0}))
        _combinations[key] = time.perf_counter() - begin
    return _combinations[key]


def main() -> int:
    """`python -m peristalsis.running.warm_up`: fill the cache, for the whole surface too; say where it takes time."""
    print("compiling the kernels, once, for some minutes (nothing to do if that was done before)", file=sys.stderr)
    print(f"kernels are ready after {warm_up(surface=True):.0f} s", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
