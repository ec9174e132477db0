"""What a solve of the wall can end with, and the scales by which its residuals are measured."""

from __future__ import annotations

from typing import NamedTuple

TENSION_SCALE = 10.0
"""Tension against which force residuals are measured [mN/cm], about p0 r0."""
GAP_SCALE = 1.0e5
"""Weight of an open gap in the merit of the line search [mN/cm^3]: heavy, or a nearly slack wall refuses contact."""
ROUNDOFF = 16.0 * 2.0**-52

CONVERGED, NOT_CONVERGED, SINGULAR, OUT_OF_RANGE, ROUNDED = range(5)
"""ROUNDED: the iteration stands still at forces that are no more than rounding, Eq. (58), above the tolerance."""
REASONS = (
    "converged",
    "Newton iteration limit reached",
    "singular tangent (static instability of the wall)",
    "stretch out of range",
    "converged to the rounding of the forces",
)


class Verdict(NamedTuple):
    """The code of REASONS, iterations over all unknowns, assemblies of the whole wall, and the largest residual left.

    residual: over TENSION_SCALE; it says something where the code is CONVERGED or ROUNDED.
    """

    code: int
    iterations: int
    assemblies: int
    residual: float
