"""Watches every upstroke of both layers and notes what it came from; the waves of the run are made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..control.graded import answer
from ..control.pacemaker import SourceState
from ..control.pulses import Pulse
from ..model.model import Model
from ..model.report import StepReport
from ..model.state import State
from ..names import WAVES
from ..results.waves import CONDUCTED, SPONTANEOUS, STIMULATED, Wave, waves

Floats = NDArray[np.float64]

LAYERS = ("longitudinal", "circular")
LATENCY = 0.3
"""A cell may rise this long after the end of its stimulus [s]."""


@dataclass
class UpstrokeRecorder:
    """Every rise through the activation level in the first column: time [s], cell, and origin (`waves.ORIGINS`).

    An upstroke is conducted if a neighbour, along or around the tube, rose within `LATENCY` before it; of the others
    those are stimulated where a pulse of pacemaker, rings, trigger or reflex was on. Cells where nothing rises cost
    one comparison a step.
    """

    times: dict[str, list[float]] = field(default_factory=lambda: {layer: [] for layer in LAYERS})
    cells: dict[str, list[int]] = field(default_factory=lambda: {layer: [] for layer in LAYERS})
    origins: dict[str, list[int]] = field(default_factory=lambda: {layer: [] for layer in LAYERS})
    _discharges: list[Pulse] = field(default_factory=list)
    _pulses: dict[str, list[Pulse]] = field(default_factory=lambda: {layer: [] for layer in LAYERS})

    def start(self, model: Model, state: State) -> None:
        """Nothing has risen before the first step."""

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Note what rose in this step."""
        if after.reflex.fired != before.reflex.fired:
            self._discharges += [pulse for pulse in after.reflex.excitation if pulse not in self._discharges]
        for number, source in enumerate(after.sources):
            if number >= len(before.sources) or source is not before.sources[number]:
                self._remember(source)
        begin = before.step * model.dt_wall * 1e3
        for layer, sheet in (("longitudinal", after.longitudinal), ("circular", after.circular)):
            last = sheet.last_activation
            # One or two cells rise in most steps: a loop costs less than arrays would.
            for cell in (last[:, 0] > begin).nonzero()[0].tolist():
                time = float(last[cell, 0]) * 1e-3
                origin = CONDUCTED
                if not _after_a_neighbour(last, cell):
                    origin = STIMULATED if self._stimulated(model, before, layer, cell, time) else SPONTANEOUS
                self.times[layer].append(time)
                self.cells[layer].append(cell)
                self.origins[layer].append(origin)
        return None

    def _remember(self, source: SourceState) -> None:
        """Keep the pulses of a source for longer than it does itself."""
        for layer, pulses in (("longitudinal", source.longitudinal), ("circular", source.circular)):
            known = self._pulses[layer]
            known += [pulse for pulse in pulses if pulse not in known]

    def waves(self, z: Floats) -> dict[str, list[Wave]]:
        """The waves of both layers so far. z: the cells [cm], (n_z,)."""
        return {
            layer: waves(
                z,
                np.array(self.times[layer], dtype=np.float64),
                np.array(self.cells[layer], dtype=np.int64),
                np.array(self.origins[layer], dtype=np.int64),
            )
            for layer in LAYERS
        }

    def _stimulated(self, model: Model, state: State, layer: str, cell: int, time: float) -> bool:
        if model.network is not None:  # it drives all cells
            return True
        since = time - LATENCY
        middle, half = float(model.grid.cells[cell]), 0.5 * model.grid.cell_size
        listed = model.stimuli_longitudinal if layer == "longitudinal" else model.stimuli_circular
        until = time + model.dt_wall  # a stimulus is the mean over its step, and acts from the step's beginning
        pulses = [pulse for pulse in self._pulses[layer] if pulse.begin <= until and pulse.end >= since]
        pulses += listed.between(since, until)
        if state.reflex.receptors is not None and _answered(model, state, layer, cell, since, until):
            return True
        if layer == "circular":
            pulses += [pulse for pulse in self._discharges if pulse.begin <= until and pulse.end >= since]
            begun = state.trigger.start[cell]
            if bool(((begun <= until) & (begun + state.trigger.duration[cell] >= since)).any()):
                return True
        elif model.pacemaker_cell is not None:
            driver = model.pacemaker_cell
            rose = float(state.pacemaker.last_activation[0, 0]) * 1e-3
            if driver.place <= middle + half and middle - half <= driver.place + driver.width and rose >= since:
                return True
        return any(pulse.low <= middle + half and middle - half <= pulse.high for pulse in pulses)


def _answered(model: Model, state: State, layer: str, cell: int, since: float, until: float) -> bool:
    """Whether receptors of the graded reflex excited a cell between two times [s]."""
    assert state.reflex.receptors is not None
    own = model.grid.cells[cell : cell + 1]
    brought = answer(model.reflex, state.reflex.receptors, model.grid.nodes, own, since, until)
    if brought is None:
        return False
    if layer == "circular":
        return bool(brought.excitation[0] > 0.0)
    return bool(brought.longitudinal[0] > 0.0) and model.reflex.longitudinal_intensity > 0.0


def _after_a_neighbour(last: Floats, cell: int) -> bool:
    """Whether a neighbour of a cell in the first column, along the tube or around it, rose shortly before.

    last: latest rises [ms], (n_z, n_theta).
    """
    own = last[cell, 0]
    earliest = own - 1e3 * LATENCY
    if cell > 0 and earliest < last[cell - 1, 0] < own:
        return True
    if cell < len(last) - 1 and earliest < last[cell + 1, 0] < own:
        return True
    return last.shape[1] > 1 and bool(earliest < last[cell, 1] < own or earliest < last[cell, -1] < own)


class Found(NamedTuple):
    """A wave and its layer: what the outputs over waves are read from."""

    wave: Wave
    layer: str


def wave_columns(found: Mapping[str, Sequence[Wave]]) -> dict[str, NDArray[Any]]:
    """The waves of both layers as arrays of `names.WAVES`, in the order of time."""
    rows = sorted((Found(wave, layer) for layer, own in found.items() for wave in own), key=lambda one: one.wave.time)
    columns: dict[str, NDArray[Any]] = {}
    for output in WAVES:
        assert output.value is not None
        columns[output.name] = np.array([output.value(row) for row in rows], dtype=object if not output.unit else float)
    return columns
