"""E10: one cell by the sheet's own kernel against an independent solution, Eqs. (20)-(22) and (31)."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from peristalsis.inputs.build import cell_constants
from peristalsis.inputs.config import Configuration
from peristalsis.numerics.stabilised import coefficients
from peristalsis.tissue.cells import plant
from peristalsis.tissue.records import Brought, SheetArrays, Steps, Tables
from peristalsis.tissue.sheet import advance_sheet

from .exact.cell import BURSTING_START, ReferenceCell
from .problem import Check, Outcome, Problem, error, judged, order

Floats = NDArray[np.float64]

MUSCLE = ReferenceCell(slow=0.004, rate=0.125)
PULSE, AFTER = 50.0, 1400.0
"""A pulse of 50 ms, then the spike and its repolarisation [ms]."""


class Cell:
    """A sheet of one cell: no conduction. start: V, h, n, x, c; dt in ms."""

    def __init__(self, start: Floats, slow: float, rate: float, dt: float, exact: bool) -> None:
        self.constants = cell_constants(Configuration(), rate)
        self.dt, self.exact, self.time = dt, exact, 0.0
        self.table = plant.gate_table(dt, self.constants)
        self.half = plant.gate_table(0.5 * dt, self.constants)
        self.potential = np.array([start[0]])
        self.gates = np.array(start[1:]).reshape(4, 1)
        self.conductances = np.array([4.0, slow, 0.3, 0.03, 0.003]).reshape(5, 1)
        self.first, self.latest = np.full(1, np.nan), np.full(1, np.nan)

    def advance(self, steps: int, stimulus: float = 0.0) -> float:
        """The potential [mV] after so many steps; ValueError if it leaves the range of the tables."""
        verdict = advance_sheet(
            SheetArrays(self.potential, self.gates, self.first, self.latest),
            self.conductances,
            np.empty(0),
            Brought(np.array([stimulus]), np.zeros(1)),
            Steps(self.time, self.dt, steps, 1, self.exact, -40.0),
            coefficients(2),
            Tables(self.table, self.half),
            self.constants,
        )
        if verdict != -1:
            raise ValueError(f"the cell left its range within {steps} steps of {self.dt:g} ms; take shorter steps")
        self.time += steps * self.dt
        return float(self.potential[0])


@cache
def resting_start() -> tuple[float, ...]:
    """V, h, n, x, c of resting muscle, from the independent cell."""
    v = MUSCLE.steady_states()[0]
    return (v, *MUSCLE.steady_gates(v))


def times() -> Floats:
    """Every 10 ms through the pulse, the spike and the return."""
    return np.arange(10.0, PULSE + AFTER + 1.0, 10.0)


@cache
def reference() -> Floats:
    """V of the independent cell at `times`."""
    return MUSCLE.solve(np.array(resting_start()), [(PULSE, 2.0), (AFTER, 0.0)], times())


def traced(dt: float, exact: bool) -> Floats:
    """V of the package's cell at `times`."""
    cell = Cell(np.array(resting_start()), 0.004, 0.125, dt, exact)
    steps = round(10.0 / dt)
    return np.array([cell.advance(steps, 2.0 if t <= PULSE + 1e-9 else 0.0) for t in times()])


def burst(dt: float, seconds: float, exact: bool = True) -> Floats:
    """V every ms of Plant's own cell, on its own clock."""
    v, h, x, n, c = BURSTING_START
    cell = Cell(np.array([v, h, n, x, c]), 0.01, 1.0, dt, exact)
    steps = round(1.0 / dt)
    return np.array([cell.advance(steps) for _ in range(round(1e3 * seconds))])


