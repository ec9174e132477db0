"""What a run shows of its own convergence."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.pellet.body import resized_pellet
from peristalsis.results import convergence
from peristalsis.results.convergence import remarks, start_remarks
from peristalsis.results.result import Result
from peristalsis.running.simulation import Simulation

QUICK = {
    "grid.n_z": 200,
    "grid.n_z_wall": 100,
    "run.duration": "0.2 s",
    "step.wall": "4 ms",
    "step.conduction": "0.5 ms",
}


@pytest.fixture(scope="module")
def short() -> Result:
    """A short run of the baseline on a coarse grid."""
    return ps.run("baseline", QUICK)


def said(
    run: Result, arrays: dict[str, Any] | None = None, summary: dict[str, Any] | None = None, **changes: Any
) -> str:
    """The remarks on a run of which some things are otherwise."""
    configuration = run.configuration.with_changes({key.replace("__", "."): value for key, value in changes.items()})
    return " ".join(remarks(configuration, {**run.arrays, **(arrays or {})}, {**run.summary, **(summary or {})}))


def test_nothing_is_said_of_an_ordinary_run(short: Result) -> None:
    assert said(short) == ""
    assert not any("near a threshold" in text or "start:" in text for text in short.remarks)


def test_a_lopsided_start_is_named() -> None:
    """A uniform tube that is not its own mirror image is one of several equilibria, chosen by rounding."""
    model = build(ps.configuration("baseline", changes=QUICK))
    assert start_remarks(model) == []
    radius = model.free_radius.copy()
    radius[:20] -= 0.3
    (text,) = start_remarks(replace(model, free_radius=radius))
    assert "lopsided" in text
    assert "up to 3 mm" in text
    assert "lumen.pressure" in text


@pytest.mark.parametrize(("ratio", "named"), [(1.04, True), (1.06, True), (1.02, False), (1.12, False)])
def test_receptors_at_their_threshold_are_named(ratio: float, named: bool) -> None:
    model = build(ps.configuration("baseline", changes=QUICK))
    near = replace(model, pellet=resized_pellet(model.pellet, ratio * float(np.median(model.free_radius))))
    assert any("near a threshold" in text for text in start_remarks(near)) is named
    silent = replace(near, reflex=near.reflex._replace(enabled=False))
    assert start_remarks(silent) == []
    forced = replace(near, reflex=near.reflex._replace(threshold=0.0))
    assert start_remarks(forced) == []


def test_listed_stimuli_are_no_tissue_that_fires_by_itself() -> None:
    """What starts at a stimulus, alone or beside the pacemaker, is driven; what starts elsewhere is not."""
    line = "longitudinal: 2 uA/cm^2 at 0.1 s for 50 ms over 5 cm to 5.3 cm"
    z = np.linspace(0.01, 9.99, 500)
    first = 0.1 + np.abs(z - 5.15) / 3.0
    arrays = {"z_cell": z, "activation_longitudinal": first[:, None]}
    for kind in ("none", "pulse"):
        driven = Configuration().with_changes({"pacemaker.kind": kind, "stimuli": [line]})
        assert convergence._own_source(driven, arrays) is None
        assert convergence._drives(driven, 1.0) == (1 if kind == "none" else 2)
        alone = driven.with_changes({"stimuli": []})
        assert convergence._own_source(alone, arrays) == pytest.approx(5.15, abs=0.02)


def test_tissue_that_fires_by_itself_is_named(short: Result) -> None:
    """Nothing but the pacemaker starts the longitudinal layer: a wave from elsewhere is the tissue's own."""
    z = short.arrays["z_cell"]
    wave = 0.25 * z
    assert said(short, {"activation_longitudinal": wave[:, None]}) == ""
    both = np.minimum(wave, 0.5 + 0.25 * np.abs(z - 6.0))
    assert "fires by itself (at z = 6 cm)" in said(short, {"activation_longitudinal": both[:, None]})
    assert "fires by itself" in said(short, {"activation_longitudinal": wave[:, None]}, pacemaker__kind="none")
    reached = np.where(z < 4.0, wave, np.nan)  # where a wave dies nothing begins
    assert said(short, {"activation_longitudinal": reached[:, None]}) == ""


