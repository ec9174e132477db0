"""Conduction on the whole surface: one column again, conservation, symmetry, stability, the driver, Eqs. (11), (31)."""

import numpy as np
import pytest

from peristalsis import scenarios
from peristalsis.inputs.build import build
from peristalsis.model.scheme import Ahead
from peristalsis.model.schemes.surface import conduction
from peristalsis.numerics.stabilised import coefficients, stages_for
from peristalsis.tissue.bidomain import FULL, Bidomain, Elliptic, surface_operator
from peristalsis.tissue.conduction import diffuse, fill_ghosts, largest_eigenvalue
from peristalsis.tissue.records import Brought, SheetArrays, Steps
from peristalsis.tissue.sheet import advance_sheet
from peristalsis.tissue.surface import Conductivities, Monodomain, SurfaceOperator, SurfaceSizes, stability_rate
from peristalsis.tissue.surface_sheet import advance_surface_sheet
from verification.exact.runs import IDLE, started
from verification.exact.surface import CIRCULAR, DIFFUSIVITY, LONGITUDINAL, Surface, apply_surface

MODEL, STATE = started(IDLE, {"pellet.enabled": False, "grid.n_z": 60, "grid.n_z_wall": 8})
KINDS = {"monodomain": CIRCULAR, "bidomain": LONGITUDINAL}


def wavy(surface: Surface, size: float = 0.2) -> Surface:
    """The same surface with stretches that vary along z and around."""
    return Surface(
        surface.n_z,
        surface.n_theta,
        conductivities=surface.conductivities,
        axial_stretch=1.0 + size * np.sin(3.0 * surface.z_faces) * np.cos(surface.theta),
        hoop_stretch=1.0 + size * np.cos(2.0 * surface.z) * np.sin(surface.theta_faces),
    )


@pytest.mark.parametrize("n_theta", [1, 2, 3, 8])
@pytest.mark.parametrize("kind", KINDS)
def test_ring_without_variation_conducts_as_one_column_bit_for_bit(kind: str, n_theta: int) -> None:
    """No total current passes a ring's faces: what is left is the cable with its own coefficients, exactly."""
    rng = np.random.default_rng(3)
    stretch, hoop = rng.uniform(0.5, 1.5, (29, 1)), rng.uniform(0.5, 1.5, (30, 1))
    potential = rng.normal(size=(30, 1))
    surface = Surface(30, n_theta, conductivities=KINDS[kind], axial_stretch=stretch, hoop_stretch=hoop)
    operator = surface_operator(*surface.parts())
    found = apply_surface(operator, np.repeat(potential, n_theta, axis=1))
    padded, rate = np.zeros(34), np.empty(30)
    padded[2:-2] = potential[:, 0]
    fill_ghosts(padded, 1)
    coefficient = (DIFFUSIVITY * 1e-3 / (24.0 * surface.sizes.axial) ** 2) / stretch[:, 0]
    diffuse(padded, coefficient, np.zeros(33), rate, 1)
    assert np.array_equal(found, np.repeat(rate[:, None], n_theta, axis=1))


@pytest.mark.parametrize("kind", KINDS)
def test_conduction_neither_makes_nor_loses_charge(kind: str) -> None:
    """E8: whatever the potential, and the stretches."""
    surface = wavy(Surface(30, 24, conductivities=KINDS[kind]))
    potential = np.random.default_rng(1).normal(size=(30, 24))
    rate = apply_surface(getattr(surface, kind)(), potential)
    assert abs(rate.sum()) <= 1e-13 * np.abs(rate).sum()
    assert (potential * rate).sum() < 0.0, "and it only levels out"


@pytest.mark.parametrize(("kind", "tolerance"), [("monodomain", 0.0), ("bidomain", 1e-12)])
@pytest.mark.parametrize("turn", [1, 7, 12])
def test_no_column_is_the_seam(kind: str, tolerance: float, turn: int) -> None:
    """E6: potential and stretches turned by whole columns turn the result: bit for bit where all is explicit."""
    surface = wavy(Surface(20, 24, conductivities=KINDS[kind]))
    turned = Surface(
        20,
        24,
        conductivities=KINDS[kind],
        axial_stretch=np.roll(surface.axial_stretch, turn, axis=1),
        hoop_stretch=np.roll(surface.hoop_stretch, turn, axis=1),
    )
    potential = np.random.default_rng(2).normal(size=(20, 24))
    here = apply_surface(getattr(surface, kind)(), potential)
    there = apply_surface(getattr(turned, kind)(), np.roll(potential, turn, axis=1))
    assert np.abs(there - np.roll(here, turn, axis=1)).max() <= tolerance * np.abs(here).max()


