"""The claims as data: complete, decidable, and every verdict can turn."""

from __future__ import annotations

import copy
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis.scoring import rules
from peristalsis.scoring.claim import Claim
from peristalsis.scoring.metrics import METRICS
from peristalsis.scoring.paper.claims import CLAIMS
from peristalsis.scoring.paper.runs import PHASES, RUNS, phase_name
from peristalsis.scoring.paper.searches import SEARCHES, SENSITIVITIES
from peristalsis.scoring.score import FAILS, HOLDS, IN_PART, NOT_RUN, UNTESTABLE, score

Table = dict[str, dict[str, Any]]


def arrives(transit: float, **more: Any) -> dict[str, Any]:
    """A pellet that goes through in `transit` seconds."""
    return {
        "status": "expelled",
        "transit_s": transit,
        "travel_cm": 10.0,
        "mean_velocity_cm_s": 10.0 / transit,
        "irregularity": 0.2,
        "stops": 0,
        "mixing": 0.3,
    } | more


def stays(travel: float = 1.0, **more: Any) -> dict[str, Any]:
    """A pellet that comes to rest."""
    return arrives(math.inf, status="arrested", transit_s=None, travel_cm=travel, irregularity=1.0, stops=1) | more


def as_the_paper_says() -> Table:
    """Numbers under which every claim holds."""
    table: Table = {name: arrives(2.4) for name in RUNS}
    table["baseline"] |= {
        "mean_velocity_cm_s": 4.2,
        "circular_force_rise": 2.0,
        "circular_force_setback": 0.0,
        "end_displacement_cm": 0.0,
        "anal_active_share": 0.0,
    }
    slower = {"fig3e": 4.0, "fig3g": 6.0, "eta_x2": 3.0, "eta_x4": 5.0, "dry_200": 3.0, "fig4b": 2.6, "fig4c": 2.6}
    faster = {"fig3b": 2.2, "fig3c": 2.2, "eta_x0.5": 2.0, "eta_x0.25": 1.8, "osmotic": 2.0, "mineral_oil": 1.9}
    faster |= {"oil_and_bulk": 1.7, "fig7c": 2.0, "pellet_x1.05": 2.2, "pellet_x1.1": 2.0}
    late = {"fig6b": 4.0, "fig6_receptors_alone": 4.0}
    for name, transit in {**slower, **faster, **late}.items():
        table[name] = arrives(transit)
    table["fig6_receptors_alone"]["irregularity"] = 0.8
    table["eta_x2"]["irregularity"] = 0.4
    table["fig3f"] = stays(5.0)
    table["fig3g"]["stops"] = 2
    table["fig6_neither"] = stays(0.5)
    table["fig6_neither_lubricated"] = stays(0.9)
    table["fig7b"] = stays()
    table["fig4d"] = stays(0.0)
    for force in (565, 1200, 1600, 2000):
        table[f"dry_{force}"] = stays(3.0)
    for channel in ("slow_calcium", "fast_calcium", "calcium_potassium"):
        for state in ("decreased", "increased"):
            table[f"fig5_{channel}_{state}"] = arrives(3.0)
    table["ratio_1"] = table["ratio_1.02"] = stays(0.0)
    table["pendular"]["mixing"] = 0.02
    table["segmentation"] = stays(0.0, libration_cm=0.1, drift_cm=0.05)
    table[phase_name(0.0)] = arrives(4.0, mixing=0.1)
    table[f"{phase_name(0.0)}_weak"] = stays()
    for name in SENSITIVITIES:
        table[name] = {"status": "finished", "viscous_low": 0.8, "dry_high": 0.2}
    for name in SEARCHES:
        table[name] = {"status": "finished", "threshold": None}
    table["pressure_of_arrest"]["threshold"] = 16.0
    table["ratio_of_arrest"] |= {"threshold": 1.05, "threshold_inflated": 1.02}
    return table