def test_more_upstrokes_than_pulses_are_named(short: Result) -> None:
    potential = short.arrays["potential_longitudinal_probe"].copy()
    potential[10:12], potential[12:20], potential[20:22] = 0.0, -60.0, 0.0
    assert "2 upstrokes at a probe for 1 pulses" in said(short, {"potential_longitudinal_probe": potential})
    assert said(short, {"potential_longitudinal_probe": potential}, pacemaker__kind="cell") == ""


def test_a_front_that_is_coarse_only_on_stretched_wall_is_named(short: Result) -> None:
    """1000 cells and 800 elements do for the undeformed wave, and not where the wall is three times as long.

    Where fields are averages: reconstructed, they do there, too.
    """
    z, cells = np.linspace(0.0, 10.0, 101), (np.arange(200) + 0.5) * 0.05
    arrays = {
        "z": z,
        "z_cell": cells,
        "activation_longitudinal": (0.02 * cells)[:, None],
        "activation_circular": np.full((200, 1), np.nan),
    }
    grids = {"grid__n_z": 1000, "grid__n_z_wall": 800, "grid__exchange": "averages", "tissue__front_correction": "none"}
    for stretch, named in ((1.0, False), (3.0, True)):
        arrays["radius"] = np.full((len(short.arrays["time"]), 101, 1), 0.8)
        arrays["axial_position"] = np.broadcast_to(stretch * z[:, None], arrays["radius"].shape)
        text = said(short, arrays, **grids)
        assert ("wall stretched to 3.00" in text) is named
    assert "use 1" in said(short, arrays, **grids)


@pytest.mark.parametrize(("force", "named"), [(21.0, True), (19.0, True), (15.0, False), (40.0, False)])
def test_a_force_close_to_the_friction_is_named(short: Result, force: float, named: bool) -> None:
    still = np.full_like(short.arrays["pellet_position"], 1.2)
    arrays = {"axial_force": np.linspace(0.0, force, still.size), "pellet_position": still}
    assert ("near a threshold" in said(short, arrays)) is named


def test_a_pellet_left_behind_is_named(short: Result) -> None:
    time = short.arrays["time_step"]
    speed = np.exp(-0.5 * ((time - 0.08) / 0.01) ** 2) * 10.0
    track = 1.2 + np.cumsum(speed) * float(time[1])
    arrays = {"pellet_position": track, "pellet_velocity": speed}
    assert "left the pellet behind at t = 0.1" in said(short, arrays)
    assert said(short, arrays, {"transit_s": 0.15, "status": "expelled"}) == ""
    assert said(short, arrays | {"pellet_velocity": np.full_like(speed, 3.0)}) == ""


def test_an_end_that_decides_is_named(short: Result) -> None:
    """Leaving just before the end, or being about to leave at it, is a matter of the duration."""
    assert "just before the end" in said(short, None, {"transit_s": 0.199, "status": "expelled"})
    assert said(short, None, {"transit_s": 0.1, "status": "expelled"}) == ""
    time = short.arrays["time_step"]
    arrays = {"pellet_position": 9.1 - 0.005 - 4.0 * (time[-1] - time), "pellet_velocity": np.full_like(time, 4.0)}
    assert "the run ended when the pellet was 0.05 mm from being expelled" in said(short, arrays)


def test_hard_going_is_named(short: Result) -> None:
    """Steps in parts, and iterations far beyond the usual: what makes a run slow is said."""
    size = short.arrays["newton_iterations"].size
    assert "times as long as others" in said(short, {"newton_iterations": np.full(size, 20.0)})
    many = np.full(size, 4.0)
    many[5:15] = 50.0
    assert "had to be made in parts" in said(short, {"newton_iterations": many})


def test_remarks_of_the_end_are_with_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("peristalsis.results.convergence.remarks", lambda *_: ["found at the end"])
    simulation = Simulation(ps.configuration("resting", changes=QUICK | {"run.duration": "20 ms"}))
    assert simulation.run().remarks[-1] == "found at the end"
    assert "found at the end" not in simulation.remarks
