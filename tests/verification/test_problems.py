"""Every exact problem of the package as a test, and the machinery that turns numbers into verdicts."""

import math

import pytest

from peristalsis.errors import ConfigurationError
from verification.problem import (
    Check,
    Outcome,
    Problem,
    elsewhere,
    equal,
    error,
    judged,
    not_applicable,
    order,
)
from verification.registry import chosen, problems

CASES = [
    pytest.param(problem, id=problem.id, marks=() if problem.tier == "quick" else pytest.mark.slow)
    for problem in problems().values()
]


@pytest.mark.problem
@pytest.mark.parametrize("problem", CASES)
def test_problem(problem: Problem) -> None:
    """Nothing fails; what is not applicable or kept elsewhere says why or where."""
    outcome = problem.run()
    failed = [f"{c.what}: {c.observed:.6g}, accepted {c.bounds}" for c in outcome.checks if not c.passed]
    assert outcome.verdict != "fail", failed
    assert outcome.checks or outcome.note


def test_registry_is_in_order_and_complete() -> None:
    """Families in the order of the tables, numbers rising; both tiers occur; every problem has a source."""
    names = list(problems())
    assert names.index("E2") < names.index("E10") < names.index("M1")
    assert all(problem.source and problem.title for problem in problems().values())
    assert chosen(full=True) == tuple(problems().values())
    assert {problem.tier for problem in chosen()} == {"quick"}
    assert [problem.id for problem in chosen(("M4", "E1", "M4"))] == ["M4", "E1"]


def test_unknown_problem_is_named() -> None:
    with pytest.raises(ConfigurationError, match=r"problem = 'E99'.*no such problem"):
        chosen(("E99",))


@pytest.mark.parametrize("bad", [1.1, -1.1, math.nan, math.inf])
def test_checks_fail_outside_their_bounds(bad: float) -> None:
    """A verdict can fail: on either side, and for what is no number."""
    assert Check("x", 1.0, -1.0, 1.0).passed
    assert not Check("x", bad, -1.0, 1.0).passed
    assert judged("x", [error("e", bad, 1.0)]).verdict == "fail"


def test_one_bad_check_fails_the_problem() -> None:
    good, bad = error("good", 0.5, 1.0), equal("bad", 1.0 + 1e-15, 1.0)
    assert judged("x", [good]).verdict == "pass"
    outcome = judged("x", [good, bad])
    assert outcome.verdict == "fail"
    assert outcome.error == 0.5


def test_orders_are_gated_from_both_sides() -> None:
    """Too good is a failure as well: then the problem does not exercise the scheme."""
    sizes = [0.8, 0.4, 0.2, 0.1]
    for observed, passes in ((1.95, True), (2.05, True), (1.8, False), (2.2, False)):
        check = order("in space", sizes, [h**observed for h in sizes], 2.0)
        assert check.observed == pytest.approx(observed)
        assert check.passed is passes
    mixed = order("", sizes, [0.64, 0.16, 0.04, 0.02], 2.0)
    assert mixed.observed == pytest.approx(1.0)
    with pytest.raises(ValueError, match="give four levels"):
        order("in space", sizes[:3], [1.0, 0.5, 0.25], 1.0)
    with pytest.raises(ValueError, match="errors above zero"):
        order("in space", sizes, [1.0, 0.5, 0.0, 0.0], 1.0)


def test_verdicts_without_checks_carry_a_reason() -> None:
    """Nothing passes for want of checks."""
    with pytest.raises(ValueError, match="nothing was checked"):
        judged("x", [])
    outcomes: list[Outcome] = [not_applicable("x", "no explicit wall"), elsewhere("x", "docs/a.md")]
    assert [(o.verdict, o.note) for o in outcomes] == [
        ("not applicable", "no explicit wall"),
        ("elsewhere", "docs/a.md"),
    ]
