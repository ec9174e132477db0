"""Before t = 0: cells at rest, tube inflated, pellet inserted; and the sentences where that cannot be."""

import numpy as np
import pytest

from peristalsis.errors import DivergenceError
from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.model.fields import corner_tensions, nodal_tensions
from peristalsis.model.initial import initial_state
from peristalsis.wall.membrane import TOTAL_CIRCULAR
from verification.exact.runs import EXACT, configured, started
from verification.exact.wall import InflatedTube


@pytest.mark.parametrize("tension", ["published", "consistent"])
def test_inflated_radius_is_laplaces(tension: str) -> None:
    """M3 by way of the production start: mid-tube, where the ends are forgotten, 1e-4 of the scalar root."""
    model, state = started(EXACT, {"pellet.enabled": False, "wall.tension": tension})
    exact = 0.795 * InflatedTube(10.0, model.wall).hoop_stretch()
    assert exact / 0.795 == pytest.approx(1.03, abs=0.005), "tight: 3 % distended at 0.1 kPa"
    assert model.free_radius[200] == pytest.approx(exact, rel=1e-4)
    assert np.array_equal(state.wall.position[:, 0, 0], model.free_radius)


def test_pellet_starts_where_it_should() -> None:
    """Trailing pole 0.3 cm from the oral end, in contact, at rest, the lumen at p0."""
    model, state = started()
    assert state.pellet.position == pytest.approx(1.2)
    assert state.pellet.velocity == 0.0
    assert state.pressure == pytest.approx(10.0)
    touching = state.wall.contact[:, 0] > 0.0
    assert touching.sum() > 5
    gap = np.hypot(state.wall.position[touching, 0, 0], state.wall.position[touching, 0, 2] - 1.2) - 0.9
    assert np.abs(gap).max() <= 1e-8
    assert model.lumen.reference_volume > 0.0


@pytest.mark.parametrize("reading", ["tight", "stretched", "printed"])
def test_every_reading_can_start(reading: str) -> None:
    """Narrow, wide and loose pellets are all inserted; only the loose one does not touch."""
    model, state = started({"reading": reading})
    assert (state.wall.contact.max() > 0.0) == (reading != "printed")
    gap = np.hypot(state.wall.position[1:-1, 0, 0], state.wall.position[1:-1, 0, 2] - state.pellet.position)
    assert gap.min() >= model.pellet.radius - 1e-7


def test_oscillating_tissue_is_remarked() -> None:
    """Above 0.008 there is no stable rest: the run says so and goes on."""
    _, _, remarks = initial_state(build(configured({"circular.slow_calcium": "0.01 mS/cm^2"})))
    assert len(remarks) == 1
    assert remarks[0].startswith("circular layer: no stable rest")
    assert initial_state(build(configured()))[2] == []


def test_tube_that_cannot_hold_the_pressure_says_so() -> None:
    with pytest.raises(DivergenceError, match=r"lumen.pressure = 50 kPa"):
        started({"lumen.pressure": "50 kPa", "wall.c10": "0 mN/cm"})


@pytest.mark.parametrize("pressure", ["10 kPa", "20 kPa"])
def test_high_pressure_is_reached_by_continuation(pressure: str) -> None:
    """The paper's Fig. 4 D inflates to 20 kPa: from the undeformed tube no single Newton iteration gets there."""
    config = Configuration().with_changes(
        {"grid.n_z": 300, "grid.n_z_wall": 400, "lumen.pressure": pressure, "pellet.enabled": False}
    )
    model, state, _ = initial_state(build(config))
    middle = model.grid.n_z_wall // 2
    stretch = model.free_radius[middle] / model.wall.radius
    tension = nodal_tensions(corner_tensions(state.wall, model.wall))[middle, 0, TOTAL_CIRCULAR]
    assert 1.35 < stretch < 1.5
    assert tension == pytest.approx(model.lumen.pressure * model.free_radius[middle], rel=1e-3)
    assert np.isfinite(state.wall.position).all()