def single_cell() -> Outcome:
    """The spike against DOP853 and LSODA; clamped gates; reversal potentials; V after ten seconds."""
    wanted = reference()
    span = float(np.ptp(wanted))
    other = MUSCLE.solve(np.array(resting_start()), [(PULSE, 2.0), (AFTER, 0.0)], times(), rtol=1e-10, method="LSODA")
    levels = [0.25 / 2**k for k in range(2, 8)]
    errors = [float(np.abs(traced(dt, True) - wanted).max() / span) for dt in levels]
    late = Cell(np.array(resting_start()), 0.004, 0.125, levels[-1], True)
    late.advance(round(PULSE / levels[-1]), 2.0)
    found = late.advance(round((10_000.0 - PULSE) / levels[-1]))
    exact = MUSCLE.solve(np.array(resting_start()), [(PULSE, 2.0), (9950.0, 0.0)], np.array([10_000.0]))[0]
    return judged(
        "V(t), h, n, x, c of the 0-D cell",
        [
            Check("spike of the reference [mV]", float(wanted.max()), 0.0),
            error("reference: LSODA against DOP853, of the range of V", np.abs(other - wanted).max() / span, 1e-6),
            error("of the range of V at 2 µs, through the spike", errors[-1], 1e-6),
            order("in time", levels, errors, 2.0),
            error("relative, V after 10 s", found / exact - 1.0, 1e-6),
            error("clamped gates against e^(−t/τ)", _clamped(), 1e-12),
            error("current at its reversal potential", _reversal(), 0.0),
        ],
    )


def _clamped() -> float:
    constants = cell_constants(Configuration(), 0.125)
    worst = 0.0
    for v in (-75.0, -55.0, -30.0, 10.0):
        start = np.array([0.9, 0.1, 0.2, 0.3]).reshape(4, 1)
        gates = start.copy()
        table = plant.gate_table(0.25, constants)
        for _ in range(40):
            plant.relax_gates(np.array([v]), gates, table, True, 0.25, constants, np.empty((1, 1)), np.ones((5, 1)))
        h, rate_h, n, rate_n, x, rate_x = plant.gate_targets(v, constants)
        targets, rates = np.array([h, n, x]), np.array([rate_h, rate_n, rate_x])
        wanted = targets + (start[:3, 0] - targets) * np.exp(-10.0 * 0.125 * rates)
        worst = max(worst, float(np.abs(gates[:3, 0] - wanted).max()))
    return worst


def _reversal() -> float:
    conductances = np.repeat(np.array([4.0, 0.004, 0.3, 0.03, 0.003])[:, None], 3, axis=1)
    constants = cell_constants(Configuration(), 0.125)
    found = plant.currents(np.array([30.0, -75.0, -40.0]), np.full((4, 3), 0.5), conductances, constants)
    zeros = (("fast_calcium", 0), ("slow_calcium", 0), ("potassium", 1), ("calcium_potassium", 1), ("leak", 2))
    return max(abs(float(found[name][k])) for name, k in zeros)


def bursting() -> Outcome:
    """Plant's own cell bursts as published."""
    v = burst(0.125, 36.0)
    rises = np.flatnonzero((v[:-1] < -20.0) & (v[1:] >= -20.0)) * 1e-3
    fresh = np.flatnonzero(np.diff(rises, prepend=-10.0) > 3.0)
    periods, spikes, settled = np.diff(rises[fresh]), np.diff(fresh)[1:], v[12_000:]
    return judged(
        "period 10.48 s, 6 spikes a burst, −64.6 … +28.6 mV",
        [
            Check("period [s]", float(periods[1:].mean()), 10.48 * 0.995, 10.48 * 1.005),
            Check("fewest spikes", float(spikes.min()), 6.0, 6.0),
            Check("most spikes", float(spikes.max()), 6.0, 6.0),
            Check("lowest V [mV]", float(settled.min()), -64.7, -64.5),
            Check("highest V [mV]", float(settled.max()), 28.3, 28.9),
        ],
    )


PROBLEMS = (
    Problem(
        "E10",
        "Ion model of one cell",
        "Plant, J. Math. Biol. 11 (1981), coded anew and solved by DOP853 and LSODA",
        "quick",
        single_cell,
        (20, 21, 22, 23, 31),
    ),
    Problem("E10b", "Plant's bursting cell", "Plant, J. Math. Biol. 11 (1981)", "quick", bursting, (20, 21, 22)),
)
