"""Activation of muscle by attached cross-bridges in the four states of Hai and Murphy, Eqs. (80)-(82).

Source: C. M. Hai, R. A. Murphy, Am. J. Physiol. 254 (1988) C99-C106. Myosin is M, phosphorylated Mp, attached and
phosphorylated AMp, attached and dephosphorylated AM, the latch; the shares sum to 1. Kinase works at a rate that
follows calcium (k1 = k6), phosphatase at a constant one (k2 = k5). Rates are those of the source, for arteries of the
pig; the factor on the kinetics of the cells is not on them. How the kinase follows calcium is Hill's curve here: the
source sets its rate by hand.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...declared import number
from ...numerics.compiled import inlined
from ..hill import hill

KIND = "activation"
NAME = "hai_murphy"
TITLE = "attached cross-bridges, phosphorylated or latched (Hai & Murphy 1988)"
READS_CALCIUM = True
STATES = (("m", 0.0, 1.0), ("mp", 0.0, 1.0), ("amp", 0.0, 1.0), ("am", 0.0, 1.0))
SOURCE = "Hai & Murphy 1988, Am. J. Physiol. 254:C99"

PARAMETERS = (
    number("fastest", 0.55, "1/s", "k1 = k6 at full calcium, phosphorylation: an example, about what the source takes "
           "for the first seconds of a contraction", tag="chosen", lowest=0.0, highest=1e4),
    number("half", 0.4, "uM", "calcium of half the fastest phosphorylation: an example", tag="chosen", lowest=1e-6,
           highest=1e6),
    number("exponent", 4.0, "1", "steepness of Hill's curve: an example, one for each calcium that calmodulin binds",
           tag="chosen", lowest=0.1, highest=20.0),
    number("dephosphorylation", 0.5, "1/s", "k2 = k5, by phosphatase", tag="sourced", source=SOURCE, lowest=0.0,
           highest=1e4),
    number("attachment", 0.4, "1/s", "k3, of phosphorylated bridges", tag="sourced", source=SOURCE, lowest=0.0,
           highest=1e4),
    number("detachment", 0.1, "1/s", "k4, of phosphorylated bridges", tag="sourced", source=SOURCE, lowest=0.0,
           highest=1e4),
    number("latch_detachment", 0.01, "1/s", "k7, of latched bridges", tag="sourced", source=SOURCE, lowest=1e-9,
           highest=1e4),
    number("full", 40.0, "mV", "drive with every bridge attached, as depolarisation beyond the threshold: an example",
           tag="chosen", lowest=0.0, highest=1e4),
    number("calcium_unit", 1.0, "uM", "what a calcium of 1 stands for in a cell that gives it without a unit: an "
           "example", tag="chosen", lowest=1e-6, highest=1e6),
)  # fmt: skip


class ActivationConstants(NamedTuple):
    """The values of PARAMETERS, in their order."""

    fastest: float
    half: float
    exponent: float
    dephosphorylation: float
    attachment: float
    detachment: float
    latch_detachment: float
    full: float
    calcium_unit: float


M, MP, AMP, AM = range(4)
LONGEST = 1.0
"""Largest product of time and rate for which the series (82) is summed at once; its terms fall from the first on."""
TERMS = 20
"""Terms of the series: the first that is left out is below 1e-18."""


@inlined
def drive(potential: float, calcium: float, states: np.ndarray, k: int, c: ActivationConstants) -> float:
    """Drive [mV] of a cell by its attached bridges, Eq. (81)."""
    return c.full * (states[AMP, k] + states[AM, k])


@inlined
def steady(calcium: float, states: np.ndarray, k: int, c: ActivationConstants) -> None:
    """Put the shares of a cell where they stay at a calcium [uM]: the null vector of Eq. (80), a sum of products."""
    kinase = c.fastest * hill(calcium, c.half, c.exponent)
    phosphatase, on, off, latch = c.dephosphorylation, c.attachment, c.detachment, c.latch_detachment
    # Weights of the four states by the matrix-tree theorem: sums of products of rates that lead to each.
    m = phosphatase * (off * (kinase + latch) + phosphatase * latch) + latch * phosphatase * on
    mp = kinase * (off * (kinase + latch) + phosphatase * latch)
    amp = kinase * on * (kinase + latch)
    am = kinase * on * phosphatase
    total = m + mp + amp + am
    if total > 0.0:
        states[M, k], states[MP, k], states[AMP, k], states[AM, k] = m / total, mp / total, amp / total, am / total
    else:  # neither phosphatase nor kinase: where the bridges are they stay
        states[M, k], states[MP, k], states[AMP, k], states[AM, k] = 1.0, 0.0, 0.0, 0.0


@inlined
def advance(calcium: float, states: np.ndarray, k: int, dt: float, c: ActivationConstants) -> None:
    """Advance the shares of a cell by dt [s] at a calcium [uM], exactly, Eqs. (80), (82).

    Every term of the series is positive, so shares stay shares at any step; weights that sum to 1 keep their sum.
    """
    kinase = c.fastest * hill(calcium, c.half, c.exponent)
    phosphatase, on, off, latch = c.dephosphorylation, c.attachment, c.detachment, c.latch_detachment
    fastest = max(max(kinase, phosphatase + on), max(phosphatase + off, kinase + latch))  # out of M, Mp, AMp, AM
    parts = max(1, math.ceil(dt * fastest / LONGEST))
    span = dt / parts  # as time times rate below
    a, b, p, q = states[M, k], states[MP, k], states[AMP, k], states[AM, k]
    for _ in range(parts):
        sum_a, sum_b, sum_p, sum_q = a, b, p, q
        weight, weights = 1.0, 1.0
        for n in range(1, TERMS):
            if fastest > 0.0:
                scale = 1.0 / fastest
                to_b, to_a = kinase * scale * a, phosphatase * scale * b
                to_p, from_p = on * scale * b, off * scale * p
                to_q, from_q = phosphatase * scale * p, kinase * scale * q
                loose = latch * scale * q
                a, b, p, q = (
                    (1.0 - kinase * scale) * a + to_a + loose,
                    (1.0 - (phosphatase + on) * scale) * b + to_b + from_p,
                    (1.0 - (off + phosphatase) * scale) * p + to_p + from_q,
                    (1.0 - (kinase + latch) * scale) * q + to_q,
                )
            weight *= span * fastest / n
            weights += weight
            sum_a += weight * a
            sum_b += weight * b
            sum_p += weight * p
            sum_q += weight * q
        a, b, p, q = sum_a / weights, sum_b / weights, sum_p / weights, sum_q / weights
    states[M, k], states[MP, k], states[AMP, k], states[AM, k] = a, b, p, q


def largest_drive(highest: float, c: ActivationConstants) -> float:
    """Largest drive [mV], at any potential."""
    return c.full