PERTURBED: dict[int, tuple[str, str, Any]] = {
    1: ("baseline", "transit_s", 3.0),
    2: ("baseline", "irregularity", 0.7),
    3: ("fig3b", "transit_s", 2.5),
    4: ("eta_x4", "transit_s", 2.0),
    5: ("dry_200", "transit_s", 2.3),
    6: ("fig3d", "transit_s", 3.0),
    7: ("dry_565", "status", "expelled"),
    8: ("paper_ranges", "dry_high", 0.9),
    9: ("fig4c", "transit_s", 2.3),
    10: ("pressure_of_arrest", "threshold", 8.0),
    11: ("fig5_slow_calcium_decreased", "transit_s", 2.4),
    12: ("fig5_slow_calcium_increased", "transit_s", 2.3),
    13: ("fig5_fast_calcium_decreased", "transit_s", 2.4),
    14: ("fig5_fast_calcium_increased", "transit_s", 2.0),
    15: ("fig5_calcium_potassium_decreased", "transit_s", 2.4),
    16: ("fig5_calcium_potassium_increased", "transit_s", 2.4),
    17: ("fig6b", "transit_s", 2.3),
    18: ("fig6_receptors_alone", "irregularity", 0.3),
    19: ("fig6_neither", "travel_cm", 0.0),
    20: ("fig6d", "transit_s", 3.5),
    21: ("fig7c", "transit_s", 2.5),
    22: ("pellet_x1.1", "transit_s", 2.5),
    23: ("ratio_of_arrest", "threshold", 0.92),
    24: ("pendular", "mixing", 0.4),
    25: ("segmentation", "drift_cm", 3.0),
    26: ("baseline", "mixing", 0.05),
    27: (phase_name(0.0), "transit_s", 2.4),
    28: ("baseline", "circular_force_setback", 0.5),
    29: ("baseline", "anal_active_share", 0.9),
    30: ("oil_and_bulk", "transit_s", 2.0),
}
"""One number that turns the verdict of each claim."""


def claim(number: int) -> Claim:
    return CLAIMS[number - 1]


def test_there_are_thirty_in_their_order() -> None:
    assert [one.number for one in CLAIMS] == list(range(1, 31))
    assert set(PERTURBED) == set(range(1, 31))


def test_every_run_that_is_asked_for_exists() -> None:
    known = {*RUNS, *SEARCHES, *SENSITIVITIES}
    assert {run for one in CLAIMS for run in one.runs()} <= known


def test_what_served_to_choose_is_marked() -> None:
    assert [one.number for one in CLAIMS if one.use == "calibrated"] == [1]
    assert [one.number for one in CLAIMS if one.use == "chosen"] == [7, 10, 23]


@pytest.mark.parametrize("number", range(1, 31))
def test_every_claim_holds_where_the_paper_is_right(number: int) -> None:
    found = score(claim(number), as_the_paper_says())
    assert (found.verdict, found.failing()) == (HOLDS, ())


@pytest.mark.parametrize("number", range(1, 31))
def test_one_perturbed_number_turns_every_verdict(number: int) -> None:
    run, metric, value = PERTURBED[number]
    table = as_the_paper_says()
    assert table[run][metric] != value
    table[run] = table[run] | {metric: value}
    if metric == "status":  # a pellet that arrives has a transit, and no stop
        table[run] = arrives(3.0)
    found = score(claim(number), table)
    assert found.verdict in (IN_PART, FAILS)
    assert found.failing()


@pytest.mark.parametrize("number", range(1, 31))
def test_every_part_can_fail_and_be_named(number: int) -> None:
    """Turning the world around, run by run, makes each part fail at some point: no rule is empty."""
    everywhere = as_the_paper_says() | {run: arrives(2.4) for run in RUNS}
    failed = set(score(claim(number), everywhere).failing())
    for run in claim(number).runs():
        for worse in _turned(as_the_paper_says()[run]):
            table = as_the_paper_says()
            table[run] = worse
            failed |= set(score(claim(number), table).failing())
    assert failed == {part.name for part in claim(number).parts}


def _turned(metrics: dict[str, Any]) -> list[dict[str, Any]]:
    """The same run with other outcomes: much earlier, much later, arrested, and each number at both extremes."""
    found = [arrives(0.1), arrives(50.0), stays(0.0), stays(0.0, irregularity=None), stays(50.0)]
    found = [metrics | one for one in found]
    for key, value in metrics.items():
        if isinstance(value, int | float):
            found += [metrics | {key: extreme} for extreme in (-1e6, 1e6)]
    return found


@pytest.mark.parametrize("number", range(1, 31))
def test_missing_runs_give_no_verdict(number: int) -> None:
    assert score(claim(number), {}).verdict == NOT_RUN


def test_a_refused_experiment_is_not_testable() -> None:
    """Fig. 7 C in a tube that cannot hold the pellet: the other part is still judged, and the claim is not whole."""
    table = as_the_paper_says()
    table["fig7c"] = {"status": "refused", "error": "the tube cannot hold this pellet"}
    found = score(claim(21), table)
    assert found.verdict == IN_PART
    assert found.failing() == ("r0 = 0.6 faster (not testable)",)
    assert "cannot hold" in found.numbers()
    table["fig7b"] = {"status": "diverged", "error": None}
    assert score(claim(21), table).verdict == UNTESTABLE


def test_never_is_later_than_any_time() -> None:
    table = {"a": stays(5.0), "b": arrives(9.0), "c": stays(2.0)}
    assert rules.Later("a", "b").judge(table).holds is True
    assert rules.Later("b", "a").judge(table).holds is False
    assert rules.Later("c", "a").judge(table).holds is True
    assert rules.Later("a", "c").judge(table).holds is False


