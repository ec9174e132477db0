"""The calibration of the bench: its ranges, its stages, what it calls fixed and free, and the same table each time."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from peristalsis.inputs.config import Configuration
from peristalsis.inputs.parameters import PREPARATIONS
from peristalsis.many.rows import Row
from peristalsis.scoring import calibrated, runs
from peristalsis.scoring.bench.source import SOURCE
from peristalsis.scoring.calibration import SHIPPED, Calibration, Search, fails, good_points, holds
from peristalsis.scoring.runs import Bench

assert SOURCE.calibration is not None
PLAN = SOURCE.calibration()
NUMBERS = PREPARATIONS["guinea_pig_distal_colon"].parameters
SMALL = replace(PLAN, samples=16, rounds=1, refined=8, kept=0.25, claims=(1,), held_out=(10,))
ALONE = replace(SMALL, screening=(("control",),))

Speed = Callable[[Configuration], float]


def carried_out(
    monkeypatch: pytest.MonkeyPatch, folder: Path, plan: Calibration, speed: Speed, status: str = "expelled"
) -> tuple[Any, ...]:
    """The calibration with a made-up speed [mm/s] in place of runs."""

    def sweep(configurations: Mapping[str, Configuration], *_: Any) -> dict[str, Row]:
        return {
            name: Row({"status": status, "middle_speed_mm_s": speed(one), "contact_kPa": 1.0, "peak_force_mN": 40.0})
            for name, one in configurations.items()
        }

    monkeypatch.setattr(runs, "sweep", sweep)
    return Search(Bench(SOURCE, folder), plan, SOURCE.sets[0]).carry_out()


def steep(configuration: Configuration) -> float:
    """Decided by how strongly neurons drive, and by nothing else."""
    return 2.0 * (configuration.reflex.excitation_intensity / 0.75) ** 4


def traded(configuration: Configuration) -> float:
    """Decided by a product of two constants."""
    reflex = configuration.reflex
    return 2.0 * reflex.excitation_intensity / 0.75 * reflex.delay / 0.7


def test_ranges_are_those_of_the_preparation() -> None:
    for one in PLAN.free:
        for key in one.keys:
            assert (one.low, one.high) == (NUMBERS[key].low, NUMBERS[key].high) or key != one.keys[0]
            assert NUMBERS[key].tag != "printed"
    assert set(PLAN.claims) | set(PLAN.held_out) <= {claim.number for claim in SOURCE.claims}
    assert not set(PLAN.claims) & set(PLAN.held_out)
    assert {run for stage in PLAN.screening for run in stage} <= set(SOURCE.runs)


def test_points_lie_in_their_ranges_and_come_again_from_the_seed() -> None:
    count = len(PLAN.free)
    drawn = PLAN.drawn(0, [0.0] * count, [1.0] * count)
    assert len(drawn) == PLAN.samples
    assert drawn == PLAN.drawn(0, [0.0] * count, [1.0] * count)
    assert drawn != replace(PLAN, seed=PLAN.seed + 1).drawn(0, [0.0] * count, [1.0] * count)
    inner = np.array([PLAN.shares(one) for one in PLAN.drawn(1, [0.25] * count, [0.5] * count)])
    assert inner.min() >= 0.25 - 1e-3
    assert inner.max() <= 0.5 + 1e-3


def test_the_shipped_point_is_the_preparation(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    shipped = carried_out(monkeypatch, tmp_path, replace(ALONE, samples=2, rounds=0), steep)[0]
    assert shipped.name == SHIPPED
    for one in PLAN.free:
        assert shipped.values[one.name] == NUMBERS[one.keys[0]].value
    assert holds(SOURCE.claims, ALONE, shipped)


def test_a_point_is_given_up_when_a_rule_fails(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    found = carried_out(monkeypatch, tmp_path, SMALL, steep)
    slow = [one for one in found if fails(SOURCE.claims, SMALL, one)]
    assert slow
    assert all(set(one.measured) == {"control"} and not one.complete for one in slow)
    assert all(len(one.measured) > 1 and one.complete for one in found if one not in slow)


def test_what_decides_is_fixed_and_what_does_not_is_free(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    found = carried_out(monkeypatch, tmp_path, ALONE, steep)
    table = calibrated.constants(SOURCE.claims, ALONE, found)
    left = {row[0].split(",")[0]: row[table.columns.index("left")] for row in table.rows}
    assert left.pop("reflex.excitation_intensity") == "fixed"
    assert set(left.values()) == {"free"}
    speeds = [steep_of(one.values["excitation"]) for one in good_points(SOURCE.claims, ALONE, found)]
    assert len(speeds) > 4
    assert all(1.0 <= speed <= 3.0 for speed in speeds)


def steep_of(excitation: float | str) -> float:
    return 2.0 * (float(excitation) / 0.75) ** 4


def test_a_product_is_fixed_though_its_factors_are_not(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    plan = replace(ALONE, samples=64, rounds=0)
    found = carried_out(monkeypatch, tmp_path, plan, traded)
    table = calibrated.constants(SOURCE.claims, plan, found)
    spreads = [float(row[table.columns.index("spread")].rstrip("%")) for row in table.rows]
    together = calibrated.combinations(SOURCE.claims, plan, found)
    best, by_chance = together.rows[0], together.rows[-1]
    assert float(best[0].rstrip("%")) < min(float(by_chance[0].rstrip("%")), *spreads)
    assert re.search(r"\+0\.[6-9]\d excitation.* \+0\.[4-7]\d delay", best[1])


def test_runs_that_break_off_fail_and_are_not_left_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    found = carried_out(monkeypatch, tmp_path, ALONE, steep, status="diverged")
    assert not good_points(SOURCE.claims, ALONE, found)
    assert len(calibrated.points(SOURCE.claims, ALONE, found).rows) == 1 + ALONE.samples + ALONE.refined
    table = calibrated.constants(SOURCE.claims, ALONE, found)
    assert {row[table.columns.index("left")] for row in table.rows} == {"free"}


def test_the_same_calibration_gives_the_same_tables(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    first, second = (
        calibrated.points(SOURCE.claims, plan, carried_out(monkeypatch, tmp_path, plan, steep)).csv()
        for plan in (replace(ALONE, samples=8, refined=4),) * 2
    )
    assert first == second
