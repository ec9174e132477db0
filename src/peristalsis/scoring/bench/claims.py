"""What laboratories measured of the isolated colon, as claims with rules.

Rules and tolerances stand here and were fixed before the first scored run. What was known when they were written:
single runs that served to choose the reflex, the friction and the speed of the cell (docs/bench.md tells them); B1 to
B4 are marked accordingly. The publications were read in their abstracts.
"""

from __future__ import annotations

import math
from itertools import pairwise

from ..claim import Claim, Part, Untestable
from ..rules import AllOf, Exceeds, Not, Rule, Within
from .rules import HalvesTogether
from .runs import ABOVE, BELOW, BLOCKS, CONTROL, HELD, LOADS, block_run, diameter_run, load_run

SPEED, ISOMETRIC_FORCE = "middle_speed_mm_s", "isometric_force_mN"
NEAR = 0.15
"""Share by which a speed may differ from the control's and be as it was."""
STALLED = 0.1
"""Speed below which a pellet is stalled [mm/s]."""
RISES = 1.02
"""Factor from which one speed is above another: the grids leave 1 % on each."""
STOPPED = 0.02
"""Share of the control's speed below which nothing moves."""


def _at_least(run: str, metric: str, than: str, share: float) -> Rule:
    """At least a share of what another run has; `Exceeds` by itself asks for more than all of it."""
    return Exceeds(run, metric, than, share, -math.inf)


def _near(run: str) -> Rule:
    """Within 15 % of the control's speed."""
    not_faster = Not(Exceeds(run, SPEED, CONTROL, factor=1.0 + NEAR))
    return AllOf((_at_least(run, SPEED, CONTROL, 1.0 - NEAR), not_faster))


def _falling(runs: tuple[str, ...]) -> Rule:
    return AllOf(tuple(Exceeds(lighter, SPEED, heavier) for lighter, heavier in pairwise(runs)))


_NARROW = tuple(diameter_run(ratio) for ratio in BELOW)

CLAIMS: tuple[Claim, ...] = (
    Claim(
        1,
        "A pellet passes the middle of the segment at 1 to 3 mm/s.",
        "doi 10.3791/2435; PMC4021129 (abstracts)",
        (Part("1 to 3 mm/s", Within(CONTROL, SPEED, 1.0, 3.0)),),
        "calibrated",
    ),
    Claim(
        2,
        "Speed rises with the pellet's diameter up to that of the natural pellet, and stays within 15 % above.",
        "Costa 2015, doi 10.1111/nmo.12646 (abstract)",
        (
            Part(
                "rises",
                AllOf(
                    tuple(
                        Exceeds(wider, SPEED, narrower, RISES)
                        for narrower, wider in zip(_NARROW, (*_NARROW[1:], CONTROL), strict=True)
                    )
                ),
            ),
            Part("level above", AllOf(tuple(_near(diameter_run(ratio)) for ratio in ABOVE))),
        ),
        "chosen",
        "Reflex and friction were chosen so that it may.",
    ),
    Claim(
        3,
        "Speed falls with a resistive load; the pellet stalls at 10 to 100 mN.",
        "Costa 2015, doi 10.1111/nmo.12646; Gut 1994;35:625 (abstracts)",
        (
            Part("falls", _falling((CONTROL, *(load_run(weight) for weight in LOADS[:4])))),
            Part("moves against 10 mN", Within(load_run(10), SPEED, STALLED)),
            Part("stalls against 100 mN", Within(load_run(100), SPEED, high=STALLED)),
        ),
        "chosen",
        "The speed of the cell was chosen with the force on a held pellet in view.",
    ),
    Claim(
        4,
        "Hexamethonium weakens the reflex: the force falls by a fifth or more, the speed stays within 15 %.",
        "Nicholas & Spencer 2010 (abstract); another group finds a block at the same 100 uM (pubmed 8944700)",
        (
            Part("force falls", Not(_at_least("held_hexamethonium", ISOMETRIC_FORCE, HELD, 0.8))),
            Part("speed stays", _near("hexamethonium")),
        ),
        "chosen",
        "The reflex keeps half of its strength, a share that no source gives.",
    ),
    Claim(
        5,
        "Tetrodotoxin stops the pellet.",
        "Nicholas & Spencer 2010; Costa 2015 (abstracts)",
        (Part("below 2 %", Not(_at_least("tetrodotoxin", SPEED, CONTROL, STOPPED))),),
    ),
    Claim(
        6,
        "The longitudinal layer contracts first and is not needed: without its force the speed is at least half.",
        "Frigo & Lecchini 1970, doi 10.1111/j.1476-5381.1970.tb12897.x (abstract)",
        (Part("half the speed", _at_least("no_longitudinal_force", SPEED, CONTROL, 0.5)),),
    ),
    Claim(
        7,
        "On every pass the wall ahead is relaxed and dilated before the ring behind contracts.",
        "Costa & Furness 1976, doi 10.1007/BF00692784; PMC3997013 (abstracts)",
        tuple(
            Part(f"{words} ({run})", Within(run, metric, low=0.99))
            for run in (CONTROL, diameter_run(1.1), load_run(20))
            for metric, words in (("relaxed_first", "relaxed first"), ("dilated_first", "dilated first"))
        ),
    ),
    Claim(
        8,
        "A blocker of L-type channels halves the speed at 0.3 to 3 times the concentration that halves the muscle's "
        "force.",
        "Lecchini 1991, PMC1917923 (abstract)",
        (
            Part(
                "both halves",
                HalvesTogether(
                    BLOCKS,
                    (CONTROL, SPEED, tuple(block_run(one) for one in BLOCKS)),
                    (HELD, ISOMETRIC_FORCE, tuple(block_run(one, held=True) for one in BLOCKS)),
                    0.3,
                    3.0,
                ),
            ),
        ),
    ),
    Claim(
        10,
        "The pellet is pressed on with 0.5 to 5 kPa and pushed with at most 100 mN.",
        "ranges of several gut segments: Gut 1994;35:625; doi 10.1007/s11701-012-0346-3 (abstracts)",
        (
            Part("contact pressure", Within(CONTROL, "contact_kPa", 0.5, 5.0)),
            Part("axial force", Within(CONTROL, "peak_force_mN", high=100.0)),
        ),
        "plausibility",
    ),
)

NOT_TESTABLE: tuple[Untestable, ...] = (
    Untestable(
        "Oil does not slow a bolus, cellulose does.",
        "guinea-pig ileum (abstract)",
        "a lubricant is a range of factors on friction, which no source measures on the bench",
    ),
)
