"""The sheet as a whole: rest, guards, activation times, columns, shunt."""

import numpy as np
import pytest

from peristalsis.model.model import Model
from peristalsis.model.state import State
from peristalsis.tissue.records import Brought, SheetArrays, Steps
from peristalsis.tissue.sheet import advance_sheet
from verification.exact.runs import IDLE, started

MODEL, STATE = started(IDLE, {"pellet.enabled": False, "grid.n_z": 60, "grid.n_z_wall": 8})


class Sheet:
    """The longitudinal sheet of a model, advanced alone on the undeformed tube."""

    def __init__(self, model: Model = MODEL, state: State = STATE, columns: int = 1) -> None:
        self.model, self.columns = model, columns
        layer, sheet = model.longitudinal, state.longitudinal
        self.potential = np.repeat(sheet.potential.ravel(), columns)
        self.gates = np.repeat(sheet.gates.reshape(4, -1), columns, axis=1)
        self.conductances = np.repeat(layer.conductances, columns, axis=1)
        self.first, self.latest = np.full((2, self.potential.size), np.nan)
        self.stages = model.stages(layer, np.ones((8, 1)))
        faces = (model.grid.n_z - 1) * columns
        self.coefficient = np.full(faces, layer.diffusivity * 1e-3 / (24.0 * model.grid.cell_size) ** 2)

    def advance(
        self, steps: int, drive: np.ndarray | float = 0.0, shunt: np.ndarray | float = 0.0, time: float = 0.0
    ) -> int:
        size = self.potential.size
        return advance_sheet(
            SheetArrays(self.potential, self.gates, self.first, self.latest),
            self.conductances,
            self.coefficient,
            Brought(
                np.broadcast_to(np.asarray(drive, float), (size,)).copy(),
                np.broadcast_to(np.asarray(shunt, float), (size,)).copy(),
            ),
            Steps(time, self.model.dt_cell, steps, self.columns, False, -40.0),
            self.stages,
            self.model.tables,
            self.model.cell,
        )


def test_resting_sheet_stays_at_rest() -> None:
    """Nothing moves before the pacemaker fires: 1e-9 mV over a second, with the tables that found the rest."""
    sheet = Sheet()
    before = sheet.potential.copy()
    assert sheet.advance(4000) == -1
    assert np.abs(sheet.potential - before).max() <= 1e-9


def test_pulse_starts_a_wave_that_is_timed() -> None:
    """Activation times rise away from the stimulus; where nothing has come yet they are nan."""
    sheet = Sheet()
    drive = np.where(np.arange(60) < 2, 4.0, 0.0)
    sheet.advance(200, drive)
    sheet.advance(1200, time=50.0)
    reached = np.isfinite(sheet.first)
    assert 4 < reached.sum() < 60
    assert np.all(np.diff(sheet.first[reached]) > 0.0)
    assert np.array_equal(sheet.first[reached], sheet.latest[reached])
    assert np.all(reached[: reached.sum()]), "the wave is one piece"


def test_activation_time_is_finer_than_the_step() -> None:
    """Interpolated in the step: the same crossing on steps four times shorter, to a hundredth of a millisecond."""
    times = []
    for step in ("0.25 ms", "0.0625 ms"):
        sheet = Sheet(
            *started(IDLE, {"pellet.enabled": False, "grid.n_z": 8, "grid.n_z_wall": 8, "step.conduction": step})
        )
        sheet.advance(round(50.0 / sheet.model.dt_cell), 2.0)
        times.append(float(sheet.first[0]))
    assert times[0] == pytest.approx(times[1], abs=0.01)
    assert 0.0 < times[0] < 50.0


def test_columns_of_a_uniform_ring_agree_bit_for_bit() -> None:
    """The axisymmetric model is the same code on one column."""
    drive = np.where(np.arange(60) < 2, 4.0, 0.0)
    one, three = Sheet(), Sheet(columns=3)
    one.advance(400, drive)
    three.advance(400, np.repeat(drive, 3))
    assert np.array_equal(three.potential.reshape(60, 3), np.repeat(one.potential[:, None], 3, axis=1))


def test_shunt_holds_the_cell_down() -> None:
    """Eq. (26): an opened potassium conductance hyperpolarises, and keeps the same pulse from making a spike."""
    free, shunted = Sheet(), Sheet()
    free.advance(200, 1.0)
    towards_potassium = 0.1 * -75.0
    shunted.advance(200, 1.0 + towards_potassium, 0.1)
    assert free.potential.max() > 0.0
    assert shunted.potential.max() < -50.0
    quiet = Sheet()
    quiet.advance(200, towards_potassium, 0.1)
    assert quiet.potential.max() < STATE.longitudinal.potential.min() - 1.0


@pytest.mark.parametrize("bad", [np.nan, 1e9])
def test_bad_potential_is_reported_with_its_cell(bad: float) -> None:
    """R5: a sheet poisoned at one cell says which, and stores nothing."""
    sheet = Sheet()
    sheet.potential[17] = bad
    before = sheet.potential.copy()
    assert sheet.advance(10) == 17
    assert np.array_equal(sheet.potential, before, equal_nan=True)


def test_stimulus_beyond_reason_is_reported() -> None:
    assert Sheet().advance(400, 1e4) >= 0
