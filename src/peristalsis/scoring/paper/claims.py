"""The paper's claims as data: statement, place, parts with their rules, and what each served for.

Rules and tolerances stand here and were fixed before the first scored run. What was known when they were written: the
baseline under `tight`, the switches and the trigger rules of docs/evidence, made while the model was built.
A claim holds if all its parts hold, in part if some do, not at all if none does; a part whose runs cannot be made, or
say nothing, is not testable.
"""

from __future__ import annotations

from ..claim import Claim, Part, Untestable
from ..rules import AllOf, AnyOf, Ends, Exceeds, InTime, Later, Not, Rule, Within
from .runs import PHASES, PRESSURES, SPECIAL, phase_name

ARREST, NEVER = ("arrested",), ("arrested", "in_transit")
REGULAR = 0.5
"""Bound of the irregularity index of regular motion: well below the 0.71 of a sine that stops once a cycle."""
DISRUPTED = 1.25
"""Factor on the norm's irregularity from which motion counts as disrupted."""
MIXED = 0.1
"""Mixing index from which content counts as mixed; below it, as not mixed."""
SMALL = (0.01, 0.5)
"""Librations that are visible and small: 0.1 mm to 5 mm, a twentieth of the segment [cm]."""
NO_PROPULSION = 0.5
"""Drift below which nothing is propelled [cm]: a twentieth of the segment."""
MOVES = 0.1
"""Travel from which a pellet has moved [cm]."""
NORMAL = 0.2
"""Share by which a normal transit may differ from the baseline's."""
SAME_TIME = 0.05
"""Share by which one transit may exceed another that it makes up for."""
STATED = 0.1
"""Tolerance on a number that the paper states."""


def _around(value: float) -> tuple[float, float]:
    return (1.0 - STATED) * value, (1.0 + STATED) * value


def _disturbed(run: str, norm: str) -> Rule:
    """Delayed, or disrupted: more irregular by a quarter, or with more stops."""
    irregular = Exceeds(run, "irregularity", norm, factor=DISRUPTED)
    return AnyOf((Later(run, norm), irregular, Exceeds(run, "stops", norm)))


def _special(run: str) -> Rule:
    """Stick-slip, partial or arrested transit: a stop on the way, or no arrival."""
    return AnyOf((Ends(run, NEVER), Within(run, "stops", 1)))


def _moves(run: str) -> Rule:
    return Within(run, "travel_cm", MOVES)


def _channel(number: int, channel: str, words: str, state: str) -> Claim:
    run, norm = f"fig5_{channel}_{state}", f"fig5_{channel}_norm"
    return Claim(
        number,
        f"{'An' if state == 'increased' else 'A'} {state} permeability of the {words} channels disrupts movement or "
        "delays it.",
        "section 4, Fig. 5",
        (Part("delays or disrupts", _disturbed(run, norm)),),
        remark="Permeability is the conductance, x 0.75 and x 1.25 (chosen); the whole curve is in the report.",
    )


_SHIFTED = tuple(phase_name(delay) for delay in PHASES if delay != 0.0)
_TOGETHER = phase_name(0.0)

