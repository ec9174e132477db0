"""Claims that hold together at points of a search: the front, pairs that exclude one another, and near misses."""

from __future__ import annotations

from typing import Any

from peristalsis.scoring.claim import Claim, Part
from peristalsis.scoring.rules import Within
from peristalsis.scoring.together import exclusive, exclusive_table, front, front_table, nearest_table


def claim(number: int, metric: str, low: float) -> Claim:
    return Claim(number, "", "", (Part(f"{metric} of {low:g}", Within("run", metric, low)),))


CLAIMS = (claim(1, "x_s", 1.0), claim(2, "y_s", 1.0), claim(3, "z_s", 2.0))


def at(**metrics: float) -> dict[str, dict[str, Any]]:
    return {"run": {"status": "expelled", "error": None, **metrics}}


FOUND = {
    "p": at(x_s=1.5, y_s=0.0, z_s=0.5),
    "q": at(x_s=0.0, y_s=1.5, z_s=1.8),
    "r": at(x_s=0.0, y_s=1.2, z_s=1.0),
    "s": at(x_s=0.9, y_s=0.9, z_s=1.0),
}


def test_the_front_has_the_largest_sets_and_no_part_of_another() -> None:
    sets = {"a": frozenset({1, 2}), "b": frozenset({1}), "c": frozenset({3}), "d": frozenset({1, 2}), "e": frozenset()}
    assert front(sets) == {frozenset({1, 2}): ("a", "d"), frozenset({3}): ("c",)}
    assert next(iter(front(sets))) == {1, 2}


def test_claims_exclude_one_another_if_both_hold_somewhere_and_never_at_once() -> None:
    sets = {"a": frozenset({1, 2}), "b": frozenset({2, 3})}
    assert exclusive(sets) == ((1, 3),)
    assert exclusive({}) == ()
    assert exclusive(sets, {"a": frozenset({3})}) == ()  # 3 was not run where 1 holds


def test_tables_of_points() -> None:
    assert front_table(CLAIMS, FOUND).rows == (("1", "1", "2", "p"), ("1", "2", "1", "q, r"))
    assert exclusive_table(CLAIMS, FOUND).rows == (("1", "2", "1", "2"),)


def test_the_nearest_point_of_a_claim_that_holds_nowhere() -> None:
    rows = {row[0]: row for row in nearest_table(CLAIMS, FOUND).rows}
    assert rows["3"] == (
        *("3", "0 of 4", "z_s of 2", "0 of 4", "-10.00%"),
        *("run: z_s 1.8 s (asked: at least 2)", "q"),
    )
    assert rows["1"][1] == "1 of 4"


def test_points_that_were_not_run_are_not_counted() -> None:
    rows = nearest_table(CLAIMS, {**FOUND, "t": {}}).rows
    assert [row[1] for row in rows] == ["1 of 4", "2 of 4", "0 of 4"]
    assert nearest_table(CLAIMS, {"t": {}}).rows[0][4:] == ("–", "not judged", "–")