@pytest.mark.parametrize("kind", KINDS)
def test_ring_rate_is_a_tight_bound(kind: str) -> None:
    """Stages are counted from it: no mode decays faster, and the fastest nearly as fast; any stretch only lowers it."""

    def fastest(surface: Surface) -> tuple[float, float]:
        operator = getattr(surface, kind)()
        units = np.eye(surface.n_z * surface.n_theta).reshape(-1, surface.n_z, surface.n_theta)
        matrix = np.array([apply_surface(operator, unit).ravel() for unit in units])
        along = largest_eigenvalue(DIFFUSIVITY * 1e-3, surface.sizes.axial) / np.min(surface.axial_stretch)
        return -np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).min(), along + operator.ring_rate

    even = Surface(16, 12, length=1.0, conductivities=KINDS[kind])
    found, bound = fastest(even)
    assert 0.98 * bound <= found <= bound * (1.0 + 1e-12)
    uneven = Surface(
        16,
        12,
        length=1.0,
        conductivities=KINDS[kind],
        axial_stretch=1.0 + 0.3 * np.sin(3.0 * even.z_faces) * np.cos(even.theta),
        hoop_stretch=1.0 + 0.3 * np.cos(2.0 * even.z) * np.sin(even.theta_faces),
    )
    found, bound = fastest(uneven)
    assert 0.7 * bound <= found <= bound


def test_wide_columns_cost_no_stage() -> None:
    """At 64 columns the ring stays within its share of the reserve; at 1024 the circular layer needs more stages."""
    along = largest_eigenvalue(DIFFUSIVITY * 1e-3, 0.01) + 0.5
    counts = []
    for n_theta in (8, 64, 1024):
        surface = Surface(200, n_theta, conductivities=CIRCULAR)
        counts.append(stages_for(0.25 * stability_rate(along, surface.monodomain().ring_rate)))
    assert counts[0] == counts[1] == stages_for(0.25 * along)
    assert counts[2] > counts[1]


class SurfaceSheet:
    """The longitudinal or circular sheet of a model, advanced alone on the undeformed tube."""

    def __init__(self, kind: str, columns: int, operator: SurfaceOperator | None = None) -> None:
        layer, sheet = MODEL.longitudinal, STATE.longitudinal
        self.columns = columns
        self.potential = np.repeat(sheet.potential.ravel(), columns)
        self.gates = np.repeat(sheet.gates.reshape(4, -1), columns, axis=1)
        self.conductances = np.repeat(layer.conductances, columns, axis=1)
        self.first, self.latest = np.full((2, self.potential.size), np.nan)
        sizes = SurfaceSizes(MODEL.grid.cell_size, 2.0 * np.pi * 0.795 / columns)
        self.operator = operator or surface_operator(
            layer.diffusivity, KINDS[kind], sizes, np.ones((59, columns)), np.ones((60, columns))
        )
        rate = MODEL.cell.kinetics_rate * float(layer.conductances.sum(axis=0).max()) / MODEL.cell.capacitance
        rate += largest_eigenvalue(layer.diffusivity * 1e-3, MODEL.grid.cell_size)
        self.stages = coefficients(stages_for(MODEL.dt_cell * stability_rate(rate, self.operator.ring_rate)))

    def advance(self, steps: int, drive: np.ndarray | float = 0.0, time: float = 0.0) -> int:
        return advance_surface_sheet(
            SheetArrays(self.potential, self.gates, self.first, self.latest),
            self.conductances,
            self.operator,
            Brought(
                np.broadcast_to(np.asarray(drive, float), (60, self.columns)).ravel(), np.zeros(self.potential.size)
            ),
            Steps(time, MODEL.dt_cell, steps, 1, False, -40.0),
            self.stages,
            MODEL.tables,
            MODEL.cell,
        )

    @property
    def surface(self) -> np.ndarray:
        return self.potential.reshape(60, self.columns)


@pytest.mark.parametrize("columns", [8, 32, 64])
@pytest.mark.parametrize("kind", KINDS)
def test_uniform_ring_is_one_column_bit_for_bit(kind: str, columns: int) -> None:
    """A wave started all around the ring: potential, gates and activation times of the axisymmetric sheet."""
    drive = np.where(np.arange(60) < 2, 4.0, 0.0)
    sheet = SurfaceSheet(kind, columns)
    assert sheet.advance(1600, drive[:, None]) == -1
    potential, gates = STATE.longitudinal.potential.ravel().copy(), STATE.longitudinal.gates.reshape(4, -1).copy()
    first, latest = np.full((2, 60), np.nan)
    coefficient = np.full(59, MODEL.longitudinal.diffusivity * 1e-3 / (24.0 * MODEL.grid.cell_size) ** 2)
    stages = MODEL.stages(MODEL.longitudinal, np.ones((8, 1)))
    advance_sheet(
        SheetArrays(potential, gates, first, latest),
        MODEL.longitudinal.conductances[:, :60].copy(),
        coefficient,
        Brought(drive, np.zeros(60)),
        Steps(0.0, MODEL.dt_cell, 1600, 1, False, -40.0),
        stages,
        MODEL.tables,
        MODEL.cell,
    )
    assert np.isfinite(first).sum() > 4
    assert np.array_equal(sheet.surface, np.repeat(potential[:, None], columns, axis=1))
    assert np.array_equal(sheet.gates, np.repeat(gates, columns, axis=1))
    assert np.array_equal(sheet.first, np.repeat(first, columns), equal_nan=True)


