"""Six guided experiments: a question, a prediction to make, and an answer that is found by running."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from .outcomes import NUMBERS, SQUEEZED

Outcome = Mapping[str, Any]


@dataclass(frozen=True)
class Setting:
    """One run of a lesson, as a page asks for runs (`asked.read`), and what it is called."""

    label: str
    asked: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Lesson:
    """An experiment on one run or two.

    choices: what may be predicted, by key. judged: the key that the outcomes of the runs show to be true, or None
    where they show none of them. because: the reason, told after the answer. about: key of the number that is told
    with it.
    """

    name: str
    title: str
    question: str
    watch: str
    settings: tuple[Setting, ...]
    choices: Mapping[str, str]
    judged: Callable[[Sequence[Outcome]], str | None]
    because: str
    about: str = "transit_s"

    def shown(self) -> dict[str, Any]:
        """What the page needs of it; the answer is not among it."""
        return {
            "name": self.name,
            "title": self.title,
            "question": self.question,
            "watch": self.watch,
            "settings": [{"label": one.label, "asked": dict(one.asked)} for one in self.settings],
            "choices": [{"key": key, "text": text} for key, text in self.choices.items()],
        }

    def told(self, outcomes: Sequence[Outcome]) -> str:
        """What came of each run, in a sentence: its status, and the number that the lesson is about."""
        said = []
        for setting, outcome in zip(self.settings, outcomes, strict=True):
            value = number(outcome, self.about)
            label, unit = next(((label, unit) for key, label, unit in (*NUMBERS, SQUEEZED) if key == self.about))
            words = f"{label.lower()} {value:.3g} {unit}" if value is not None else outcome["words"].lower()
            said.append(f"{setting.label}: {words}")
        return f"{'; '.join(said)}."


def number(outcome: Outcome, key: str) -> float | None:
    """A number of an outcome by its key."""
    return next((one["value"] for one in outcome["numbers"] if one["key"] == key), None)


def _place(outcomes: Sequence[Outcome]) -> str | None:
    behind = number(outcomes[0], "narrowest_behind_cm")
    if behind is None:
        return None
    return "behind" if behind > 0.3 else "ahead" if behind < -0.3 else "middle"


def _times(outcomes: Sequence[Outcome]) -> str | None:
    first, second = (number(one, "transit_s") for one in outcomes)
    if first is None or second is None:
        return None
    ratio = second / first
    return "same" if ratio < 1.1 else "less" if ratio < 1.9 else "twice" if ratio < 2.1 else "more"


def _faster(outcomes: Sequence[Outcome]) -> str | None:
    first, second = (number(one, "transit_s") for one in outcomes)
    if first is None or second is None:
        return None
    ratio = second / first
    return "same" if 0.95 < ratio < 1.05 else "slower" if ratio > 1.0 else "faster"


def _slower_one(outcomes: Sequence[Outcome]) -> str | None:
    first, second = (number(one, "transit_s") or math.inf for one in outcomes)  # what stays behind is slowest
    if first == second == math.inf:
        return None
    return "both" if 0.95 < second / first < 1.05 else "first" if second < first else "second"


def _leaves(outcomes: Sequence[Outcome]) -> str:
    left = [one["status"] == "expelled" for one in outcomes]
    return {(True, False): "first", (False, True): "second", (True, True): "both", (False, False): "none"}[
        (left[0], left[1])
    ]


PACED_OFF = {"switches": {"pacemaker": False}}

LESSONS = (
    Lesson(
        "wave",
        "The wave and the pellet",
        "A wave of contraction runs along the tube. Where is the tube narrowest while the pellet is fastest?",
        "Follow the dark band in the map: narrow is dark. The white line is the pellet's centre.",
        (Setting("Normal transit"),),
        {
            "behind": "On the oral side, behind the pellet",
            "middle": "Around the middle of the pellet",
            "ahead": "On the anal side, ahead of the pellet",
        },
        _place,
        "A ring that closes behind the pellet presses on a surface that faces it, and the part of that pressure along "
        "the tube pushes the pellet on. Around the middle it would only squeeze, ahead it would push back.",
        "narrowest_behind_cm",
    ),
    Lesson(
        "friction",
        "What friction does",
        "The viscous friction of the pellet is doubled. What happens to its transit time?",
        "Compare both tracks: how far does the ring get ahead of the slow pellet?",
        (
            Setting("230 mN·s/cm", {"values": {"viscous_friction": 230}}),
            Setting("460 mN·s/cm", {"values": {"viscous_friction": 460}}),
        ),
        {
            "same": "It stays about the same: the wave sets the pace",
            "less": "It grows, but to less than twice",
            "twice": "It doubles",
            "more": "It grows to more than twice",
        },
        _times,
        "The push of the wall is not fixed. The ring comes closer to a pellet that lags, stretches over more of it and "
        "pushes harder, so part of the friction is made up for, until the wave runs over the pellet and leaves it.",
    ),
    Lesson(
        "pressure",
        "Pressure in the lumen",
        "The pressure in the lumen is raised from 0.1 to 1 kPa. Does the pellet travel faster or slower?",
        "Look at the force budget: which force is larger by far, and which way does pressure act?",
        (
            Setting("0.1 kPa", {"values": {"pressure": 0.1}}),
            Setting("1 kPa", {"values": {"pressure": 1.0}}),
        ),
        {"faster": "Faster", "same": "Just as fast, within 5 %", "slower": "Slower"},
        _faster,
        "The content is at one pressure on both sides of the pellet, so it does not push it. It only widens the tube a "
        "little, and muscle of a few kPa hardly notices.",
    ),
    Lesson(
        "channels",
        "Channels and drugs",
        "Drugs block calcium channels: half of the fast ones, or half of the slow ones. Which slows the pellet more?",
        "Compare the currents: which of the two is larger when the wave passes?",
        (
            Setting("Half of the fast channels", {"values": {"fast_calcium": 50}}),
            Setting("Half of the slow channels", {"values": {"slow_calcium": 50}}),
        ),
        {"first": "Blocking the fast ones", "second": "Blocking the slow ones", "both": "Both alike, within 5 %"},
        _slower_one,
        "The fast current makes the upstroke: with half of it the wave is slower, and the pellet with it. The slow one "
        "is small during a single wave; it matters for whether cells fire again by themselves. Agents that block "
        "them are under Drugs, by name and dose.",
    ),
    Lesson(
        "reflex",
        "A reflex without a pacemaker",
        "The pacemaker is switched off. Does the pellet leave, with stretch receptors and without?",
        "Where does the first contraction begin in the first run, and when?",
        (
            Setting("Receptors", {"switches": {"pacemaker": False, "receptors": True}}),
            Setting("No receptors", {"switches": {"pacemaker": False, "receptors": False}, "values": {"duration": 4}}),
        ),
        {
            "both": "In both cases",
            "first": "Only with receptors",
            "second": "Only without receptors",
            "none": "In neither case",
        },
        _leaves,
        "The pellet stretches the wall. Receptors answer with excitation on its oral side and inhibition on its anal "
        "side, and that is enough to start a wave where it is needed. Without them nothing starts one.",
    ),
    Lesson(
        "wide",
        "Wide and narrow",
        "The same pellet of 1.8 cm in a tube of 1.2 cm and in one of 2.2 cm: which tube carries it to the end?",
        "Look for the contact: where does the wall touch the pellet, drawn as a thick line?",
        (
            Setting("Tube of 1.2 cm", {"values": {"tube_diameter": 1.2}}),
            Setting("Tube of 2.2 cm", {"values": {"tube_diameter": 2.2}}),
        ),
        {"both": "Both", "first": "Only the narrow one", "second": "Only the wide one", "none": "Neither"},
        _leaves,
        "In the wide tube the pellet lies loose: the wave squeezes it for a moment and runs past. It needs a wall that "
        "stays in touch with it, and the reflex needs a wall that it stretches.",
    ),
)
BY_NAME = {lesson.name: lesson for lesson in LESSONS}
