"""The same cell and cable in Myokit, an independent simulator that compiles its models to C: cost and potentials.

Myokit is an extra (`pip install myokit`) and needs a C compiler; without one of them the comparison is left out.
"""

from __future__ import annotations

import importlib.util
import math
import shutil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.model.model import ACTIVATION_LEVEL, Model
from peristalsis.results.measures import wave_speed
from peristalsis.tissue.cells.plant import CHANNELS
from peristalsis.tissue.records import Brought, SheetArrays, Steps
from peristalsis.tissue.rest import rest_state
from peristalsis.tissue.sheet import advance_sheet

from .clock import Timing, once

Floats = NDArray[np.float64]

COMPILERS = ("cc", "gcc", "clang")

MODEL = """
[[model]]
membrane.V = {potential!r}
gates.h = {h!r}
gates.n = {n!r}
gates.x = {x!r}
gates.c = {c!r}

[engine]
time = 0 bind time
pace = 0 bind pace

[membrane]
i_diffusion = 0 bind diffusion_current
i_fast = {fast_calcium!r} * gates.m^3 * gates.h * (V - {calcium_reversal!r})
i_slow = {slow_calcium!r} * gates.x * (V - {calcium_reversal!r})
i_potassium = {potassium!r} * gates.n^4 * (V - {potassium_reversal!r})
bound = gates.c / ({calcium_half_saturation!r} + gates.c)
i_calcium_potassium = {calcium_potassium!r} * bound * (V - {potassium_reversal!r})
i_leak = {leak!r} * (V - {chloride_reversal!r})
i_ion = i_fast + i_slow + i_potassium + i_calcium_potassium + i_leak
dot(V) = ({intensity!r} * engine.pace - {kinetics_rate!r} * i_ion - i_diffusion) / {capacitance!r}
    label membrane_potential

[gates]
U = (127 * membrane.V + 8265) / 105
alpha_m = if(abs(50 - U) < 1e-5, 1 - (50 - U) / 20, 0.1 * (50 - U) / (exp((50 - U) / 10) - 1))
beta_m = 4 * exp((25 - U) / 18)
m = alpha_m / (alpha_m + beta_m)
alpha_h = 0.07 * exp((25 - U) / 20)
beta_h = 1 / (1 + exp((55 - U) / 10))
h_steady = alpha_h / (alpha_h + beta_h)
h_time = {gate_time_factor!r} / ({kinetics_rate!r} * (alpha_h + beta_h))
dot(h) = (h_steady - h) / h_time
alpha_n = if(abs(55 - U) < 1e-5, 0.1 - (55 - U) / 200, 0.01 * (55 - U) / (exp((55 - U) / 10) - 1))
beta_n = 0.125 * exp((45 - U) / 80)
n_steady = alpha_n / (alpha_n + beta_n)
n_time = {gate_time_factor!r} / ({kinetics_rate!r} * (alpha_n + beta_n))
dot(n) = (n_steady - n) / n_time
x_steady = 1 / (1 + exp(0.15 * (-membrane.V - 50)))
x_time = {slow_gate_time!r} / {kinetics_rate!r}
dot(x) = (x_steady - x) / x_time
c_steady = {calcium_influx!r} * x * ({calcium_entry_potential!r} - membrane.V)
dot(c) = {kinetics_rate!r} * {calcium_rate!r} * (c_steady - c)
"""
"""Eqs. (20)-(22) and dV/dt of (11) on its own clock, in Myokit's language; numbers are filled in."""

PULSE = 50.0
"""Length of the stimulus [ms]."""

PASSES = 2800.0
"""Time in which a wave passes the cable [ms]."""


def missing() -> str | None:
    """What the comparison lacks, in words; None if it can be made."""
    if importlib.util.find_spec("myokit") is None:
        return "it is not installed (`pip install myokit`)."
    if not any(shutil.which(name) for name in COMPILERS):
        return f"it needs a C compiler, and none of {', '.join(COMPILERS)} is there."
    return None