CLAIMS: tuple[Claim, ...] = (
    Claim(
        1,
        "Under normal conditions the pellet passes the 10 cm segment in 2.4 s.",
        "section 4, Fig. 3 A",
        (
            Part("time: 2.4 s", Within("baseline", "transit_s", *_around(2.4))),
            Part("speed: 4.2 cm/s", Within("baseline", "mean_velocity_cm_s", *_around(4.2))),
        ),
        "calibrated",
        "The wave on the undeformed cable is calibrated to 4.2 cm/s, so this is no prediction.",
    ),
    Claim(
        2,
        "The normal motion is regular; irregularity grows with viscous friction.",
        "section 4, Fig. 3",
        (
            Part(
                "regular",
                AllOf((Within("baseline", "irregularity", high=REGULAR), Within("baseline", "stops", high=0))),
            ),
            Part("grows from 230 to 460", Exceeds("eta_x2", "irregularity", "baseline", factor=1.05)),
            Part("grows from 230 to 1200", Exceeds("fig3f", "irregularity", "baseline", factor=1.05)),
        ),
    ),
    Claim(
        3,
        "Seven pairs of viscous and dry friction order the transits of Fig. 3.",
        "section 4, Fig. 3",
        (
            Part("B before A", Later("fig3a", "fig3b")),
            Part("C before A", Later("fig3a", "fig3c")),
            Part("E after A or arrested", Later("fig3e", "fig3a")),
            Part("F after A or arrested", Later("fig3f", "fig3a")),
            Part("G after A or arrested", Later("fig3g", "fig3a")),
            Part("D before E", Later("fig3e", "fig3d")),
        ),
    ),
    Claim(
        4,
        "More viscous friction delays the pellet, less speeds it up.",
        "section 4",
        (
            Part("x 2 delays", Later("eta_x2", "baseline")),
            Part("x 4 delays", Later("eta_x4", "baseline")),
            Part("x 0.5 speeds", Later("baseline", "eta_x0.5")),
            Part("x 0.25 speeds", Later("baseline", "eta_x0.25")),
        ),
    ),
    Claim(
        5,
        "Less dry friction speeds the pellet up, more delays it.",
        "section 4, Fig. 3",
        (
            Part("2 before 20", Later("baseline", "fig3b")),
            Part("20 before 200", Later("dry_200", "baseline")),
            Part("200 before 450", Later("fig3e", "dry_200")),
        ),
    ),
    Claim(
        6,
        "High dry friction can be made up for by less viscous friction.",
        "section 4, Fig. 3 D",
        (
            Part("90/450 before 230/450", Later("fig3e", "fig3d")),
            Part("90/450 as fast as 230/20", InTime("fig3d", "baseline", SAME_TIME)),
        ),
    ),
    Claim(
        7,
        "Dry friction of 565 to 2000 gives a special pattern: stick-slip, partial or arrested transit.",
        "section 4",
        (
            *(Part(f"special at {force}", _special("fig3g" if force == 800 else f"dry_{force}")) for force in SPECIAL),
            Part("not special at 20 and 450", AllOf((Not(_special("baseline")), Not(_special("fig3e"))))),
        ),
        "chosen",
        "Served to choose the units of friction.",
    ),
    Claim(
        8,
        "Viscous friction matters more than dry friction.",
        "sections 4 and 5",
        (
            Part(
                "over equal percentages",
                Exceeds("equal_percentages", "viscous_low", "equal_percentages", other_metric="dry_high"),
            ),
            Part(
                "over the paper's ranges",
                Exceeds("paper_ranges", "viscous_low", "paper_ranges", other_metric="dry_high"),
            ),
        ),
        remark=(
            "Total share of the variance of the mean velocity in a 5 x 5 factorial; the bands are those of leaving out "
            "one level at a time, and the lower end for viscous friction must exceed the upper end for dry friction."
        ),
    ),
    Claim(
        9,
        "Raising or lowering the lumen pressure delays the pellet.",
        "section 4, Fig. 4",
        (
            Part("0.15 kPa delays", Later("fig4b", "fig4a")),
            Part("0.075 kPa delays", Later("fig4c", "fig4a")),
            Part("20 kPa delays", Later("fig4d", "fig4a")),
        ),
    ),
    Claim(
        10,
        "Only a pressure above 15 kPa stops the pellet.",
        "section 4, Fig. 4 D",
        (
            *(Part(f"passes at {p} kPa", Ends(f"pressure_{p}", ("expelled",))) for p in PRESSURES),
            Part("arrested at 20 kPa", Ends("fig4d", ARREST)),
            Part("threshold 15 to 20 kPa", Within("pressure_of_arrest", "threshold", 0.9 * 15.0, 20.0)),
        ),
        "chosen",
        "Served to choose c10 of the reading tight, and the units of friction.",
    ),
    _channel(11, "slow_calcium", "slow calcium", "decreased"),
    _channel(12, "slow_calcium", "slow calcium", "increased"),
    _channel(13, "fast_calcium", "fast calcium", "decreased"),
    _channel(14, "fast_calcium", "fast calcium", "increased"),
    _channel(15, "calcium_potassium", "calcium-activated potassium", "decreased"),
    _channel(16, "calcium_potassium", "calcium-activated potassium", "increased"),
    Claim(
        17,
        "Without stimulation the transit is longer; without it, viscous friction 100 is faster than 230.",
        "section 4, Fig. 6",
        (
            Part("longer without", Later("fig6b", "fig6a")),
            Part("100 faster than 230", Later("fig6b", "fig6d")),
        ),
        remark="No stimulation: pacemaker off, stretch receptors on. A and C carry one caption, a misprint.",
    ),
    Claim(
        18,
        "Stretch receptors alone move the pellet, irregularly and late.",
        "section 4, Fig. 6",
        (
            Part("moves", _moves("fig6_receptors_alone")),
            Part("late", Later("fig6_receptors_alone", "baseline")),
            Part("irregular", Within("fig6_receptors_alone", "irregularity", REGULAR)),
        ),
    ),
    Claim(
        19,
        "With neither pacemaker nor receptors, elastic forces move the pellet slowly and with disruption.",
        "section 4, Fig. 6",
        (
            Part("moves", _moves("fig6_neither")),
            Part("slowly", AllOf((_moves("fig6_neither"), Later("fig6_neither", "fig6_receptors_alone")))),
            Part("with disruption", Within("fig6_neither", "irregularity", REGULAR)),
        ),
    ),
    Claim(
        20,
        "Less viscous friction makes up for missing stimulation.",
        "section 4, Fig. 6 D",
        (
            Part("receptors alone at 100 as fast as the norm", InTime("fig6d", "baseline", SAME_TIME)),
            Part(
                "neither: 100 faster than 230",
                AllOf((_moves("fig6_neither_lubricated"), Later("fig6_neither", "fig6_neither_lubricated"))),
            ),
        ),
    ),
    Claim(
        21,
        "A narrower tube is faster, a wider one slower or it stops.",
        "section 4, Fig. 7",
        (
            Part("r0 = 0.6 faster", Later("fig7a", "fig7c")),
            Part("r0 = 0.9 slower or stopped", Later("fig7b", "fig7a")),
        ),
    ),
    Claim(
        22,
        "A larger pellet is faster.",
        "section 4",
        (
            Part("R x 1.05 faster", Later("baseline", "pellet_x1.05")),
            Part("R x 1.1 faster", Later("baseline", "pellet_x1.1")),
        ),
    ),
    Claim(
        23,
        "Below 105 % of the tube the pellet stops, because the receptors fall silent.",
        "section 4, Fig. 7",
        (
            Part("stops at 100 and 102 %", AllOf((Ends("ratio_1", ARREST), Ends("ratio_1.02", ARREST)))),
            Part(
                "passes at 108 and 113 %",
                AllOf((Ends("ratio_1.08", ("expelled",)), Ends("ratio_1.13", ("expelled",)))),
            ),
            Part(
                "threshold 103 to 107 %, of r0 or of the inflated tube",
                AnyOf(
                    (
                        Within("ratio_of_arrest", "threshold", 1.03, 1.07),
                        Within("ratio_of_arrest", "threshold_inflated", 1.03, 1.07),
                    )
                ),
            ),
            Part(
                "because of the receptors: forced on, it passes where it stopped",
                AnyOf(
                    tuple(
                        AllOf((Ends(f"ratio_{ratio}", ARREST), Ends(f"ratio_{ratio}_forced", ("expelled",))))
                        for ratio in ("1", "1.02")
                    )
                ),
            ),
        ),
        "chosen",
        "Served to choose the ratio 1.13 of the reading tight.",
    ),
    Claim(
        24,
        "Pendular movements alone give normal transit without mixing.",
        "abstract",
        (
            Part("normal transit", InTime("pendular", "baseline", NORMAL, NORMAL)),
            Part("without mixing", Within("pendular", "mixing", high=MIXED)),
        ),
    ),
    Claim(
        25,
        "Segmentation gives small librations without propulsion.",
        "abstract",
        (
            Part("small librations", Within("segmentation", "libration_cm", *SMALL)),
            Part("no propulsion", Within("segmentation", "drift_cm", high=NO_PROPULSION)),
        ),
    ),
    Claim(
        26,
        "Peristalsis propels and mixes, and only peristalsis does both.",
        "abstract",
        (
            Part("propels", Ends("baseline", ("expelled",))),
            Part("mixes", Within("baseline", "mixing", MIXED)),
            Part(
                "pendular movements do not do both",
                Not(AllOf((Ends("pendular", ("expelled",)), Within("pendular", "mixing", MIXED)))),
            ),
            Part(
                "segmentation does not do both",
                Not(AllOf((Ends("segmentation", ("expelled",)), Within("segmentation", "mixing", MIXED)))),
            ),
        ),
    ),
    Claim(
        27,
        "Mixing and movement need the two layers to contract in turn; together, they expel if they are strong.",
        "sections 4 and 5",
        (
            Part(
                "movement: together is later than every shift by 10 %",
                AllOf(tuple(Later(_TOGETHER, shifted, by=0.1) for shifted in _SHIFTED)),
            ),
            Part(
                "mixing: together mixes less than some shift by a quarter",
                AnyOf(tuple(Exceeds(shifted, "mixing", _TOGETHER, factor=1.25) for shifted in _SHIFTED)),
            ),
            Part("strong contraction together expels", Ends(f"{_TOGETHER}_strong", ("expelled",))),
            Part("weak contraction together does not", Ends(f"{_TOGETHER}_weak", NEVER)),
        ),
        remark="Rule pacemaker, stretch receptors off, circular start -0.5 to +1 s after the longitudinal one.",
    ),
    Claim(
        28,
        "The active force of the circular layer rises throughout propulsion.",
        "section 4",
        (
            Part("rises", Within("baseline", "circular_force_rise", 1.1)),
            Part("throughout", Within("baseline", "circular_force_setback", high=0.05)),
        ),
    ),
    Claim(
        29,
        "Both ends rest, and the anal end stays passive throughout.",
        "section 3",
        (
            Part("both ends rest", Within("baseline", "end_displacement_cm", high=1e-3)),
            Part("the anal end stays passive", Within("baseline", "anal_active_share", high=0.05)),
        ),
    ),
    Claim(
        30,
        "Lubricants shorten transit, with a bulk former more; calcium agonists and antagonists worsen it.",
        "sections 4 and 5",
        (
            Part("an osmotic lubricant shortens", Later("baseline", "osmotic")),
            Part("mineral oil shortens", Later("baseline", "mineral_oil")),
            Part("oil with a bulk former shortens more than oil", Later("mineral_oil", "oil_and_bulk")),
            Part(
                "agonists worsen",
                AllOf(
                    tuple(
                        _disturbed(f"fig5_{channel}_increased", f"fig5_{channel}_norm")
                        for channel in ("slow_calcium", "fast_calcium")
                    )
                ),
            ),
            Part(
                "antagonists worsen",
                AllOf(
                    tuple(
                        _disturbed(f"fig5_{channel}_decreased", f"fig5_{channel}_norm")
                        for channel in ("slow_calcium", "fast_calcium")
                    )
                ),
            ),
        ),
        remark="Lubricant: half the viscous friction; oil: half the dry friction too; bulk former: R x 1.05 (chosen).",
    ),
)

NOT_TESTABLE = (
    Untestable(
        "The simulated movements resemble those recorded experimentally (section 4).",
        "section 4",
        "the paper shows no record and names no measure of likeness",
    ),
)
"""Statements without a number in the list, and why they cannot be tested."""
