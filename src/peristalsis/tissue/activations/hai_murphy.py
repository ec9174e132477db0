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
"""Largest product of time and rate for which the series (82) is summed at once; its weights fall from the first on."""
NEGLIGIBLE = 1e-17
"""Weight from which on the terms of the series are left out; they fall faster than any power of it."""


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

    Every term of the series is positive, so shares stay shares at any step, and their sum is 1.
    """
    kinase = c.fastest * hill(calcium, c.half, c.exponent)
    phosphatase, on, off, latch = c.dephosphorylation, c.attachment, c.detachment, c.latch_detachment
    fastest = max(max(kinase, phosphatase + on), max(phosphatase + off, kinase + latch))  # out of M, Mp, AMp, AM
    parts = max(1, math.ceil(dt * fastest / LONGEST))
    scale = 1.0 / fastest if fastest > 0.0 else 0.0
    leave_a, leave_b = kinase * scale, (phosphatase + on) * scale
    leave_p, leave_q = (phosphatase + off) * scale, (kinase + latch) * scale
    toward = dt / parts * fastest
    a, b, p, q = states[M, k], states[MP, k], states[AMP, k], states[AM, k]
    for _ in range(parts):
        sum_a, sum_b, sum_p, sum_q = a, b, p, q
        weight, n = toward, 1
        while weight > NEGLIGIBLE:
            a, b, p, q = (
                (1.0 - leave_a) * a + scale * (phosphatase * b + latch * q),
                (1.0 - leave_b) * b + scale * (kinase * a + off * p),
                (1.0 - leave_p) * p + scale * (on * b + kinase * q),
                (1.0 - leave_q) * q + scale * phosphatase * p,
            )
            sum_a += weight * a
            sum_b += weight * b
            sum_p += weight * p
            sum_q += weight * q
            n += 1
            weight *= toward / n
        total = sum_a + sum_b + sum_p + sum_q  # exp(toward), and rounding, which would add up over many steps
        a, b, p, q = sum_a / total, sum_b / total, sum_p / total, sum_q / total
    states[M, k], states[MP, k], states[AMP, k], states[AM, k] = a, b, p, q


def largest_drive(highest: float, c: ActivationConstants) -> float:
    """Largest drive [mV], at any potential."""
    return c.full