@pytest.mark.parametrize(("kind", "tolerance"), [("monodomain", 0.0), ("bidomain", 1e-10)])
def test_point_stimulus_spreads_from_where_it_is(kind: str, tolerance: float) -> None:
    """E6: not a ring; and turned by whole columns, the whole answer turns with it."""
    drive = np.zeros((60, 24))
    drive[:3, 5:8] = 4.0
    here, there = SurfaceSheet(kind, 24), SurfaceSheet(kind, 24)
    here.advance(300, drive)
    there.advance(300, np.roll(drive, 9, axis=1))
    assert np.ptp(here.surface[1]) > 20.0
    assert here.surface[1].argmax() in (5, 6, 7)
    assert np.abs(there.surface - np.roll(here.surface, 9, axis=1)).max() <= tolerance
    mirrored = here.surface[:, (12 - np.arange(24)) % 24]
    assert np.abs(mirrored - here.surface).max() <= 1e-9, "the stimulus is symmetric about column 6"


def test_unequal_anisotropy_shows_beside_a_point_stimulus() -> None:
    """Across the fibres the longitudinal layer conducts an eighth as well: its spot is narrower."""
    drive = np.zeros((60, 96))
    drive[:3, 46:50] = 4.0
    widths = []
    for kind in KINDS:
        sheet = SurfaceSheet(kind, 96)
        sheet.advance(200, drive)
        above = sheet.surface[1] - STATE.longitudinal.potential.max() > 0.1 * np.ptp(sheet.surface[1])
        widths.append(int(above.sum()))
    assert widths[1] < 0.7 * widths[0]


def test_sheet_without_conduction_has_no_operator() -> None:
    """Cells excited alone: no neighbour notices."""
    sheet = SurfaceSheet("monodomain", 4)
    sheet.operator = None
    drive = np.zeros((60, 4))
    drive[10, 2] = 4.0
    sheet.advance(100, drive)
    change = np.abs(sheet.surface - STATE.longitudinal.potential.ravel()[0])
    assert change[10, 2] > 1.0
    change[10, 2] = 0.0
    assert change.max() <= 1e-9


@pytest.mark.parametrize("bad", [np.nan, 1e9])
def test_bad_potential_is_reported_with_its_cell(bad: float) -> None:
    sheet = SurfaceSheet("bidomain", 4)
    sheet.potential[17] = bad
    before = sheet.potential.copy()
    assert sheet.advance(3) == 17
    assert np.array_equal(sheet.potential, before, equal_nan=True)


def test_stimulus_beyond_reason_is_reported() -> None:
    assert SurfaceSheet("bidomain", 4).advance(400, 1e4) >= 0


def test_operator_of_another_grid_is_refused() -> None:
    sheet = SurfaceSheet("monodomain", 4, Surface(60, 6, conductivities=CIRCULAR).monodomain())
    with pytest.raises(ValueError, match="same grid"):
        sheet.advance(1)


def test_stretches_of_another_grid_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\(9, 4\) is needed"):
        Monodomain(0.1, CIRCULAR, SurfaceSizes(0.1, 0.1), np.ones((10, 4)), np.ones((10, 4)))


def test_only_ratios_of_conductivities_matter() -> None:
    """The scale of a layer is in its diffusivity."""
    potential = np.random.default_rng(4).normal(size=(20, 16))
    scaled = Conductivities(*(1e-4 * np.array(LONGITUDINAL)))
    one = apply_surface(Surface(20, 16).bidomain(), potential)
    other = apply_surface(Surface(20, 16, conductivities=scaled).bidomain(), potential)
    assert np.abs(one - other).max() <= 1e-12 * np.abs(one).max()


def test_conduction_of_some_rings_is_that_of_all() -> None:
    """Rings at rest are left out: the others see the same fluxes to the last bit, and those keep what they had."""
    operator = wavy(Surface(30, 12)).monodomain()
    padded, whole = np.zeros((34, 12)), np.empty(360)
    padded[2:-2] = np.random.default_rng(5).normal(size=(30, 12))
    operator.apply(padded.ravel(), whole, 0, 360)
    for low, high in ((0, 30), (0, 1), (1, 4), (2, 9), (7, 28), (25, 30), (29, 30), (0, 0), (12, 12)):
        some = np.full(360, 7.0)
        operator.apply(padded.ravel(), some, 12 * low, 12 * high)
        asked = slice(12 * low, 12 * high)
        assert np.array_equal(some[asked], whole[asked])
        assert np.all(np.delete(some, np.arange(360)[asked]) == 7.0)


