"""Watches every upstroke of both layers and notes what it came from; the waves of the run are made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .control.pulses import Pulse
from .control.sequence import LOCAL_RULES
from .model.model import Model
from .model.state import SheetState, State
from .model.step import StepReport
from .waves import CONDUCTED, SPONTANEOUS, STIMULATED, Wave, waves

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

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

    times: dict[str, list[Floats]] = field(default_factory=lambda: {layer: [] for layer in LAYERS})
    cells: dict[str, list[Indices]] = field(default_factory=lambda: {layer: [] for layer in LAYERS})
    origins: dict[str, list[Indices]] = field(default_factory=lambda: {layer: [] for layer in LAYERS})
    _discharges: list[Pulse] = field(default_factory=list)

    def start(self, model: Model, state: State) -> None:
        """Nothing has risen before the first step."""

    def see(self, model: Model, before: State, after: State, report: StepReport) -> str | None:
        """Note what rose in this step."""
        if after.reflex.fired != before.reflex.fired:
            self._discharges += after.reflex.excitation
        begin = before.step * model.dt_wall * 1e3
        for layer, sheet in zip(LAYERS, (after.longitudinal, after.circular), strict=True):
            rose = np.flatnonzero(sheet.last_activation[:, 0] > begin)
            if rose.size:
                times = sheet.last_activation[rose, 0] * 1e-3
                self.times[layer].append(times)
                self.cells[layer].append(rose)
                self.origins[layer].append(self._origins(model, before, sheet, layer, rose, times))
        return None

    def waves(self, z: Floats) -> dict[str, list[Wave]]:
        """The waves of both layers so far. z: the cells [cm], (n_z,)."""
        found = {}
        for layer in LAYERS:
            if not self.times[layer]:
                found[layer] = []
                continue
            columns = (np.concatenate(parts[layer]) for parts in (self.times, self.cells, self.origins))
            found[layer] = waves(z, *columns)
        return found

    def _origins(
        self, model: Model, before: State, sheet: SheetState, layer: str, rose: Indices, times: Floats
    ) -> Indices:
        origins = np.full(rose.size, CONDUCTED)
        first = ~_after_a_neighbour(sheet.last_activation, rose)
        for k in np.flatnonzero(first):
            stimulated = self._stimulated(model, before, layer, int(rose[k]), float(times[k]))
            origins[k] = STIMULATED if stimulated else SPONTANEOUS
        return origins

    def _stimulated(self, model: Model, state: State, layer: str, cell: int, time: float) -> bool:
        since = time - LATENCY
        middle, half = float(model.grid.cells[cell]), 0.5 * model.grid.cell_size
        trains = model.longitudinal_trains if layer == "longitudinal" else model.circular_trains
        pulses = [pulse for train in trains for pulse in train.between(since, time)]
        if layer == "circular":
            pulses += [pulse for pulse in self._discharges if pulse.begin <= time and pulse.end >= since]
            begun = state.trigger.start[cell] if model.trigger.rule in LOCAL_RULES else np.array([-np.inf])
            if bool(((begun <= time) & (begun + model.trigger.duration >= since)).any()):
                return True
        elif model.pacemaker_cell is not None:
            driver = model.pacemaker_cell
            rose = float(state.pacemaker.last_activation[0, 0]) * 1e-3
            if driver.place <= middle + half and middle - half <= driver.place + driver.width and rose >= since:
                return True
        return any(pulse.low <= middle + half and middle - half <= pulse.high for pulse in pulses)


def _after_a_neighbour(last: Floats, rose: Indices) -> NDArray[np.bool_]:
    """Whether a neighbour, along the tube or around it, rose shortly before; (rose.size,).

    last: latest rises [ms], (n_z, n_theta).
    """
    own = last[rose, 0]
    found = np.zeros(rose.size, dtype=np.bool_)
    neighbours = [last[np.maximum(rose - 1, 0), 0], last[np.minimum(rose + 1, len(last) - 1), 0]]
    if last.shape[1] > 1:
        neighbours += [last[rose, 1], last[rose, -1]]
    for other in neighbours:
        found |= (other < own) & (other > own - 1e3 * LATENCY)
    return found


def wave_columns(found: Mapping[str, Sequence[Wave]]) -> dict[str, NDArray[Any]]:
    """The waves of both layers as arrays of `names.WAVES`, in the order of time."""
    rows = sorted(((wave, layer) for layer, own in found.items() for wave in own), key=lambda row: row[0].time)
    columns: dict[str, NDArray[Any]] = {
        f"wave_{name}": np.array([getattr(wave, name) for wave, _ in rows], dtype=float)
        for name in ("time", "start", "end", "speed")
    }
    texts = {"direction": [wave.direction for wave, _ in rows], "origin": [wave.origin for wave, _ in rows]}
    texts["layer"] = [layer for _, layer in rows]
    return columns | {f"wave_{name}": np.array(column, dtype=object) for name, column in texts.items()}