def test_differences_below_the_grid_error_do_not_count() -> None:
    table = {"a": arrives(2.40), "b": arrives(2.42), "c": arrives(2.43)}
    assert rules.Later("b", "a").judge(table).holds is False
    assert rules.Later("c", "a").judge(table).holds is True


def test_combined_rules_with_something_unknown() -> None:
    table = {"a": arrives(2.0)}
    true, false, unknown = (rules.Ends("a", ("expelled",)), rules.Ends("a", ("arrested",)), rules.Ends("b", ()))
    assert rules.AllOf((true, unknown)).judge(table).holds is None
    assert rules.AllOf((false, unknown)).judge(table).holds is False
    assert rules.AnyOf((true, unknown)).judge(table).holds is True
    assert rules.AnyOf((false, unknown)).judge(table).holds is None
    assert rules.AnyOf((false, unknown)).judge(table).missing
    assert rules.Not(unknown).judge(table).holds is None
    assert rules.Not(false).judge(table).holds is True


times = st.one_of(st.none(), st.floats(0.5, 9.0))


@given(times, times, st.integers(0, 3), st.integers(0, 3))
def test_a_margin_is_positive_where_a_rule_holds_and_negative_where_not(
    first: float | None, second: float | None, stops: int, others: int
) -> None:
    table = {
        name: stays(3.0, stops=count) if time is None else arrives(time, stops=count)
        for name, time, count in (("a", first, stops), ("b", second, others))
    }
    single: list[rules.Rule] = [
        rules.Within("a", "transit_s", 2.0, 3.0),
        rules.Within("a", "stops", high=0),
        rules.Ends("a", ("expelled",)),
        rules.Later("a", "b"),
        rules.InTime("a", "b", 0.1, 0.2),
        rules.Exceeds("a", "transit_s", "b", factor=1.25),
        rules.Exceeds("a", "stops", "b"),
    ]
    joined = [rules.AllOf(tuple(single[:2])), rules.AnyOf(tuple(single[3:])), rules.Not(single[3])]
    for rule in (*single, *joined):
        found = rule.judge(table)
        assert found.margin >= 0.0 if found.holds else found.margin <= 0.0, (rule, found)


def test_a_margin_is_the_share_of_the_bound() -> None:
    table = {"a": arrives(2.4, stops=0), "b": arrives(3.0, stops=0), "c": stays(2.0), "d": stays(4.0)}
    assert rules.Within("a", "transit_s", high=2.0).judge(table).margin == pytest.approx(-0.2)
    assert rules.Later("b", "a").judge(table).margin == pytest.approx(0.25 - 0.01)
    assert rules.Later("c", "d").judge(table).margin == pytest.approx(0.49)
    assert rules.InTime("b", "a", above=0.2).judge(table).margin == pytest.approx(-0.05)
    assert rules.Exceeds("b", "transit_s", "a", factor=1.5).judge(table).margin == pytest.approx(3.0 / 3.6 - 1.0)
    assert rules.Exceeds("a", "stops", "b").judge(table).margin == -1.0  # one more would do
    assert math.isnan(rules.Ends("e", ("expelled",)).judge(table).margin)
    later, slower = rules.Later("b", "a"), rules.Within("b", "transit_s", high=2.0)
    assert rules.AllOf((later, slower)).judge(table).decisive == slower.judge(table).numbers
    assert rules.AnyOf((later, slower)).judge(table).decisive == later.judge(table).numbers


def test_an_undefined_number_meets_no_bound() -> None:
    table = {"a": stays(0.0, irregularity=None)}
    found = rules.Within("a", "irregularity").judge(table)
    assert (found.holds, "undefined" in found.numbers) == (False, True)


def test_metrics_of_the_rules_are_defined() -> None:
    studies = {"threshold", "threshold_inflated", "viscous_low", "dry_high"}

    def metrics(rule: Any) -> set[str]:
        inner = getattr(rule, "rules", None) or ([rule.rule] if isinstance(rule, rules.Not) else [])
        own = {getattr(rule, name, None) for name in ("metric", "other_metric")} - {None}
        return own.union(*(metrics(one) for one in inner))

    used = {metric for one in CLAIMS for part in one.parts for metric in metrics(part.rule)}
    assert used <= {*METRICS, *studies}


def test_the_phases_hold_the_synchronous_case_and_both_sides() -> None:
    assert 0.0 in PHASES
    assert min(PHASES) == -0.5
    assert max(PHASES) == 1.0


def test_judging_changes_nothing() -> None:
    table = as_the_paper_says()
    kept = copy.deepcopy(table)
    for one in CLAIMS:
        score(one, table)
    assert table == kept
