"""Problems of the slow tier, fed with numbers of a known law: they pass where the law holds, and notice where not."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from verification import coupled, dynamics
from verification.coupled import QUANTITIES, SAFETY, TRIPLES, grid_index
from verification.dynamics import FOURTH_ORDER, Conservative
from verification.exact.runs import March, started

Floats = NDArray[np.float64]

# --- grid convergence index ---------------------------------------------------------------------------


def test_index_of_a_power_law() -> None:
    """100 + h^2 at h = 4, 2, 1: order two, and the safety factor times the error of each."""
    order, medium, fine = grid_index(116.0, 104.0, 101.0)
    assert order == pytest.approx(2.0)
    assert fine == pytest.approx(SAFETY * 1.0 / 101.0)
    assert medium == pytest.approx(SAFETY * 4.0 / 101.0)


def test_order_above_four_is_not_trusted() -> None:
    """Sixty-fourfold smaller differences are taken for sixteenfold ones."""
    order, medium, fine = grid_index(-63.0, 1.0, 2.0)
    assert order == pytest.approx(6.0)
    assert fine == pytest.approx(SAFETY * 1.0 / 15.0 / 2.0)
    assert medium == pytest.approx(16.0 * fine)


def test_index_without_an_order() -> None:
    """Differences that grow have none, and thrice the larger is the bound; equal values leave nothing."""
    order, medium, fine = grid_index(9.0, 10.0, 8.0)
    assert math.isnan(order)
    assert medium == fine == pytest.approx(3.0 * 2.0 / 8.0)
    assert grid_index(1.0, 2.0, 2.0) == (math.inf, 0.0, 0.0)


def converging(scale: float) -> Callable[[tuple[tuple[str, Any], ...]], dict[str, float]]:
    """Runs whose results are off by scale times the square of what is coarse, shipped (1) or fine."""

    def summary(changes: tuple[tuple[str, Any], ...]) -> dict[str, float]:
        given = dict(changes)
        level = next((k for triple in TRIPLES.values() for k, one in enumerate(triple) if one and one == given), 1)
        return dict.fromkeys(QUANTITIES.values(), 10.0 + scale * 0.25**level)

    return summary


@pytest.mark.parametrize(("scale", "verdict"), [(0.1, "pass"), (1.0, "fail")])
def test_convergence_is_judged_by_the_sum_of_three_indices(
    monkeypatch: pytest.MonkeyPatch, scale: float, verdict: str
) -> None:
    monkeypatch.setattr(coupled, "_summary", converging(scale))
    found = coupled.convergence()
    assert found.verdict == verdict
    assert [check.what.rpartition(", ")[2] for check in found.checks] == ["shipped", "twice finer"] * 3
    fine = 3.0 * SAFETY * 0.0625 * scale / (10.0 + 0.0625 * scale)
    assert [check.observed for check in found.checks] == pytest.approx([4.0 * fine, fine] * 3)
    assert "transit by cells: " in found.note
    assert found.note.count("(order 2.0)") == 9


# --- the coupled model --------------------------------------------------------------------------------


@pytest.mark.parametrize(("power", "verdict"), [(2, "pass"), (1, "fail")])
def test_order_of_the_coupling_is_that_of_the_places(monkeypatch: pytest.MonkeyPatch, power: int, verdict: str) -> None:
    """Places off by 1e-4 cm times a power of the step in ms: of first order it does not pass."""

    def march(seconds: float, *changes: Mapping[str, Any]) -> SimpleNamespace:
        wall, conduction = (float(changes[-1][f"step.{name}"].removesuffix(" ms")) for name in ("wall", "conduction"))
        assert conduction == wall / 8.0
        return SimpleNamespace(last=SimpleNamespace(wall=SimpleNamespace(position=np.full(3, 1e-4 * wall**power))))

    monkeypatch.setattr(coupled, "march", march)
    found = coupled.coupling_order()
    assert found.verdict == verdict
    assert found.checks[0].observed == pytest.approx(power)
    assert found.checks[1].observed == pytest.approx(1e-4 * (1.0 - 0.5**power))
    assert f"Orders observed: {power}.00, {power}.00, {power}.00" in found.note


@pytest.mark.parametrize(("off", "verdict"), [(0.0, "pass"), (1e-9, "fail")])
def test_long_rest_notices_what_moves(monkeypatch: pytest.MonkeyPatch, off: float, verdict: str) -> None:
    """Ten seconds on the shipped grid; one cell of one layer that drifts is enough."""
    model, state = started(coupled.RESTING, {"grid.n_z": 20, "grid.n_z_wall": 20})
    potential = state.circular.potential.copy()
    potential[7, 0] -= off
    asked: list[tuple[float, Any]] = []

    def march(seconds: float, *changes: Mapping[str, Any]) -> March:
        asked.append((seconds, changes[-1]["grid.n_z"]))
        return March(model, [state, replace(state, circular=replace(state.circular, potential=potential))])

    monkeypatch.setattr(coupled, "march", march)
    found = coupled.long_rest()
    assert asked == [(10.0, 1000)]
    assert found.verdict == verdict
    assert [check.observed for check in found.checks] == pytest.approx([off, 0.0], abs=1e-13)


# --- mirror images, energy ----------------------------------------------------------------------------


@pytest.mark.parametrize(("right", "verdict"), [(5.4, "pass"), (5.3, "fail")])
def test_mirror_images_meet_in_the_middle(monkeypatch: pytest.MonkeyPatch, right: float, verdict: str) -> None:
    """The pellet that went to 4.6 cm must have its image at 5.4 cm of 10; conduction is compared for real."""
    places = iter([4.6, right])

    def march(seconds: float, *changes: Mapping[str, Any]) -> SimpleNamespace:
        assert changes[1]["trigger.rule"] == "none"
        return SimpleNamespace(last=SimpleNamespace(pellet=SimpleNamespace(position=next(places))))

    monkeypatch.setattr(dynamics, "march", march)
    found = dynamics.mirror()
    assert found.verdict == verdict
    assert found.checks[0].observed == 0.0
    assert found.checks[1].observed == pytest.approx(5.4 - right, abs=1e-12)
    assert found.checks[2].observed == pytest.approx(0.1)


@pytest.mark.parametrize(("weights", "order"), [((1.0,), 2.0), (FOURTH_ORDER, 4.0)])
def test_energy_swings_with_the_order_of_the_integrator(weights: tuple[float, ...], order: float) -> None:
    """The wall's forces are those of its energy; energies are those of every tenth step, the first of the start."""
    tube = Conservative(8, 10.0)
    swings = [float(np.ptp(tube.march(dt, round(0.064 / dt), 1, weights))) for dt in (1.6e-3, 0.8e-3)]
    assert math.log2(swings[0] / swings[1]) == pytest.approx(order, abs=0.3)
    every, some = (tube.march(8e-4, 40, count, weights) for count in (1, 10))
    assert np.array_equal(some, every[::10])


