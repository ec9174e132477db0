"""Hodgkin and Huxley's squid axon, as a description of a cell from which `general` makes kernels.

Source: A. L. Hodgkin, A. F. Huxley, J. Physiol. 117 (1952) 500-544, with the resting potential at -65 mV. It is the
example that other descriptions follow and the one that tests know by heart; no muscle of the gut is like it.

A description has the names below and nothing else is asked of it. Functions get whole arrays and the index of a node,
so that they are compiled into the loops that call them. Units: mV, ms, mS/cm^2, uA/cm^2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...declared import number
from ...numerics.compiled import compiled

KIND = "cell"
NAME = "hodgkin_huxley"
TITLE = "squid axon of Hodgkin and Huxley (1952)"

STATES = (("m", 0.0, 1.0), ("h", 0.0, 1.0), ("n", 0.0, 1.0))
"""Name and bounds of every state besides the potential: first the gates, whose rates depend on the potential alone."""
GATES = 3
"""How many of the states are gates."""
CHANNELS = ("sodium", "potassium", "leak")
"""Names of the maximal conductances, which regions and drugs scale."""
INSTANT = 0
"""How many functions of the potential alone the current contains, besides the gates."""
LOWEST, HIGHEST = -150.0, 150.0
"""Potentials [mV] beyond which the cell is not defined."""


class CellConstants(NamedTuple):
    """Reversal potentials [mV], capacitance [uF/cm^2], rate factor."""

    sodium_reversal: float
    potassium_reversal: float
    leak_reversal: float
    capacitance: float
    kinetics_rate: float


PARAMETERS = (
    number("sodium_reversal", 50.0, "mV", "reversal potential of sodium", tag="sourced",
           source="J. Physiol. 117 (1952) 520", lowest=-200.0, highest=200.0),
    number("potassium_reversal", -77.0, "mV", "reversal potential of potassium", tag="sourced",
           source="J. Physiol. 117 (1952) 520", lowest=-200.0, highest=200.0),
    number("leak_reversal", -54.387, "mV", "reversal potential of the leak", tag="sourced",
           source="J. Physiol. 117 (1952) 520", lowest=-200.0, highest=200.0),
    number("capacitance", 1.0, "uF/cm^2", "capacitance of the membrane", tag="sourced",
           source="J. Physiol. 117 (1952) 520", lowest=1e-3, highest=1e3),
    number("kinetics_rate", 1.0, "1", "factor on every rate of the cell", lowest=1e-3, highest=1e3),
)  # fmt: skip
"""What the constants are unless they are set; in the order of `CellConstants`."""
SHIPPED = CellConstants(*(one.value for one in PARAMETERS))
CONDUCTANCES = (
    number("sodium", 120.0, "mS/cm^2", "conductance of the sodium channel", tag="sourced",
           source="J. Physiol. 117 (1952) 520", lowest=0.0, highest=1e4),
    number("potassium", 36.0, "mS/cm^2", "conductance of the potassium channel", tag="sourced",
           source="J. Physiol. 117 (1952) 520", lowest=0.0, highest=1e4),
    number("leak", 0.3, "mS/cm^2", "conductance of the leak", tag="sourced",
           source="J. Physiol. 117 (1952) 520", lowest=0.0, highest=1e4),
)  # fmt: skip
"""Conductances of CHANNELS, in their order."""
INHIBITION = "potassium_reversal"
"""The constant towards which inhibiting nerves pull the potential."""


@compiled
def _ratio(x: float) -> float:
    """x / (1 - exp(-x)), finite at 0."""
    if abs(x) < 1e-5:
        return 1.0 + 0.5 * x
    return x / -math.expm1(-x)


@compiled
def gates(v: float, constants: CellConstants, row: np.ndarray) -> None:
    """Steady value and rate [1/ms] of every gate in turn, at the potential v."""
    rise, fall = _ratio(0.1 * (v + 40.0)), 4.0 * math.exp(-(v + 65.0) / 18.0)
    row[0], row[1] = rise / (rise + fall), rise + fall
    rise, fall = 0.07 * math.exp(-(v + 65.0) / 20.0), 1.0 / (1.0 + math.exp(-0.1 * (v + 35.0)))
    row[2], row[3] = rise / (rise + fall), rise + fall
    rise, fall = 0.1 * _ratio(0.1 * (v + 55.0)), 0.125 * math.exp(-(v + 65.0) / 80.0)
    row[4], row[5] = rise / (rise + fall), rise + fall


@compiled
def instant(v: float, constants: CellConstants, row: np.ndarray) -> None:
    """The functions of the potential alone: none."""


@compiled
def others(
    v: float, states: np.ndarray, channels: np.ndarray, node: int, constants: CellConstants, row: np.ndarray
) -> None:
    """Source a and decay b [1/ms] of every state that is no gate, in turn, with s' = a - b s: none."""


@compiled
def current(
    v: float, states: np.ndarray, channels: np.ndarray, instants: np.ndarray, node: int, constants: CellConstants
) -> float:
    """Ionic current [uA/cm^2], outward positive, at the potential v."""
    m, h, n = states[0, node], states[1, node], states[2, node]
    return (
        channels[0, node] * m * m * m * h * (v - constants.sodium_reversal)
        + channels[1, node] * n * n * n * n * (v - constants.potassium_reversal)
        + channels[2, node] * (v - constants.leak_reversal)
    )
