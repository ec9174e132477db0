"""Wall and tissue between cells and elements: drive and stretch reconstructed within them, Eqs. (86)-(88)."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis import Simulation, scenarios
from peristalsis.geometry.grid import SUB_CELLS, Grid
from peristalsis.inputs.build import build
from peristalsis.model.model import Model
from peristalsis.model.muscle import drive_of_cells, drive_of_sub_cells
from peristalsis.model.schemes.column import muscle_drive
from peristalsis.model.state import SheetState
from peristalsis.numerics.transfer import average, average_within, reconstruction
from verification.exact.runs import IDLE, configured, started

PLAIN = {"grid.exchange": "averages"}
FINER = {"grid.exchange": "reconstructed"}


def averages(degree: int, edges: np.ndarray) -> np.ndarray:
    """Averages of x^degree between edges, (n, 1)."""
    return (np.diff(edges ** (degree + 1)) / (degree + 1) / np.diff(edges))[:, None]


@given(st.integers(1, 5), st.integers(6, 20), st.integers(0, 2**32 - 1))
def test_polynomials_are_reconstructed_exactly(points: int, n: int, seed: int) -> None:
    """Averages of a polynomial of degree points - 1 give its averages over any stretch, and its values anywhere."""
    rng = np.random.default_rng(seed)
    ends = np.sort(rng.uniform(0.0, n, 8)).reshape(4, 2)
    found = np.empty((4, 1))
    for degree in range(points):
        source = averages(degree, np.linspace(0.0, 1.0, n + 1))
        average(reconstruction(n, ends[:, 0], ends[:, 1], points), source, found)
        wanted = np.array([averages(degree, pair / n)[0, 0] for pair in ends])
        assert found[:, 0] == pytest.approx(wanted, abs=1e-11)
        average(reconstruction(n, ends[:, 0], ends[:, 0], points), source, found)
        assert found[:, 0] == pytest.approx((ends[:, 0] / n) ** degree, abs=1e-11)


def test_parts_of_a_cell_have_its_average() -> None:
    """Whatever the field, so what the cells hold reaches the wall whole."""
    values = np.random.default_rng(3).normal(size=(30, 1))
    fine = np.empty((30 * SUB_CELLS, 1))
    average(Grid(3.0, 30, 20).cells_to_sub_cells, values, fine)
    assert fine.reshape(30, SUB_CELLS).mean(axis=1) == pytest.approx(values[:, 0], rel=1e-12, abs=1e-12)


def test_a_jump_is_not_overshot() -> None:
    """Stretch stays within that of the elements it is made from, so it is never negative."""
    grid = Grid(3.0, 50, 30)
    jump, found = np.where(np.arange(30) < 15, 0.05, 2.0)[:, None], np.empty((49, 1))
    average_within(grid.element_averages_to_faces, jump, found)
    assert found.min() == 0.05
    assert found.max() == 2.0
    average(grid.element_averages_to_faces, jump, found)
    assert found.min() < 0.05 < 2.0 < found.max(), "without bounds it would"


def conduction_error(elements: int, reconstructed: bool) -> float:
    """Largest relative error of 1/stretch at the faces, for elements that shorten as they do behind a front."""
    grid = Grid(1.0, 300, elements)
    width = 0.08
    edges = width * np.log(np.cosh((grid.nodes - 0.5) / width))
    stretch = (1.0 - 0.45 * np.diff(edges) / np.diff(grid.nodes))[:, None]
    faces = np.arange(1, 300) / 300.0
    exact = 1.0 / (1.0 - 0.45 * np.tanh((faces - 0.5) / width))
    found = np.empty((299, 1))
    if reconstructed:
        average_within(grid.element_averages_to_faces, stretch, found)
    else:
        average(grid.elements_to_faces, stretch, found)
    return float(np.abs(1.0 / found[20:-20, 0] / exact[20:-20] - 1.0).max())


def test_conduction_sees_the_stretch_to_fourth_order() -> None:
    """Between elements that are known by their averages; straight lines between their middles have second order."""
    coarse, fine = conduction_error(60, True), conduction_error(120, True)
    assert math.log2(coarse / fine) == pytest.approx(4.0, abs=0.4)
    assert math.log2(conduction_error(60, False) / conduction_error(120, False)) == pytest.approx(2.0, abs=0.4)
    assert coarse < 0.2 * conduction_error(60, False)


def foot(model: Model, sheet: SheetState, length: float, at: float) -> SheetState:
    """The sheet with an exponential foot that passes the threshold of muscle at a place [cm]."""
    edges = np.linspace(0.0, model.grid.length, model.grid.n_z + 1)
    rest = -70.0
    height = (model.longitudinal.threshold - rest) * length * np.exp(-(edges - at) / length)
    return replace(sheet, potential=(rest - np.diff(height) / model.grid.cell_size)[:, None])


def drive_error(cells: int, changes: dict[str, str]) -> float:
    """Error of the drive of all half elements around the foot, summed and over the drive there, worst of 8 places."""
    model, state = started(IDLE, changes, {"grid.n_z": cells, "grid.n_z_wall": 500, "wall.length": "1 cm",
                                            "pellet.enabled": False, "output.probes": []})  # fmt: skip
    length, gap = 0.02, model.longitudinal.threshold + 70.0
    edges = np.linspace(0.0, 1.0, 1001)
    worst = 0.0
    for k in range(8):
        at = 0.6 + k / 8 / cells
        found = muscle_drive(model, model.circular, foot(model, state.circular, length, at))[:, 0]
        primitive = np.where(edges < at, -gap * length * np.exp(-(edges - at) / length) - gap * edges, 0.0)
        primitive[edges >= at] = -gap * length - gap * at
        exact = np.diff(primitive) / np.diff(edges) * float(np.max(model.circular.force_factor))
        near = (edges[:-1] > at - 0.03) & (edges[:-1] < at + 0.03)
        worst = max(worst, float(np.abs(found - exact)[near].sum() / exact[near].sum()))
    return worst


def test_muscle_sees_the_foot_and_not_a_staircase() -> None:
    """Drive of an exponential foot with a threshold, in closed form; cells of 0.7 foot lengths."""
    assert drive_error(70, FINER) < 0.25 * drive_error(70, PLAIN)
    assert drive_error(70, FINER) < 0.08


def test_parts_of_cells_have_the_drive_of_the_cell_where_it_follows_from_states() -> None:
    """Activations that read calcium, or keep states of muscle, know them for whole cells."""
    cell = {"tissue.cell": "corrias_buist_2007", "tissue.activation": "calcium_hill"}
    model, state = started(IDLE, FINER, cell, {"grid.n_z": 40, "grid.n_z_wall": 30})
    raised = replace(state.circular, gates=state.circular.gates * np.linspace(1.0, 9.0, 40)[None, :, None])
    driven = drive_of_cells(model.circular, raised)
    assert np.ptp(driven) > 0.0
    assert np.array_equal(drive_of_sub_cells(model.circular, raised, model.grid), np.repeat(driven, SUB_CELLS, axis=0))


def test_one_pull_for_an_element_along_and_two_around() -> None:
    """Stretch and rate along the muscle belong to an element; the two corners differ around alone."""
    model, state = started(IDLE, FINER, {"grid.n_z": 100, "grid.n_z_wall": 80})
    rng = np.random.default_rng(5)
    sheet = replace(state.longitudinal, potential=rng.uniform(-60.0, 10.0, (100, 1)))
    along = muscle_drive(model, model.longitudinal, sheet)[:, 0].reshape(-1, 2)
    around = muscle_drive(model, model.circular, sheet)[:, 0].reshape(-1, 2)
    assert np.array_equal(along[:, 0], along[:, 1])
    assert np.abs(around[:, 0] - around[:, 1]).max() > 1.0
    strength = float(np.max(model.longitudinal.force_factor) / np.max(model.circular.force_factor))
    assert along[:, 0] == pytest.approx(strength * around.mean(axis=1), rel=1e-12)


def arrival(elements: int, exchange: dict[str, str]) -> float:
    """When the longitudinal wave arrives at 1.5 cm of a tube without pellet [s]."""
    changes = {
        "grid.n_z": 400,
        "grid.n_z_wall": elements,
        "wall.length": "4 cm",
        "pellet.enabled": False,
        "output.probes": [],
    }
    run = Simulation(configured(changes, exchange, {"run.duration": "0.5 s"})).run()
    times = run.arrays["activation_longitudinal"].ravel()
    found = float(times[150])
    assert math.isfinite(found)
    return found


def test_the_wave_on_a_coarse_wall_runs_as_on_a_fine_one() -> None:
    """The grid of the wall reaches the wave through the stretch at its foot alone; reconstructed, it hardly does."""
    fine = arrival(640, FINER)
    assert abs(arrival(160, FINER) - fine) < 0.2 * abs(arrival(160, PLAIN) - fine)


@pytest.mark.parametrize("elsewhere", [{"grid.n_theta": 8}, {"solver.integrator": "explicit"}])
def test_elsewhere_wall_and_tissue_exchange_averages(elsewhere: dict[str, object]) -> None:
    """The shipped choice is of one column, stepped implicitly; the explicit scheme conducts as it stands, too."""
    model = build(configured({"grid.exchange": "reconstructed", "tissue.front_correction": "measured"}, elsewhere))
    assert not model.reconstructs
    assert model.longitudinal.front_corrected == ("grid.n_theta" in elsewhere)


BEFORE = {
    "grid.n_z": 1000,
    "grid.n_z_wall": 800,
    "grid.exchange": "averages",
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "tissue.front_correction": "none",
    "trigger.timing": "step",
    "solver.surface_tolerance": 1e-8,
    "solver.surface_newton": "plain",
    "solver.surface_modes": 0,
}
"""The numerics of the versions before these choices."""


def test_configurations_of_before_keep_their_digest() -> None:
    """So their kept runs and checkpoints are found again."""
    digest = "fe3f0f40df9263c1a3f9ed7c6a26c43d98c160f2e251f42484857318ef9c0ed5"
    assert scenarios.configuration("baseline", changes=BEFORE).digest() == digest
    assert configured(PLAIN).digest() != configured(FINER).digest()