def test_ends_of_the_conservative_tube_are_held() -> None:
    """And a wall beyond its law is refused."""
    tube = Conservative(8, 10.0)
    z = np.linspace(0.0, 2.0, 9)
    found = tube.acceleration(np.full(9, 0.9), 1.2 * z)
    assert not found[:, [0, -1]].any()
    assert found[0, 1:-1].any()
    with pytest.raises(ValueError, match="shorten the step"):
        tube.acceleration(np.full(9, np.nan), z)


def test_loss_of_the_step_is_the_decay_of_the_peaks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a mode of 4.4 rad/s that falls off with 0.3 /s, also by its negative half waves."""
    asked: list[tuple[float, object]] = []

    def amplitudes(dt: float, end: float, changes: Mapping[str, object]) -> Floats:
        asked.append((end, changes["wall.inertia"]))
        time = np.arange(round(end / dt) + 1) * dt
        return np.asarray(0.05 * np.exp(-0.3 * time) * np.cos(4.4 * time))

    monkeypatch.setattr(dynamics, "rod_amplitudes", amplitudes)
    assert dynamics.lost_by_the_step(1e-3) == pytest.approx(0.3, rel=1e-4)
    assert asked == [(8.0, True)]


@pytest.mark.parametrize(
    ("drift", "power", "verdict"),
    [(0.0, 3, "pass"), (1e-3, 3, "fail"), (0.0, 2, "fail")],
    ids=["right", "drifts", "order"],
)
def test_energy_is_judged_by_swing_drift_and_loss(
    monkeypatch: pytest.MonkeyPatch, drift: float, power: int, verdict: str
) -> None:
    """Swings in proportion to dt^2; a drift of the long march, and a loss of the wrong order, are noticed."""

    def march(tube: Conservative, dt: float, steps: int, every: int, weights: tuple[float, ...] = (1.0,)) -> Floats:
        swing = 0.0 if weights == FOURTH_ORDER else 1e4 * dt**2
        steady = -5.0 + swing * (np.arange(steps // every + 1) % 2)
        return np.asarray(steady * (1.0 + (drift if every > 1 else 0.0) * np.linspace(0.0, 1.0, steady.size)))

    monkeypatch.setattr(Conservative, "march", march)
    monkeypatch.setattr(dynamics, "lost_by_the_step", lambda dt: dt**power)
    found = dynamics.energy()
    assert found.verdict == verdict
    assert found.checks[0].observed == pytest.approx(2.0)
    assert found.checks[1].observed == pytest.approx(0.9 * drift, rel=0.01)
    assert found.checks[2].observed == pytest.approx(power)