PSEUDO = Elliptic(pseudo=True)


@pytest.mark.parametrize(("n", "m", "share"), [(5, 0, 1.0), (0, 3, 1.0), (2, 8, None)])
def test_pseudo_bidomain_is_exact_along_and_around(n: int, m: int, share: float | None) -> None:
    """Eq. (96): the symbol of the series conductivities; the bidomain's oblique waves spread up to 2.5 % faster."""
    surface = Surface(60, 48)
    wave = surface.wave(n, m)
    full, pseudo = (apply_surface(surface_operator(*surface.parts(), one), wave) for one in (FULL, PSEUDO))
    k = np.unravel_index(np.abs(wave).argmax(), wave.shape)
    assert -full[k] / wave[k] == pytest.approx(surface.decay(n, m), rel=1e-9)
    found = pseudo[k] / full[k]
    if share is None:
        assert 0.974 < found < 0.99
    else:
        assert found == pytest.approx(share, rel=1e-12)


def test_slowest_oblique_front_of_the_pseudo_bidomain() -> None:
    """In any direction a plane front's speed goes with the root of the symbol: 1.24 % too slow at the worst."""
    g = LONGITUDINAL
    angle = np.linspace(0.0, 0.5 * np.pi, 2001)
    along, around = np.cos(angle) ** 2, g.effective_axial / g.effective_around * np.sin(angle) ** 2
    inner, outer = g.inner_axial * along + g.inner_around * around, g.outer_axial * along + g.outer_around * around
    full = inner * outer / (inner + outer)
    alike = g.alike
    inner, outer = (
        alike.inner_axial * along + alike.inner_around * around,
        alike.outer_axial * along + alike.outer_around * around,
    )
    share = np.sqrt(inner * outer / (inner + outer) / full)
    assert 0.9875 <= share.min() <= 0.9878
    assert share.max() <= 1.0 + 1e-12


def test_pseudo_bidomain_solves_no_elliptic_problem() -> None:
    parts = wavy(Surface(20, 12)).parts()
    assert isinstance(surface_operator(*parts, PSEUDO), Monodomain)
    assert isinstance(surface_operator(*parts), Bidomain)


def test_looser_elliptic_problem_takes_fewer_solves_and_moves_little() -> None:
    """At 1e-4 less than half of the solves of 1e-8; a rate is off by less than that share of the largest."""
    surface = wavy(Surface(40, 24))
    potential = np.cos(3.0 * surface.z) * np.exp(np.cos(surface.theta - 0.3))
    tight, loose = (Bidomain(*surface.parts(), tolerance) for tolerance in (1e-8, 1e-4))
    one, other = (apply_surface(operator, potential) for operator in (tight, loose))
    assert loose.solves <= 0.6 * tight.solves
    assert 0.0 < np.abs(one - other).max() <= 1e-4 * np.abs(one).max()


def node_steps(**chosen: object) -> int:
    """Stages of all cells of both layers in a second, on the undeformed wall of a pacemaker at a point."""
    model = build(scenarios.configuration("point_pacemaker", changes=chosen))
    grid, total = model.grid, 0
    still = Ahead(np.ones((grid.n_z_wall, grid.n_theta)), 1.0, np.ones((grid.n_z_wall + 1, grid.n_theta)))
    for layer in (model.longitudinal, model.circular):
        stages = model.stages(layer, 1.0, 0.0, conduction(model, layer, still).ring_rate)
        total += len(stages) * model.substeps * grid.n_z * grid.n_theta_conduction
    return round(total / model.dt_wall)


def test_corrected_layer_that_conducts_nowhere_has_stages() -> None:
    """A region may block all of a layer: nothing conducts, so nothing is raised."""
    everywhere = {"name": "all", "shape": "band", "z_from": "0 cm", "z_to": "10 cm", "conductivity": 0.0}
    chosen = {"tissue.front_correction": "measured", "regions": [everywhere]}
    model = build(scenarios.configuration("point_pacemaker", changes=chosen))
    assert len(model.stages(model.longitudinal, 1.0)) == 2


def test_corrected_sheets_take_a_fraction_of_the_node_steps() -> None:
    """A front within one per cent of its speed on 128 columns, where 512 leave it ten per cent slow."""
    before = {"tissue.front_correction": "none", "step.wall": "2 ms", "step.conduction": "0.25 ms"}
    plain = node_steps(**before, **{"grid.n_theta_conduction": 512})
    chosen = node_steps(
        **{"grid.n_theta_conduction": 128, "tissue.front_correction": "measured", "step.conduction": "1 ms"}
    )
    assert plain >= 8 * chosen
