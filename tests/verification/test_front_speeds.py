"""Fronts along the tube and around it: anisotropy, stretch, and what coarse columns cost, E6 and Eq. (37)."""

import numpy as np
import pytest

from peristalsis.numerics.stabilised import coefficients, stages_for
from peristalsis.tissue.bidomain import surface_operator
from peristalsis.tissue.conduction import largest_eigenvalue
from peristalsis.tissue.front_correction import correction_table, raised_resistance
from peristalsis.tissue.records import Brought, SheetArrays, Steps
from peristalsis.tissue.resolution import (
    CELLS_PER_FOOT,
    RELATIVE_SPEED,
    columns_for_speed,
    front_foot,
    relative_front_speed,
)
from peristalsis.tissue.surface import Conductivities, SurfaceSizes, stability_rate
from peristalsis.tissue.surface_sheet import advance_surface_sheet
from verification.exact.runs import IDLE, started
from verification.exact.surface import CIRCULAR, DIFFUSIVITY, LONGITUDINAL

TABLE = correction_table(0.25)
"""Of the correction, for the shipped step of conduction."""

MODEL, STATE = started(IDLE, {"pellet.enabled": False, "grid.n_z": 8, "grid.n_z_wall": 8})


def front_speed(
    direction: str,
    n: int,
    cell: float,
    kind: Conductivities,
    axial: float = 1.0,
    hoop: float = 1.0,
    width: int = 4,
    limit: float = 20000.0,
) -> float | None:
    """Speed of a plane front on n cells of this size along z, or around a ring half of n to either side [cm/s].

    None if it does not come through within the limit [ms]. In the other direction the sheet is `width` such cells.
    """
    shape = (n, width) if direction == "z" else (width, n)
    size = n * width
    layer, sheet = MODEL.longitudinal, STATE.longitudinal
    operator = surface_operator(
        DIFFUSIVITY, kind, SurfaceSizes(cell, cell), np.full((shape[0] - 1, shape[1]), axial), np.full(shape, hoop)
    )
    rate = MODEL.cell.kinetics_rate * float(layer.conductances.sum(axis=0).max()) / MODEL.cell.capacitance
    rate += largest_eigenvalue(DIFFUSIVITY * 1e-3, cell) / axial
    stages = coefficients(max(stages_for(MODEL.dt_cell * stability_rate(rate, operator.ring_rate)), 2))
    potential = np.full(size, sheet.potential[0, 0])
    gates = np.repeat(sheet.gates[:, :1, 0], size, axis=1)
    conductances = np.repeat(layer.conductances[:, :1], size, axis=1)
    first, last = np.full((2, size), np.nan)
    place = np.arange(n) if direction == "z" else np.minimum(np.arange(n), n - np.arange(n))
    length = n if direction == "z" else n // 2
    driven = (place * cell < max(0.1, 2.5 * cell)).astype(float) * 2.0
    drive = np.broadcast_to(driven[:, None] if direction == "z" else driven, shape).ravel()
    time = 0.0
    while time < limit:
        now = drive if time < 50.0 else np.zeros(size)
        verdict = advance_surface_sheet(
            SheetArrays(potential, gates, first, last),
            conductances,
            operator,
            Brought(now, np.zeros(size)),
            Steps(time, MODEL.dt_cell, 40, 1, False, -40.0),
            stages,
            MODEL.tables,
            MODEL.cell,
        )
        assert verdict == -1
        time += 40.0 * MODEL.dt_cell
        times = first.reshape(shape)[:, 0] if direction == "z" else first.reshape(shape)[0]
        watched = np.arange(round(0.5 * length), round(0.9 * length))
        if np.isfinite(times[watched]).all():
            return float(np.polyfit(1e-3 * times[watched], watched * cell, 1)[0])
    return None


@pytest.mark.slow
@pytest.mark.parametrize(("axial", "hoop"), [(1.0, 1.0), (0.7, 1.4)])
@pytest.mark.parametrize(("kind", "ratio"), [(LONGITUDINAL, 8.8), (CIRCULAR, 1.0)], ids=["longitudinal", "circular"])
def test_speeds_along_and_around_go_with_the_root_of_the_effective_conductivity(
    kind: Conductivities, ratio: float, axial: float, hoop: float
) -> None:
    """E6: on fine cells c_z/c_s = sqrt(g_z/g_s) with the series conductivities, each over its stretch."""
    assert kind.effective_axial / kind.effective_around == pytest.approx(ratio)
    along = front_speed("z", 300, 0.35 * front_foot(DIFFUSIVITY / axial), kind, axial, hoop)
    around = front_speed("theta", 600, 0.35 * front_foot(DIFFUSIVITY / ratio / hoop), kind, axial, hoop)
    assert along is not None
    assert around is not None
    assert along / around == pytest.approx(np.sqrt(ratio * hoop / axial), rel=0.005)
    assert along == pytest.approx(4.2 / np.sqrt(axial), rel=0.005)