class Cable:
    """The longitudinal sheet, undeformed, both ways. cells: 1 for a single cell, which does not conduct."""

    def __init__(self, cells: int, step: float, exact: bool = False) -> None:
        changes: dict[str, Any] = {"step.conduction": f"{step!r} ms", "step.wall": f"{8 * step!r} ms"}
        if cells > 1:
            changes |= {"grid.n_z": cells}
        self.configuration = Configuration().with_changes(changes)
        self.model: Model = build(self.configuration)
        self.cells, self.step, self.exact = cells, step, exact
        self.layer = self.model.longitudinal
        self.driven = 1 if cells == 1 else round(self.configuration.pacemaker.width / self.model.grid.cell_size)
        self.intensity = self.configuration.pacemaker.intensity
        self.rest = rest_state(self.layer.conductances[:, 0], self.model.cell, self.model.tables[0], exact)

    def ours(self, duration: float, every: float) -> tuple[Floats, Floats]:
        """(potential of the first cell at every `every` ms, first activation [ms] of all cells)."""
        n, model = self.cells, self.model
        potential, gates = np.full(n, self.rest.potential), np.repeat(np.array(self.rest.gates)[:, None], n, axis=1)
        first, last = np.full(n, np.nan), np.full(n, np.nan)
        scale = self.layer.diffusivity * 1e-3 / (24.0 * model.grid.cell_size) ** 2
        coefficient = np.full(n - 1, scale)
        conductances = np.repeat(self.layer.conductances[:, :1], n, axis=1)
        drive, nothing = np.where(np.arange(n) < self.driven, self.intensity, 0.0), np.zeros(n)
        stages = model.stages(self.layer, 1.0)
        steps = round(every / self.step)
        track = [self.rest.potential]
        for call in range(round(duration / every)):
            advance_sheet(
                SheetArrays(potential, gates, first, last),
                conductances,
                coefficient,
                Brought(drive if call * every < PULSE - 1e-9 else nothing, nothing),
                Steps(call * every, self.step, steps, 1, self.exact, ACTIVATION_LEVEL),
                stages,
                model.tables,
                model.cell,
            )
            track.append(float(potential[0]))
        return np.array(track), first

    def theirs(self) -> Any:
        """Myokit's simulation of the same."""
        import myokit

        cell = self.model.cell
        names = dict(zip(CHANNELS, (float(g) for g in self.layer.conductances[:, 0]), strict=True))
        h, n, x, c = (float(value) for value in self.rest.gates)
        filled = MODEL.format(
            **names,
            **cell._asdict(),
            potential=float(self.rest.potential),
            h=h,
            n=n,
            x=x,
            c=c,
            intensity=self.intensity,
        )
        protocol = myokit.Protocol()
        protocol.schedule(1.0, 0.0, PULSE)
        simulation = myokit.Simulation1d(myokit.parse_model(filled), protocol, ncells=self.cells, rl=True)
        simulation.set_step_size(self.step)
        simulation.set_paced_cells(self.driven)
        simulation.set_conductance(self.layer.diffusivity * 1e-3 * cell.capacitance / self.model.grid.cell_size**2)
        return simulation


def compare(repeats: int, full: bool) -> dict[str, Any]:
    """Cost on a cable at equal cells and steps, and agreement on a single cell at ever smaller steps."""
    import myokit

    cells, step, duration = 1000, 0.25, 1600.0 if full else 400.0
    ours, exact = Cable(cells, step), Cable(cells, step, exact=True)
    theirs = exact.theirs()

    def their_run() -> None:
        theirs.reset()
        theirs.run(duration, log=myokit.LOG_NONE)

    spent: dict[str, list[Any]] = {"ours": [], "exact": [], "theirs": []}
    for _ in range(repeats):
        spent["theirs"].append(once(their_run))
        spent["ours"].append(once(lambda: ours.ours(duration, 2.0)))
        spent["exact"].append(once(lambda: exact.ours(duration, 2.0)))
    cost = {name: Timing.of(found).cpu for name, found in spent.items()}
    node_steps = cells * duration / step
    speeds = _speeds(exact, theirs) if full else (None, None)
    labels = {"ours": "peristalsis, tables", "exact": "peristalsis, exponentials", "theirs": "Myokit"}
    cable = [
        [labels[name], 1e9 * cost[name] / node_steps, speeds[name == "theirs"]] for name in ("ours", "exact", "theirs")
    ]
    steps = (0.04, 0.02, 0.01, 0.005)
    differences = [_difference(one) for one in steps]
    return {
        "version": myokit.__version__,
        "cells": cells,
        "step": step,
        "duration": duration,
        "ratio": cost["theirs"] / cost["ours"],
        "ratio_exact": cost["theirs"] / cost["exact"],
        "cable": cable,
        "agreement": [list(pair) for pair in zip(steps, (d[0] for d in differences), strict=True)],
        "extrapolated": _extrapolated(differences),
    }


def _speeds(cable: Cable, simulation: Any) -> tuple[float | None, float | None]:
    """Speed of the wave [cm/s] in both."""
    return wave_speed(cable.model.grid.cells, cable.ours(PASSES, 2.0)[1] * 1e-3), their_speed(cable, simulation)


def their_speed(cable: Cable, simulation: Any) -> float | None:
    """Speed of Myokit's wave [cm/s], from the rise through the same level, between samples of 1 ms."""
    duration = PASSES
    z = cable.model.grid.cells
    simulation.reset()
    log = simulation.run(duration, log=["engine.time", "membrane.V"], log_interval=1.0)
    time = np.asarray(log["engine.time"])
    first = np.full(z.size, math.nan)
    for k in range(z.size):
        v = np.asarray(log["membrane.V", k])
        above = np.flatnonzero((v[:-1] < ACTIVATION_LEVEL) & (v[1:] >= ACTIVATION_LEVEL))
        if above.size:
            i = int(above[0])
            first[k] = time[i] + (time[i + 1] - time[i]) * (ACTIVATION_LEVEL - v[i]) / (v[i + 1] - v[i])
    return wave_speed(z, first * 1e-3)


def _difference(step: float) -> tuple[float, Floats]:
    """Largest difference of a stimulated cell's potential over 1.5 s, sampled every ms, and the difference itself."""
    duration = 1500.0
    cell = Cable(1, step, exact=True)
    simulation = cell.theirs()
    log = simulation.run(duration + 0.5, log=["engine.time", "membrane.V"], log_interval=1.0)
    times = np.arange(round(duration) + 1, dtype=float)
    theirs = np.interp(times, np.asarray(log["engine.time"]), np.asarray(log["membrane.V", 0]))
    fine = Cable(1, 0.005, exact=True).ours(duration, 1.0)[0]
    difference = theirs - fine
    return float(np.abs(difference).max()), difference


def _extrapolated(differences: list[tuple[float, Floats]]) -> float:
    """Largest difference at step zero, by Richardson's rule for a method of first order from the last two steps."""
    return float(np.abs(2.0 * differences[-1][1] - differences[-2][1]).max())
