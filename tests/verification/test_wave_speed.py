"""The wave of both layers on the undeformed cable, and how stretch slows it, Eqs. (6), (11), (31)."""

import math

import numpy as np
import pytest
from verification.problems.runs import configured

from peristalsis.build import build
from peristalsis.model.initial import initial_state
from peristalsis.model.model import ACTIVATION_LEVEL
from peristalsis.numerics.stabilised import coefficients, stages_for
from peristalsis.result import wave_speed
from peristalsis.tissue.conduction import largest_eigenvalue
from peristalsis.tissue.sheet import advance_sheet


def speed(layer: str, cells: int, stretch: float = 1.0, length: float = 10.0) -> float:
    """Speed [cm/s] of the first wave on a uniformly stretched, undeforming cable started from rest."""
    model, state, _ = initial_state(
        build(configured({"grid.n_z": cells, "grid.n_z_wall": 8, "pellet.enabled": False, "lumen.pressure": "0 kPa"}))
    )
    part, sheet = getattr(model, layer), getattr(state, layer)
    h, dt = length / cells, model.dt_cell
    rate = largest_eigenvalue(part.diffusivity * 1e-3, h) / stretch
    rate += model.cell.kinetics_rate * float(part.conductances[:, 0].sum())
    stages = coefficients(stages_for(rate * dt))
    table, half = model.tables
    z = (np.arange(cells) + 0.5) * h
    potential, gates = sheet.potential.ravel().copy(), sheet.gates.reshape(4, -1).copy()
    first, last = np.full(cells, np.nan), np.full(cells, np.nan)
    time = 0.0
    for duration, current in ((50.0, 2.0), (1e3 * length / 2.5, 0.0)):
        verdict = advance_sheet(
            potential,
            gates,
            first,
            last,
            part.conductances,
            np.full(cells - 1, part.diffusivity * 1e-3 / (24.0 * h) ** 2 / stretch),
            np.where(z < 0.3, current, 0.0),
            np.zeros(cells),
            1,
            time,
            dt,
            round(duration / dt),
            stages,
            table,
            half,
            False,
            ACTIVATION_LEVEL,
            model.cell,
        )
        assert verdict == -1
        time += duration
    found = wave_speed(z * 10.0 / length, first * 1e-3)
    assert found is not None, "no wave arrived"
    return found * length / 10.0


@pytest.mark.parametrize("layer", ["longitudinal", "circular"])
def test_calibrated_wave_on_the_default_grid(layer: str) -> None:
    """Calibrated once, on the undeformed cable from rest: 4.2 cm/s to a per cent."""
    assert speed(layer, 1000) == pytest.approx(4.2, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("layer", ["longitudinal", "circular"])
def test_calibrated_wave_does_not_depend_on_the_grid(layer: str) -> None:
    """A grid twice finer keeps 4.2 cm/s to a per cent, and moves it by less than half of one."""
    fine = speed(layer, 2000)
    assert fine == pytest.approx(4.2, rel=0.01)
    assert fine == pytest.approx(speed(layer, 1000), rel=5e-3)


@pytest.mark.parametrize("stretch", [0.7, 1.4])
def test_stretch_slows_the_wave_as_the_root(stretch: float) -> None:
    """E6: conductivity over stretch, so the Lagrangian speed goes with 1/sqrt(stretch)."""
    ratio = speed("circular", 800, stretch, 8.0) / speed("circular", 800, 1.0, 8.0)
    assert ratio == pytest.approx(1.0 / math.sqrt(stretch), rel=5e-3)
