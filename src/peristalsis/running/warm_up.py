"""Compile every kernel once, on a tube too small to matter, so that no run pays for it unseen."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING

from ..inputs.recording import chosen
from ..numerics.kept import watched

if TYPE_CHECKING:
    from ..inputs.config import Configuration

TINY = {"grid.n_z": 200, "grid.n_z_wall": 100}
QUIET_SECONDS = 2.0
"""How long nobody is told of the next kernel."""
KERNELS = {(False, "implicit"): 35, (True, "implicit"): 60, (False, "explicit"): 4}
"""Kernels that are called, those that they call not counted, with the shipped parts: on one column and, besides them,
on the whole surface or by the explicit scheme. A test counts again."""
TISSUE = "from peristalsis.running.warm_up import compile_tissue; compile_tissue()"


def _tiny(changes: dict[str, object]) -> Configuration:
    from ..inputs.config import Configuration

    return Configuration().with_changes({**TINY, **changes})


def compile_tissue() -> None:
    """Compile what a step takes besides the wall's equilibrium: kernels of the sheets, of balances and of records."""
    from ..inputs.build import build
    from ..model.initial import straight_state
    from ..model.step import advance_sheets
    from .observers import FieldRecorder, ScalarRecorder

    model = build(_tiny({}))
    state = straight_state(model)
    advance_sheets(model, state)
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


@dataclass
class Progress:
    """What is said while kernels are compiled: which one of how many, a line each, but seldom; nothing where none is.

    total: how many kernels there are, None if that is not known. say: what the lines are given to.
    """

    total: int | None
    say: Callable[[str], None]
    ready: int = 0
    compiled: int = 0
    _next: float = field(default=0.0, init=False)

    def see(self, name: str, compiled: bool) -> None:
        """A kernel was loaded, or is about to be compiled."""
        self.ready += 1
        self.compiled += compiled
        if compiled and time.monotonic() >= self._next:
            self._next = time.monotonic() + QUIET_SECONDS
            of = "" if self.total is None else f" of {max(self.total, self.ready)}"
            self.say(f"peristalsis: compiling kernel {self.ready}{of}, once on this machine ({name})")


def _to_stderr(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


@dataclass(frozen=True)
class Warmth:
    """What it took to have kernels ready: seconds on the clock, kernels, and how many of them had to be compiled."""

    seconds: float = 0.0
    kernels: int = 0
    compiled: int = 0

    def __add__(self, other: Warmth) -> Warmth:
        return Warmth(self.seconds + other.seconds, self.kernels + other.kernels, self.compiled + other.compiled)


@cache
def _compile(columns: int, integrator: str = "implicit", parts: tuple[tuple[str, object], ...] = ()) -> Warmth:
    from ..errors import PeristalsisError
    from ..inputs.preflight import remarks

    begin = time.perf_counter()
    changes: dict[str, object] = {"grid.n_theta": columns, **dict(parts)}
    if integrator == "explicit":
        changes |= {"solver.integrator": integrator, "wall.surface_density": "26.14 g/cm^2"}
    if columns > 1:
        changes["pacemaker.angular_width"] = "90 deg"
    progress = Progress(None if parts else KERNELS[columns > 1, integrator], _to_stderr)
    with watched(progress.see), _second_process() if not parts else contextlib.nullcontext():
        if not parts:
            tiny = _tiny(changes)
            remarks(tiny)
            if columns > 1:  # steps that do not vary around the ring take ways of their own
                _step(tiny.with_changes({"pacemaker.angular_width": "360 deg"}), 1)
            _step(tiny, columns)
        else:
            with contextlib.suppress(PeristalsisError):  # a tube of other sizes may start where this one does not
                _step(_tiny(changes), columns)
    return Warmth(time.perf_counter() - begin, progress.ready, progress.compiled)


def _step(tiny: Configuration, columns: int) -> None:
    """A start and a step or two, with the kernels that the parts of a configuration are bound to."""
    from dataclasses import replace

    from ..inputs.build import build
    from .observers import FieldRecorder, ScalarRecorder

    start = build(tiny)
    model, before, _ = start.binding.module("model.initial").initial_state(start)
    if columns > 1:
        # One side pulls at once: a wall that varies around the ring takes ways that a uniform one does not.
        potential = before.circular.potential.copy()
        potential[:, 0] = model.circular.threshold + 5.0
        before = replace(before, circular=replace(before.circular, potential=potential))
    fields = chosen(("all",), tiny.cells())
    recorders = ScalarRecorder(), FieldRecorder(1, fields)
    for recorder in recorders:
        recorder.start(model, before)
    for _ in range(1 if columns == 1 else 2):  # the sheets see a wall that varies from the second step on
        after, report = model.binding.module("model.guards").advance_safely(model, before)
        for recorder in recorders:
            recorder.see(model, before, after, report)
        before = after


def warm_up(surface: bool = False, explicit: bool = False, parts: Mapping[str, object] | None = None) -> float:
    """Compile or load all kernels; seconds it took the first time in this process.

    surface: those of the wall and the sheets on the whole surface too, which take some minutes to compile. explicit:
    those of the explicit scheme too. parts: what a configuration chooses in its slots, if not the shipped parts.
    """
    return warmed(surface, explicit, parts).seconds


def warmed(surface: bool = False, explicit: bool = False, parts: Mapping[str, object] | None = None) -> Warmth:
    """As `warm_up`, with the numbers of kernels."""
    own = tuple(sorted((parts or {}).items()))
    found = _compile(1, "implicit", own)
    if surface:
        found += _compile(8, "implicit", own)
    return found + _compile(1, "explicit", own) if explicit else found
