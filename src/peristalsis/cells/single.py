"""Runs of one cell by the kernels that tissue uses: potential and states against time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ConfigurationError
from ..numerics.binding import Binding, bind
from ..numerics.stabilised import coefficients
from ..tissue.records import Brought, SheetArrays, Steps, Tables
from .description import FOLDER, Description, Floats, start

Stimulus = Callable[[float], float]
"""Current [uA/cm^2], inward positive, at a time [ms]."""
STAGES = 4


@dataclass(frozen=True)
class Trace:
    """times [ms] and potential [mV] of shape (n,), states of shape (number of states, n), the step [ms] used."""

    times: Floats
    potential: Floats
    states: Floats
    names: tuple[str, ...]
    step: float


def quiet(time: float) -> float:
    """No stimulus."""
    return 0.0


def pulses(intensity: float, begin: float, duration: float, period: float) -> Stimulus:
    """Rectangular pulses [uA/cm^2] from `begin` on, each of `duration`, every `period` [ms]; one if the period is 0."""

    def at(time: float) -> float:
        since = time - begin
        if since < 0.0:
            return 0.0
        return intensity if (since % period if period > 0.0 else since) < duration else 0.0

    return at


def bound(cell: Description) -> Binding:
    """Kernels of this cell."""
    return bind({"tissue.cells.plant": FOLDER / "general.py", "tissue.cells.hodgkin_huxley": cell.file})


def run(
    cell: Description,
    duration: float,
    sampling: float,
    step: float,
    stimulus: Stimulus = quiet,
    begin: Floats | None = None,
    exact: bool = False,
) -> Trace:
    """The cell over `duration`, kept every `sampling`, in steps of `step`, all in ms.

    The stimulus is taken at the middle of each step. begin: potential and states at time 0. Raises ConfigurationError
    where the potential leaves the cell's range.
    """
    binding = bound(cell)
    kernels: Any = binding.module("tissue.cells.plant")
    own: Any = binding.module("tissue.cells.hodgkin_huxley")
    sheet: Any = binding.module("tissue.sheet")
    initial = start(cell) if begin is None else np.asarray(begin, dtype=np.float64)
    parts, samples = max(1, round(sampling / step)), round(duration / sampling)
    dt = sampling / parts
    constants = own.SHIPPED
    tables = kernels.gate_table(dt, constants), kernels.gate_table(0.5 * dt, constants)
    v, states = initial[:1].copy(), initial[1:, None].copy()
    channels, unset = cell.conductances[:, None], np.full(1, np.nan)
    stages, none, shunt = coefficients(STAGES), np.zeros(0), np.zeros(1)
    kept = np.empty((samples + 1, initial.size))
    kept[0] = initial
    drive = np.zeros(1)
    steady = stimulus is quiet
    for k in range(samples):
        for part in range(1 if steady else parts):
            drive[0] = stimulus(k * sampling + (part + 0.5) * dt)
            code = sheet.advance_sheet(
                SheetArrays(v, states, unset, unset.copy()),
                channels,
                none,
                Brought(drive, shunt),
                Steps(0.0, dt, parts if steady else 1, 1, exact, 0.0),
                stages,
                Tables(*tables),
                constants,
            )
            if code != -1:
                raise ConfigurationError(
                    f"the potential of {cell.name} leaves its range of {own.LOWEST:g} to {own.HIGHEST:g} mV within "
                    f"{(k + 1) * sampling:g} ms in steps of {dt:g} ms; take a shorter step or a weaker stimulus"
                )
        kept[k + 1, 0], kept[k + 1, 1:] = v[0], states[:, 0]
    times = sampling * np.arange(samples + 1, dtype=np.float64)
    return Trace(times, kept[:, 0], kept[:, 1:].T, cell.states, dt)


def converged(
    cell: Description, duration: float, sampling: float, stimulus: Stimulus = quiet, tolerance: float = 2e-4
) -> Trace:
    """As `run`, with the step halved until the potential changes by less than `tolerance` of its range."""
    last: Trace | None = None
    step = min(sampling, 1.0)
    for _ in range(14):
        try:
            found = run(cell, duration, sampling, step, stimulus)
        except ConfigurationError:
            if step < 1e-3:
                raise
            step *= 0.5
            continue
        span = max(float(np.ptp(found.potential)), 1e-6)
        if last is not None and float(np.abs(found.potential - last.potential).max()) < tolerance * span:
            return found
        last = found
        step *= 0.5
    raise ConfigurationError(f"the steps of {cell.name} had to be shorter than {step:g} ms; take a shorter duration")


def upstrokes(trace: Trace) -> Floats:
    """Times [ms] at which the potential rises through the middle of its range."""
    v = trace.potential
    level = 0.5 * float(v.min() + v.max())
    k = np.flatnonzero((v[:-1] < level) & (v[1:] >= level))
    return np.asarray(trace.times[k] + (level - v[k]) / (v[k + 1] - v[k]) * (trace.times[1] - trace.times[0]))
