"""A pellet under a given axial force, Eq. (13), solved by hand.

Sources: elementary integration; the contact edge after W. H. Yang and W. W. Feng, J. Appl. Mech. 37 (1970), who
join the free membrane and the part on the sphere with the two first integrals of a uniform membrane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from peristalsis.wall.passive import PassiveConstants

from .wall import energy, gradient


@dataclass(frozen=True)
class Ramp:
    """F = rate * t: starts at t* = F_d/rate, then Z = rate (t - t*)^2 / (2 eta)."""

    rate: float
    viscous: float
    dry: float

    @property
    def start(self) -> float:
        """When the pellet leaves."""
        return self.dry / self.rate

    def force(self, t: float) -> float:
        """The drive [mN]."""
        return self.rate * t

    def travel(self, t: float) -> float:
        """Travel at t [cm]."""
        return self.rate * max(t - self.start, 0.0) ** 2 / (2.0 * self.viscous)


@dataclass(frozen=True)
class Oscillation:
    """F = amplitude sin(omega t) + bias."""

    amplitude: float
    omega: float
    viscous: float
    dry: float
    bias: float = 0.0

    def force(self, t: float) -> float:
        """The drive [mN]."""
        return self.amplitude * float(np.sin(self.omega * t)) + self.bias

    def travel_of_half_period(self) -> float:
        """Travel in the first half period without bias [cm]."""
        phase = np.arcsin(self.dry / self.amplitude)
        slip = 2.0 * np.cos(phase) - (np.pi - 2.0 * phase) * np.sin(phase)
        return float(self.amplitude / (self.viscous * self.omega) * slip)


@dataclass(frozen=True)
class FrictionlessContact:
    """Uniform passive membrane lying on a sphere, consistent convention; F and K = W - lambda_l W_l are given."""

    radius: float
    sphere: float
    passive: PassiveConstants
    force: float
    constant: float
    pressure: float

    def stretch(self, angle: float) -> float:
        """Longitudinal stretch on the sphere at an angle from the axis: W - lambda_l W_l keeps its value."""
        hoop = self.sphere * np.sin(angle) / self.radius

        def excess(s: float) -> float:
            return float(energy(s, hoop, self.passive) - s * gradient(s, hoop, self.passive)[0] - self.constant)

        scan = np.linspace(0.8, 1.6, 161)
        values = np.array([excess(s) for s in scan])
        k = int(np.flatnonzero(values[:-1] * values[1:] < 0.0)[-1])
        return float(brentq(excess, scan[k], scan[k + 1], xtol=1e-14))

    def half_length(self) -> float:
        """Axial distance of the contact edge from the centre of the sphere [cm]."""

        def excess(angle: float) -> float:
            hoop = self.sphere * np.sin(angle) / self.radius
            tension = gradient(self.stretch(angle), hoop, self.passive)[0]
            pull = 2.0 * np.pi * self.radius * tension * np.sin(angle)
            return float(pull - self.pressure * np.pi * (self.sphere * np.sin(angle)) ** 2 - self.force)

        angles = np.linspace(0.5 * np.pi - 1e-3, 0.3 * np.pi, 200)
        values = np.array([excess(a) for a in angles])
        k = int(np.flatnonzero(values[:-1] * values[1:] < 0.0)[0])
        return float(self.sphere * np.cos(brentq(excess, angles[k + 1], angles[k], xtol=1e-14)))
