"""What is measured of the run of a pellet, once: name, unit, definition. Rules of claims know no other numbers.

A source that needs further ones brings a measure and definitions of its own (`source.Source`).
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Metric(NamedTuple):
    """A number measured of one run."""

    name: str
    unit: str
    definition: str


VELOCITY_BIN = 0.05
"""Length of the intervals over which velocity is averaged before its irregularity is taken [s]."""
WINDOW = (0.05, 0.95)
"""Shares of its travel between which a pellet is on its way."""
STOP_TIME, STOP_SPEED = 0.1, 0.01
"""A stop is at least 0.1 s below 0.01 cm/s (0.1 mm/s, the speed of arrest)."""
REVERSAL = 0.01
"""A reversal goes back by at least 0.1 mm [cm]."""
LEAST_SWING = 0.001
"""Turning points of a libration are at least 10 um apart [cm]."""
LEAST_TRAVEL = 0.1
"""A pellet that went less than 1 mm [cm] has no irregularity."""
MIXING_CELLS = 20
"""Equal parts of the content, along the tube, in which tracers are counted."""
TRACERS = 4000
ANAL_ZONE = 0.3
"""Stretch of the anal end that must stay passive [cm]: as wide as the pacemaker's at the other end."""

METRICS: Mapping[str, Metric] = MappingProxyType(
    {
        metric.name: metric
        for metric in (
            Metric("transit_s", "s", "time at which the leading pole reaches the anal end; undefined if it does not"),
            Metric("travel_cm", "cm", "displacement of the centre until then, or until the end of the run"),
            Metric("mean_velocity_cm_s", "cm/s", "travel over transit, or over the run where there is none"),
            Metric(
                "irregularity",
                "1",
                "standard deviation over mean of the velocity averaged over 50 ms, while the pellet goes from 5 to "
                "95 % of its travel; undefined below 1 mm of travel. 0 is uniform motion, 0.71 a sine that just stops "
                "once a cycle, 1 equal times of going and standing",
            ),
            Metric("stops", "1", "times of 0.1 s or more below 0.1 mm/s while it goes from 5 to 95 % of its travel"),
            Metric("reversals", "1", "times the pellet goes back by 0.1 mm or more"),
            Metric(
                "libration_cm",
                "cm",
                "half of the largest swing that is also undone: turning points at least 10 um apart, the smaller of "
                "two neighbouring swings; a sine of amplitude a gives a, a drift 0",
            ),
            Metric("drift_cm", "cm", "distance between the first and the last position of the centre"),
            Metric(
                "mixing",
                "1",
                "Lacey's index of the oral and the anal half of the content, at the end of the run: tracers counted in "
                "20 parts of equal content, 0 while the halves are in order, 1 when they are mixed at random",
            ),
            Metric(
                "circular_force_rise",
                "1",
                "active circular force of the whole wall when the pellet has gone 95 % of its travel, over that at 5 %",
            ),
            Metric(
                "circular_force_setback",
                "1",
                "largest fall of that force below what it had reached before, between 5 and 95 %, over its maximum",
            ),
            Metric("end_displacement_cm", "cm", "largest displacement of the first and the last wall node"),
            Metric(
                "anal_active_share",
                "1",
                "largest active tension of either layer in the last 0.3 cm, over the largest anywhere, until the end",
            ),
            Metric("inflated_ratio", "1", "radius of the pellet over that of the pellet-free tube at p0, mid-segment"),
        )
    }
)
