"""Warnings before a run: the shipped grids pass, twice coarser ones do not."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from peristalsis import scenarios
from peristalsis.inputs import preflight
from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.running.simulation import Simulation
from verification.exact.runs import configured


def test_shipped_grids_pass() -> None:
    for reading in ("tight", "stretched", "printed"):
        assert preflight.remarks(Configuration(reading=reading)) == []


@pytest.mark.parametrize(("key", "count"), [("grid.n_z", 250), ("grid.n_z_wall", 300)])
def test_twice_coarser_warns_and_names_a_cure(key: str, count: int) -> None:
    config = Configuration().with_changes({key: count})
    found = preflight.remarks(config)
    assert all(remark.startswith(f"{key} = {count}") for remark in found)
    needed = max(int(re.split("[Uu]se ", remark)[-1].split()[0]) for remark in found)
    assert preflight.remarks(config.with_changes({key: needed})) == []


@pytest.mark.parametrize("elsewhere", [{"grid.n_theta": 16}, {"solver.integrator": "explicit"}])
def test_grids_are_judged_by_what_is_done_there(elsewhere: dict[str, object]) -> None:
    """Fields are reconstructed in one column, stepped implicitly, alone: elsewhere elements err as with averages."""
    coarse = Configuration().with_changes({"grid.n_z": 500, "grid.n_z_wall": 400, **elsewhere})
    found, plain = (
        [law for _, _, law, _ in preflight.error_laws(coarse.with_changes({"grid.exchange": exchange}))]
        for exchange in ("reconstructed", "averages")
    )
    assert found == plain
    assert found[1] == preflight.ELEMENT_ERROR


def test_slower_kinetics_make_a_longer_foot() -> None:
    """D/c with c ~ sqrt(D rate): a quarter of the rate doubles the foot."""
    slow = Configuration().with_changes({"tissue.kinetics_rate": 0.125 / 4})
    ratio = preflight.foot_length(slow, "circular") / preflight.foot_length(Configuration(), "circular")
    assert ratio == pytest.approx(2.0)


def test_no_wave_no_warning() -> None:
    still = {"longitudinal.conduction": False, "circular.conduction": False, "grid.n_z": 100, "grid.n_z_wall": 50}
    assert not any("wave" in remark for remark in preflight.remarks(Configuration().with_changes(still)))


# --- the end layer, M7 ------------------------------------------------------------------------------


@pytest.mark.parametrize(("reading", "length"), [("tight", 0.014), ("stretched", 0.096), ("printed", 0.096)])
def test_end_length_of_the_readings(reading: str, length: float) -> None:
    """At 0.1 kPa and the undeformed length, where tensions have a potential, by an independent evaluation."""
    config = Configuration(reading=reading).with_changes({"wall.tension": "consistent"})
    assert preflight.end_length(build(config)) == pytest.approx(length, rel=0.02)


@pytest.mark.parametrize(("factor", "warns"), [(0.95, False), (1.05, True)])
def test_elements_longer_than_the_end_layer_warn(factor: float, warns: bool) -> None:
    """R6: both sides of the limit, which lies between the shipped elements and twice longer ones."""
    base = Configuration().with_changes({"longitudinal.conduction": False, "circular.conduction": False})
    length = preflight.end_length(build(base))
    assert length is not None
    count = base.wall.length / (factor * preflight.END_LAYER_ELEMENTS * length)
    found = preflight.remarks(base.with_changes({"grid.n_z_wall": round(count)}))
    assert bool(found) is warns
    assert 0.0125 < preflight.END_LAYER_ELEMENTS * length < 0.025


@pytest.mark.parametrize("tension", ["consistent", "published"])
def test_fitted_decay_agrees_with_the_end_length(tension: str) -> None:
    """The shape of the inflated tube near its end, on elements of a twentieth of the length: exp(-Z/l)."""
    changes = {
        "reading": "stretched",
        "grid.n_z": 60,
        "grid.n_z_wall": 1000,
        "wall.length": "4 cm",
        "pellet.enabled": False,
        "output.probes": [],
        "wall.bending_stiffness": "0 mN*cm",
        "wall.tension": tension,
    }
    run = Simulation(configured(changes, scenario="resting"))
    radius, z = run.model.free_radius, run.model.grid.nodes
    axial = run.state.wall.position[:, 0, 2]
    length = preflight.end_length(run.model, (axial[501] - axial[499]) / (z[501] - z[499]))
    assert length is not None
    away = np.abs(radius / radius[500] - 1.0)
    part = (away < 1e-2) & (away > 3e-4) & (z < 1.0)
    fitted = -1.0 / np.polyfit(z[part], np.log(away[part]), 1)[0]
    assert fitted == pytest.approx(length, rel=0.01)


def test_slack_wall_is_said() -> None:
    slack = {"lumen.pressure": "0 kPa", "wall.slack_blend": "0 mN/cm"}
    (remark,) = [one for one in preflight.remarks(Configuration().with_changes(slack)) if "pressure" in one]
    assert "no tension along the tube" in remark


def test_a_tube_that_cannot_hold_its_pressure_has_no_end_length() -> None:
    soft = {"wall.c10": "0 mN/cm", "wall.c2": "0.01 mN/cm", "lumen.pressure": "1 kPa"}
    assert preflight.end_length(build(Configuration().with_changes(soft))) is None


# --- forces -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("factor", "warns"), [(0.95, False), (1.05, True)])
def test_friction_that_no_muscle_overcomes_warns(factor: float, warns: bool) -> None:
    pull = preflight.largest_pull(build(Configuration()))
    config = Configuration().with_changes({"pellet.dry_friction": f"{factor * pull} mN"})
    assert any("cannot move" in remark for remark in preflight.remarks(config)) is warns
    assert preflight.remarks(config.with_changes({"pellet.enabled": False})) == []


@pytest.mark.parametrize("dry", ["20 mN", "2000 mN", "1e6 mN"])
def test_no_run_pulls_harder_than_the_budget(dry: str) -> None:
    """C7 as an inequality, with a pellet that runs, one that is dragged and one that is held."""
    config = configured({"grid.n_z": 200, "grid.n_z_wall": 100, "run.duration": "0.6 s", "pellet.dry_friction": dry})
    run = Simulation(config)
    result = run.run()
    assert result.summary["max_axial_force_mN"] < preflight.largest_pull(run.model)
    if dry == "1e6 mN":
        assert np.all(result.arrays["pellet_position"] == result.arrays["pellet_position"][0])


# --- steps, memory, disk ----------------------------------------------------------------------------


def test_explicit_steps_without_enough_stages_are_said() -> None:
    long = {"step.conduction": "100 ms", "step.wall": "100 ms", "grid.n_z": 20000, "output.interval": "1 s"}
    found = preflight.remarks(Configuration().with_changes(long))
    assert any("too long for a decay rate" in remark for remark in found)


def test_memory_and_disk(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Both sides of each limit, on a machine of 60 MB memory and 100 MB disk."""
    monkeypatch.setattr(preflight.os, "sysconf", lambda name: 60_000_000 if name == "SC_PHYS_PAGES" else 1)
    monkeypatch.setattr(preflight.shutil, "disk_usage", lambda path: SimpleNamespace(free=100_000_000))
    little = Configuration().with_changes({"output.interval": "0.1 s"})
    much = Configuration().with_changes({"output.interval": "0.01 s"})
    assert preflight.remarks(little) == []
    assert any("memory" in remark for remark in preflight.remarks(much))
    assert preflight.disk_remarks(little, tmp_path / "not" / "yet") == []
    assert "free" in preflight.disk_remarks(much, tmp_path)[0]


def test_few_shipped_scenarios_have_remarks() -> None:
    """The highest pressure and the narrowest tubes have end layers thinner than the shipped elements.

    Those on the whole surface say how coarse their grids are, and the guinea pig's wall has thin end layers too.
    """
    said = {name for name in scenarios.names() if preflight.remarks(scenarios.configuration(name))}
    assert said <= {"fig4d", "fig7c", "point_pacemaker", "blocked_patch", "taenia", "capsule", "guinea_pig"}


def test_coarse_columns_are_remarked_unless_fronts_are_corrected() -> None:
    """A front around the ring is slow on them; with its correction it is not."""
    config = scenarios.configuration(
        "point_pacemaker", changes={"grid.n_theta_conduction": 64, "tissue.front_correction": "none"}
    )
    assert sum("a front around the ring" in remark for remark in preflight.remarks(config)) == 2
    corrected = config.with_changes({"tissue.front_correction": "measured"})
    assert not any("a front around the ring" in remark for remark in preflight.remarks(corrected))
