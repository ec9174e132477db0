"""The lessons: what they ask can be asked, what they judge follows from numbers, what they teach is so."""

from typing import Any

import pytest

from peristalsis.app.asked import read
from peristalsis.app.lessons import BY_NAME, LESSONS, Lesson
from peristalsis.app.outcomes import outcome
from peristalsis.running.simulation import Simulation

TRUTH = {
    "wave": "behind",
    "friction": "less",
    "pressure": "same",
    "channels": "first",
    "reflex": "first",
    "wide": "first",
}
"""What the model answers under the shipped reading."""


def told(status: str = "expelled", **numbers: float) -> dict[str, Any]:
    return {"status": status, "numbers": [{"key": key, "value": value} for key, value in numbers.items()]}


def test_there_are_six() -> None:
    assert len(LESSONS) == len(BY_NAME) == 6
    assert {lesson.name for lesson in LESSONS} == set(TRUTH)


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.name)
def test_a_page_may_ask_for_what_they_set(lesson: Lesson) -> None:
    """And each of the runs of a lesson differs from the other in what its name says."""
    found = [read(dict(one.asked)).configuration() for one in lesson.settings]
    assert len({configuration.digest() for configuration in found}) == len(found)
    assert "answer" not in lesson.shown()
    assert lesson.because not in str(lesson.shown()), "the answer is not sent before it is found"


@pytest.mark.parametrize(
    ("name", "outcomes", "answer"),
    [
        ("wave", [told(narrowest_behind_cm=1.0)], "behind"),
        ("wave", [told(narrowest_behind_cm=-1.0)], "ahead"),
        ("wave", [told(narrowest_behind_cm=0.1)], "middle"),
        ("wave", [told()], None),
        ("friction", [told(transit_s=2.0), told(transit_s=2.1)], "same"),
        ("friction", [told(transit_s=2.0), told(transit_s=3.0)], "less"),
        ("friction", [told(transit_s=2.0), told(transit_s=4.0)], "twice"),
        ("friction", [told(transit_s=2.0), told(transit_s=5.0)], "more"),
        ("friction", [told(transit_s=2.0), told("arrested")], None),
        ("pressure", [told(transit_s=2.0), told(transit_s=2.05)], "same"),
        ("pressure", [told(transit_s=2.0), told(transit_s=1.5)], "faster"),
        ("pressure", [told(transit_s=2.0), told(transit_s=2.5)], "slower"),
        ("pressure", [told("arrested"), told(transit_s=2.5)], None),
        ("channels", [told(transit_s=3.0), told(transit_s=2.4)], "first"),
        ("channels", [told(transit_s=2.4), told(transit_s=3.0)], "second"),
        ("channels", [told(transit_s=2.4), told(transit_s=2.4)], "both"),
        ("channels", [told("arrested"), told(transit_s=2.4)], "first"),
        ("channels", [told("arrested"), told("arrested")], None),
        ("reflex", [told(), told("arrested")], "first"),
        ("reflex", [told("in_transit"), told("arrested")], "none"),
        ("wide", [told("arrested"), told()], "second"),
        ("wide", [told(), told()], "both"),
    ],
)
def test_answers_follow_from_numbers(name: str, outcomes: list[dict[str, Any]], answer: str | None) -> None:
    lesson = BY_NAME[name]
    assert lesson.judged(outcomes) == answer
    assert answer is None or answer in lesson.choices


def test_the_answer_comes_with_the_numbers_it_is_of() -> None:
    """What came of each run, so that a guess that was wrong can be seen to be."""
    found = [told(transit_s=2.382), {**told("arrested"), "words": "The pellet has come to rest"}]
    assert BY_NAME["friction"].told(found) == ("230 mN·s/cm: transit 2.38 s; 460 mN·s/cm: the pellet has come to rest.")
    found = [told(narrowest_behind_cm=1.234)]
    assert BY_NAME["wave"].told(found) == "Normal transit: narrowest place behind the centre 1.23 cm."


@pytest.mark.slow
@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.name)
def test_what_they_teach_is_so(lesson: Lesson) -> None:
    found = [outcome(Simulation(read(dict(one.asked)).configuration()).run()) for one in lesson.settings]
    assert lesson.judged(found) == TRUTH[lesson.name]
