"""What a run costs, in counts: iterations, assemblies, solves. Time is measured by `make bench`, never here."""

import numpy as np
import pytest

from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.model import equilibrium
from peristalsis.model.initial import initial_state
from peristalsis.model.report import StepReport
from peristalsis.model.step import advance
from peristalsis.tissue.records import Brought, SheetArrays, Steps
from peristalsis.tissue.sheet import MARGIN, QUIET_GATE, QUIET_POTENTIAL, advance_sheet, restless
from verification.exact.runs import march

SHIPPED = {"grid.n_z": 400, "grid.n_z_wall": 400}


def costs(seconds: float) -> list[StepReport]:
    """Reports of the baseline at shipped steps and tolerances, on a smaller grid."""
    model, state, _ = initial_state(build(Configuration().with_changes(SHIPPED)))
    reports = []
    for _ in range(round(seconds / model.dt_wall)):
        state, report = advance(model, state)
        reports.append(report)
    return reports


def test_a_step_takes_few_iterations() -> None:
    """Measured 4.1, 7.5 and 1.23 in the first 0.8 s, the hardest; a guess or line search gone wrong costs more."""
    reports = costs(0.8)
    steps = len(reports)
    assert sum(r.newton_iterations for r in reports) <= 4.7 * steps
    assert sum(r.assemblies for r in reports) <= 8.6 * steps
    assert sum(r.wall_solves for r in reports) <= 1.4 * steps


def test_what_stood_in_the_workspace_does_not_matter() -> None:
    """The kept tables of the solver are work space: filled with nan, they give the same bits."""
    taken = march(0.1)
    before = taken.last
    once, _ = advance(taken.model, before)
    for table in equilibrium.workspace(before.wall.position.shape[0]):
        table[:] = np.nan
    twice, _ = advance(taken.model, before)
    assert np.array_equal(once.wall.position, twice.wall.position)
    assert np.array_equal(once.wall.contact, twice.wall.contact)
    assert once.pellet == twice.pellet


def test_waiting_cells_change_nothing_that_matters() -> None:
    """Tissue that waits for the wave: 1e-6 mV of difference to a sheet kept awake by a trickle at its far end."""
    model, state, _ = initial_state(build(Configuration().with_changes({"grid.n_z": 400, "pellet.enabled": False})))
    layer, cells = model.longitudinal, model.grid.cells
    coefficient = np.full(cells.size - 1, layer.diffusivity * 1e-3 / (24.0 * model.grid.cell_size) ** 2)
    stages = model.stages(layer, 1.0)
    found = []
    for trickle in (0.0, 1e-8):
        potential = state.longitudinal.potential.ravel().copy()
        gates = state.longitudinal.gates.reshape(4, -1).copy()
        first, last = np.full((2, cells.size), np.nan)
        for call in range(160):
            time = 5.0 * call
            drive = np.where((cells < 0.3) & (time < 50.0), 2.0, 0.0)
            drive[-1] = trickle
            verdict = advance_sheet(
                SheetArrays(potential, gates, first, last),
                layer.conductances,
                coefficient,
                Brought(drive, np.zeros(cells.size)),
                Steps(time, model.dt_cell, model.substeps, 1, False, -40.0),
                stages,
                model.tables,
                model.cell,
            )
            assert verdict == -1
        found.append((potential, first))
    (waited, reached), (awake, reached_too) = found
    assert 50 < np.isfinite(reached).sum() < 350, "the wave is on its way"
    assert np.abs(waited - awake).max() <= 1e-6
    assert np.nanmax(np.abs(reached - reached_too)) <= 1e-6
    resting = state.longitudinal.potential[-1, 0]
    assert waited[-20] == resting, "what waits keeps every bit"
    assert awake[-1] != resting


@pytest.mark.parametrize("columns", [1, 3])
def test_as_many_rings_before_as_behind_a_change_are_advanced(columns: int) -> None:
    """Whole rings, a margin on either side, none beyond the ends: what the potential or any gate asks for."""
    rings, still = 60, np.zeros((4, 60 * columns))
    last = columns - 1

    def awake(*cells: tuple[int, int], gate: int | None = None) -> tuple[int, int]:
        """First and last ring that are advanced when these cells, (ring, column), change."""
        places = [ring * columns + column for ring, column in cells]
        change, gates = np.zeros(rings * columns), still.copy()
        if gate is None:
            change[places] = -2.0 * QUIET_POTENTIAL
        else:
            gates[gate, places] = 2.0 * QUIET_GATE
        low, high = restless(change, gates, still, gate is not None, columns)
        assert low % columns == high % columns == 0
        return low // columns, high // columns - 1

    assert awake((20, last), (30, 0)) == (20 - MARGIN, 30 + MARGIN)
    for gate in range(4):
        assert awake((25, 0), gate=gate) == (25 - MARGIN, 25 + MARGIN)
    assert awake((2, 0), (57, last)) == (0, rings - 1)
    assert restless(np.full(rings * columns, QUIET_POTENTIAL), still, still, True, columns) == (0, 0)