@pytest.mark.parametrize("per_foot", [0.7, 2.0, 6.0, pytest.param(11.0, marks=pytest.mark.slow)])
def test_predicted_slowness_of_coarse_columns(per_foot: float) -> None:
    """The warning's law, measured anew with the bidomain across the fibres; 11 feet is the layer at 64 columns."""
    foot = front_foot(DIFFUSIVITY / 8.8)
    fine = 4.2014 / np.sqrt(8.8)
    speed = front_speed("theta", max(60, round(160 / per_foot)), per_foot * foot, LONGITUDINAL, width=2)
    assert speed is not None
    assert speed / fine == pytest.approx(relative_front_speed(per_foot * foot, foot), abs=0.01)


@pytest.mark.slow
def test_very_coarse_columns_stop_the_front() -> None:
    """Beyond the law's end nothing passes, and the law says so."""
    foot = front_foot(DIFFUSIVITY / 8.8)
    assert front_speed("theta", 60, 14.0 * foot, LONGITUDINAL, width=2, limit=5000.0) is None
    assert relative_front_speed(14.0 * foot, foot) == 0.0


def test_columns_that_a_point_stimulus_needs() -> None:
    """About a thousand for the longitudinal layer, a third of it for the circular one; more on distended wall."""
    radius, foot = 0.795, front_foot(DIFFUSIVITY / 8.8)
    needed = columns_for_speed(radius, foot)
    assert 1000 <= needed <= 1150
    assert relative_front_speed(2.0 * np.pi * radius / needed, foot) >= 0.99
    assert relative_front_speed(2.0 * np.pi * radius / (needed - 2), foot) < 0.99 + 1e-4
    assert columns_for_speed(radius, front_foot(DIFFUSIVITY)) == pytest.approx(needed / np.sqrt(8.8), abs=1.0)
    assert columns_for_speed(radius, front_foot(DIFFUSIVITY / 8.8 / 1.21)) == pytest.approx(1.1 * needed, abs=2.0)
    assert front_foot(DIFFUSIVITY, 0.5) == pytest.approx(0.5 * front_foot(DIFFUSIVITY))


@pytest.mark.parametrize("per_foot", [1.2, 4.0, 11.0, pytest.param(2.4, marks=pytest.mark.slow)])
def test_corrected_front_around_the_ring_has_its_exact_speed(per_foot: float) -> None:
    """Eq. (85), with the bidomain across the fibres; without it the front on 11 feet is four times too slow."""
    foot = front_foot(DIFFUSIVITY / 8.8)
    hoop = float(raised_resistance(np.array([1.0]), per_foot, TABLE)[0])
    speed = front_speed("theta", max(60, round(160 / per_foot)), per_foot * foot, LONGITUDINAL, hoop=hoop, width=2)
    assert speed == pytest.approx(4.2014 / np.sqrt(8.8), rel=0.005)


@pytest.mark.slow
def test_corrected_front_along_the_tube_has_its_exact_speed() -> None:
    """400 cells on 10 cm are 1.2 feet long, and a front on them is 7 % slow."""
    foot = front_foot(DIFFUSIVITY)
    axial = float(raised_resistance(np.array([1.0]), 1.2, TABLE)[0])
    assert front_speed("z", 120, 1.2 * foot, CIRCULAR) == pytest.approx(0.93 * 4.2014, rel=0.005)
    assert front_speed("z", 120, 1.2 * foot, CIRCULAR, axial=axial) == pytest.approx(4.2014, rel=0.005)


def test_correction_undoes_the_law_and_keeps_order_four() -> None:
    """A front on conduction raised by f is faster by its root on cells that are fewer feet long by it."""
    for cells, speed in zip(CELLS_PER_FOOT[1:], RELATIVE_SPEED[1:], strict=True):
        factor = 1.0 / float(raised_resistance(np.array([1.0]), cells / speed, TABLE)[0])
        assert np.sqrt(factor) * speed == pytest.approx(1.0, rel=2e-4)
    fine = [1.0 / float(raised_resistance(np.array([1.0]), feet, TABLE)[0]) - 1.0 for feet in (0.2, 0.1)]
    assert fine[0] / fine[1] == pytest.approx(16.0, rel=1e-6)


def test_correction_depends_on_cells_in_feet_alone() -> None:
    """Stretch makes a foot longer by its root; what does not conduct still does not; better faces stay better."""
    resistance = np.array([[0.5, 1.0, 4.0], [20.0, np.inf, 1e-3]])
    found = raised_resistance(resistance, 1.5, TABLE)
    alone = np.array([raised_resistance(np.ones(1), 1.5 * np.sqrt(one), TABLE)[0] for one in resistance.ravel()[:4]])
    assert found.ravel()[:4] == pytest.approx(resistance.ravel()[:4] * alone, rel=1e-14)
    assert np.isinf(found[1, 1])
    ordered = raised_resistance(np.geomspace(1e-3, 1e4, 200), 1.0, TABLE)
    assert np.all(np.diff(ordered) > 0.0)
