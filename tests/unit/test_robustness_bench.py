"""The bench of random configurations: its plan is the same everywhere, and its rules find what they are for."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import pytest

import peristalsis as ps
from peristalsis.errors import ConfigurationError

HERE = Path(__file__).resolve().parents[2] / "robustness"
if not HERE.is_dir():
    pytest.skip("the bench is not part of the package", allow_module_level=True)
sys.path.insert(0, str(HERE))

import plan  # noqa: E402
import report  # noqa: E402
import rules  # noqa: E402

GOOD: dict[str, Any] = {
    "number": 1,
    "group": "pellet",
    "outcome": "in_transit",
    "summary": {"power_residual": 1e-5, "transit_s": None, "final_position_cm": 3.0, "wave_speed_cm_s": {"a": 4.0}},
    "remarks": [],
    "events": [],
    "ends": {"oral_pole": 0.2, "anal_pole": 8.0, "length": 10.0},
}


def test_plan_is_deterministic_and_large_enough() -> None:
    cases = plan.read()
    assert cases == plan.read()
    assert [case.number for case in cases] == list(range(len(cases)))
    assert len(cases) == 440
    assert len({case.group for case in cases[:40]}) >= 12, "any beginning covers the groups"


def test_every_configuration_is_one() -> None:
    """Names and units of the plan are right; a value may still be refused for what it means together with others."""
    refusals = []
    for case in plan.read()[::9]:
        try:
            ps.configuration(case.scenario, reading=case.reading, changes=dict(case.changes))
        except ConfigurationError as error:
            refusals.append(str(error))
    assert [told for told in refusals if not rules.tells(told)] == []


def test_quick_plan_is_a_part() -> None:
    whole = {case.number: case for case in plan.read()}
    for case in plan.read(quick=True):
        assert whole[case.number].changes.items() - case.changes.items() <= {("run.duration", "4 s")}


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"outcome": "traceback", "sentence": "ValueError: x"}, "traceback"),
        ({"outcome": "too_slow"}, "too_slow"),
        ({"outcome": "refused", "sentence": "no"}, "names no parameter"),
        ({"outcome": "refused", "sentence": "lower lumen.pressure", "second_opinion": "half the grid"}, "wrongly"),
        ({"outcome": "diverged", "sentence": "lower step.wall", "second_opinion": "half the step"}, "broken off"),
        ({"sentence": "unforeseen ValueError"}, "unforeseen"),
        ({"summary": {"wave_speed_cm_s": {"longitudinal": -1e19}}}, "wave_speed"),
        ({"summary": {"wave_speed_cm_s": {"longitudinal": 25.0}}}, "wave_speed"),
        ({"summary": {"max_axial_force_mN": math.nan}}, "max_axial_force"),
        ({"ends": {"oral_pole": -0.1, "anal_pole": 1.0, "length": 10.0}}, "oral end"),
        ({"ends": {"oral_pole": 1.0, "anal_pole": 10.1, "length": 10.0}}, "anal end"),
        ({"summary": {"power_residual": 2e-3}}, "work left over"),
    ],
)
def test_rules_find_what_they_are_for(change: dict[str, Any], word: str) -> None:
    assert rules.faults(GOOD) == []
    assert any(word in fault for fault in rules.faults(GOOD | change))


@pytest.mark.parametrize(
    "change",
    [
        {"outcome": "refused", "sentence": "no tube at lumen.pressure = 9 kPa; lower the pressure"},
        {"ends": {"oral_pole": -0.1, "anal_pole": 1.0, "length": 10.0}, "remarks": ["the pellet passed the oral end"]},
        {"outcome": "expelled", "ends": {"oral_pole": 1.0, "anal_pole": 10.1, "length": 10.0}},
        {"summary": {"power_residual": 2e-3}, "remarks": ["energy does not close"]},
        {"summary": {"wave_speed_cm_s": {"longitudinal": None}}},
    ],
)
def test_what_is_said_is_no_fault(change: dict[str, Any]) -> None:
    assert rules.faults(GOOD | change) == []


def test_change_of_an_answer() -> None:
    passed, other = {"summary": {"transit_s": 2.0}}, {"summary": {"transit_s": 2.1}}
    assert rules.change(passed, other) == pytest.approx(0.05)
    assert rules.change(passed, GOOD) == math.inf
    assert rules.change(GOOD, GOOD | {"summary": {"final_position_cm": 3.5}}) == pytest.approx(0.05)


def test_regression_names_what_moved(tmp_path: Path) -> None:
    file = tmp_path / "last.csv"
    report.write_table(file, [GOOD])
    assert "No outcome changed" in report.regression([GOOD], report.read_table(file))
    moved = GOOD | {"outcome": "arrested"}
    assert "| 1 | pellet | in_transit 3 | arrested 3.0 |" in report.regression([moved], report.read_table(file))
