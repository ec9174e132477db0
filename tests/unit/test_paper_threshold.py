"""The threshold search on functions whose thresholds are known."""

import pytest

from peristalsis.many.threshold import find_threshold

SCAN = (1.0, 2.0, 5.0, 10.0, 20.0)


@pytest.mark.parametrize("true", [1.3, 4.99, 7.77, 19.0])
def test_a_step_is_bracketed_to_two_per_cent(true: float) -> None:
    found = find_threshold(lambda value: value > true, SCAN)
    assert found.low is not None
    assert found.high is not None
    assert found.value is not None
    assert found.low <= true <= found.high
    assert found.high - found.low <= 0.02 * found.value
    assert found.monotone
    assert len(found.changes) == 1


@pytest.mark.parametrize("constant", [True, False])
def test_no_change_is_no_threshold(constant: bool) -> None:
    found = find_threshold(lambda value: constant, SCAN)
    assert (found.low, found.value, found.changes) == (None, None, ())
    assert found.monotone


def test_regions_that_are_not_monotone_are_shown() -> None:
    """An island between 4 and 6 is reported beside the last change, at 15."""
    found = find_threshold(lambda value: 4.0 < value < 6.0 or value > 15.0, SCAN)
    assert not found.monotone
    assert found.changes == ((2.0, 5.0), (5.0, 10.0), (10.0, 20.0))
    assert found.value == pytest.approx(15.0, rel=0.02)
    assert [holds for _, _, holds in found.regions()] == [False, True, False, True]


def test_a_fall_alone_is_no_threshold_and_not_monotone() -> None:
    found = find_threshold(lambda value: value < 3.0, SCAN)
    assert found.value is None
    assert found.changes == ((2.0, 5.0),)
    assert not found.monotone


def test_points_that_say_nothing_are_left_out() -> None:
    """A run that breaks off is neither below nor above; the bracket stays where it is known."""
    found = find_threshold(lambda value: None if 10.0 <= value < 16.0 else value > 7.0, SCAN)
    assert (found.low, found.high) == (5.0, 20.0)
    blind = find_threshold(lambda value: None if 5.0 < value < 10.0 else value > 5.0, SCAN)
    assert (blind.low, blind.high) == (5.0, 10.0)
    assert blind.points[3].holds is None


def test_the_scan_may_be_made_at_once() -> None:
    seen = []

    def scan(values):
        seen.append(tuple(values))
        return [value > 7.0 for value in values]

    found = find_threshold(lambda value: value > 7.0, (20.0, 1.0, 10.0, 5.0), scan=scan)
    assert seen == [(1.0, 5.0, 10.0, 20.0)]
    assert found.value == pytest.approx(7.0, rel=0.02)
