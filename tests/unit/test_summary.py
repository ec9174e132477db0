"""The numbers of a summary: right where they can be measured, None with a reason where not, never insane."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import peristalsis as ps
from peristalsis.results.waves import CONDUCTED, SPONTANEOUS, STIMULATED
from peristalsis.running.observers import Expulsion
from peristalsis.running.simulation import Simulation
from peristalsis.running.summary import OF_PELLET, OF_WAVE, fastest_conduction, summarise
from peristalsis.running.upstrokes import UpstrokeRecorder
from peristalsis.scenarios import configuration

COARSE = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 200,
    "grid.n_z_wall": 100,
    "output.interval": "50 ms",
    "run.duration": "4 ms",
}


@pytest.fixture(scope="module")
def run() -> ps.Result:
    return ps.run("baseline", {**COARSE, "run.duration": "0.4 s"})


def summary_of(run: ps.Result, changes: dict[str, np.ndarray], expulsion: Expulsion | None = None) -> dict[str, Any]:
    arrays = {**run.arrays, **changes}
    return summarise(run.configuration, arrays, "in_transit", None, expulsion or Expulsion(True), 10.0, {})


def test_run_without_a_step_has_no_rates() -> None:
    """Before the first step there is a place and a force, but no velocity, no balance of work and no wave."""
    summary = Simulation(configuration("baseline", changes=COARSE)).result().summary
    assert summary["steps"] == 0
    assert summary["start_cm"] == 1.2
    assert summary["mean_velocity_cm_s"] is None
    assert summary["power_residual"] is None
    assert summary["wave_speed_cm_s"] == {"longitudinal": None, "circular": None}
    assert "no wave passed" in summary["wave_speed_reason"]["circular"]
    assert summary["waves"] == {"longitudinal": 0, "circular": 0}


def test_run_without_a_pellet_says_nothing_of_one() -> None:
    summary = ps.run("baseline", {**COARSE, "pellet.enabled": False}).summary
    assert summary["status"] == "finished"
    assert [summary[key] for key in OF_PELLET] == [None] * len(OF_PELLET)
    assert summary["min_diameter_cm"] > 1.0


def test_tissue_that_does_not_conduct_has_no_wave() -> None:
    still = {"longitudinal.conduction": False, "circular.conduction": False}
    result = ps.run("baseline", {**COARSE, **still})
    assert result.summary["wave_speed_reason"] == dict.fromkeys(("longitudinal", "circular"), "neither layer conducts")
    assert [result.summary[key]["circular"] for key in OF_WAVE] == [None, "neither layer conducts", None, None, None]


def test_limit_of_conduction_goes_with_the_tissue() -> None:
    """Four times the wave of the undeformed cable, 4.2 cm/s as shipped; as the root of the diffusivity."""
    shipped = fastest_conduction(configuration("baseline"))
    assert shipped == pytest.approx(4.0 * 4.2, rel=0.02)
    scale = 0.25 * configuration("baseline").longitudinal.conductivity_scale
    slower = {f"{layer}.conductivity_scale": scale for layer in ("longitudinal", "circular")}
    assert fastest_conduction(configuration("baseline", changes=slower)) == pytest.approx(0.5 * shipped, rel=0.02)


def test_expelled_at_once_has_its_own_time(run: ps.Result) -> None:
    summary = summary_of(run, {}, Expulsion(True, 0.2))
    travelled = np.interp(0.2, run.arrays["time_step"], run.arrays["pellet_position"]) - 1.2
    assert summary["travel_cm"] == pytest.approx(travelled)
    assert summary["mean_velocity_cm_s"] == pytest.approx(travelled / 0.2)
    assert summary_of(run, {}, Expulsion(True, 0.0))["mean_velocity_cm_s"] is None


def test_momentum_without_a_record_is_none(run: ps.Result) -> None:
    """With inertia a step made in parts keeps no rate: where there is none at all, 0 would be a lie."""
    nothing = np.full_like(run.arrays["momentum_residual"], np.nan)
    assert summary_of(run, {"momentum_residual": nothing})["momentum_residual"] is None


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(["power_residual", "axial_force", "normal_force", "momentum_residual", "lumen_pressure"]),
    st.sampled_from([math.nan, math.inf, -math.inf, 1e308]),
    st.booleans(),
)
def test_numbers_are_finite_or_none(run: ps.Result, name: str, value: float, everywhere: bool) -> None:
    """Whatever the arrays hold, no summary holds what JSON cannot."""
    spoilt = run.arrays[name].copy()
    spoilt[slice(None) if everywhere else slice(3, 5)] = value
    summary = summary_of(run, {name: spoilt})
    flat = [v for entry in summary.values() for v in (entry.values() if isinstance(entry, dict) else [entry])]
    assert all(math.isfinite(number) for number in flat if isinstance(number, float))


def test_waves_of_a_run_begin_at_the_pacemaker(run: ps.Result) -> None:
    """One antegrade wave in each layer, begun by its stimulus; the first upstrokes are those of the activation map."""
    arrays = run.arrays
    travelled = arrays["wave_direction"] != "local"
    assert arrays["wave_direction"][travelled].tolist() == ["antegrade"] * 2
    assert set(arrays["wave_origin"][travelled]) == {"stimulus"}
    assert arrays["wave_start"][travelled].max() < 0.35
    first = np.nanmin(arrays["activation_longitudinal"])
    assert arrays["wave_time"].min() == pytest.approx(first, abs=1e-9)
    assert run.summary["waves"] == {"longitudinal": 1, "circular": 1}
    assert run.summary["waves_spontaneous"] == {"longitudinal": 0, "circular": 0}


def test_tissue_without_a_rest_is_seen_to_fire_by_itself() -> None:
    """Above the conductance at which rest is lost waves begin where nothing stimulates, and the run says so."""
    restless = {f"{layer}.slow_calcium": "0.012 mS/cm^2" for layer in ("longitudinal", "circular")}
    result = ps.run("baseline", {**COARSE, **restless, "run.duration": "1.2 s"})
    assert result.summary["waves_spontaneous"]["longitudinal"] >= 1
    assert "spontaneous" in result.arrays["wave_origin"]
    assert any("began without a stimulus" in remark for remark in result.remarks)


def test_origin_of_upstrokes_from_a_run() -> None:
    """Under the pulse they are stimulated, beyond it conducted; none is spontaneous."""
    simulation = Simulation(configuration("baseline", changes={**COARSE, "run.duration": "0.2 s"}))
    simulation.run()
    (recorder,) = [one for one in simulation._observers if isinstance(one, UpstrokeRecorder)]
    cells = np.array(recorder.cells["longitudinal"])
    origins = np.array(recorder.origins["longitudinal"])
    place = simulation.model.grid.cells[cells]
    assert set(origins[place > 0.4]) == {CONDUCTED}
    assert STIMULATED in origins[place < 0.3]
    assert SPONTANEOUS not in origins
    first = simulation.state.longitudinal.first_activation[cells, 0] * 1e-3
    assert recorder.times["longitudinal"] == pytest.approx(first, abs=1e-12)
