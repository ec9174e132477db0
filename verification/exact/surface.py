"""Sheets on the whole surface with known answers; lengths in cm, times in ms."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from peristalsis.numerics.stabilised import coefficients, stages_for
from peristalsis.tissue.bidomain import Bidomain
from peristalsis.tissue.surface import Conductivities, Monodomain, SurfaceOperator, SurfaceSizes
from verification.exact.cable import discrete_symbol

Floats = NDArray[np.float64]

LONGITUDINAL = Conductivities(inner_axial=20.0, outer_axial=80.0, inner_around=2.0, outer_around=20.0)
CIRCULAR = Conductivities(20.0, 20.0, 20.0, 20.0)
DIFFUSIVITY = 0.0873
RADIUS = 0.795


def apply_surface(operator: SurfaceOperator, potential: Floats) -> Floats:
    """What an operator makes of a potential of shape (n_z, n_theta), in that shape [mV/ms]."""
    n_z, n_theta = potential.shape
    padded = np.zeros((n_z + 4, n_theta))
    padded[2:-2] = potential
    rate = np.empty(n_z * n_theta)
    operator.apply(padded.ravel(), rate, 0, rate.size)
    return rate.reshape(n_z, n_theta)


@dataclass(frozen=True)
class Surface:
    """A sealed tube of n_z by n_theta cells and its two kinds of layer; stretches are uniform unless given."""

    n_z: int
    n_theta: int
    length: float = 2.0
    radius: float = RADIUS
    conductivities: Conductivities = LONGITUDINAL
    diffusivity: float = DIFFUSIVITY
    axial_stretch: float | Floats = 1.0
    hoop_stretch: float | Floats = 1.0
    sizes: SurfaceSizes = field(init=False)

    def __post_init__(self) -> None:
        around = 2.0 * np.pi * self.radius / self.n_theta
        object.__setattr__(self, "sizes", SurfaceSizes(self.length / self.n_z, around))

    @property
    def z(self) -> Floats:
        return np.asarray((np.arange(self.n_z) + 0.5)[:, None] * self.sizes.axial, dtype=np.float64)

    @property
    def z_faces(self) -> Floats:
        return np.asarray(np.arange(1, self.n_z)[:, None] * self.sizes.axial, dtype=np.float64)

    @property
    def theta(self) -> Floats:
        return 2.0 * np.pi * np.arange(self.n_theta)[None, :] / self.n_theta

    @property
    def theta_faces(self) -> Floats:
        return self.theta + np.pi / self.n_theta

    def parts(self) -> tuple[float, Conductivities, SurfaceSizes, Floats, Floats]:
        """What an operator is built from."""
        axial = np.broadcast_to(np.asarray(self.axial_stretch, float), (self.n_z - 1, self.n_theta))
        hoop = np.broadcast_to(np.asarray(self.hoop_stretch, float), (self.n_z, self.n_theta))
        return self.diffusivity, self.conductivities, self.sizes, axial, hoop

    def monodomain(self) -> Monodomain:
        return Monodomain(*self.parts())

    def bidomain(self, tolerance: float = 1e-13) -> Bidomain:
        return Bidomain(*self.parts(), tolerance)

    def wave(self, n: int, m: int, phase: float = 0.0) -> Floats:
        """cos(n pi z/L) cos(m theta + phase): oblique where neither is zero."""
        return np.cos(n * np.pi * self.z / self.length) * np.cos(m * self.theta + phase)

    def symbols(self, n: int, m: int, discrete: bool) -> tuple[float, float]:
        """(q_i, q_e) of a wave [1/ms]: of the stencil, or of the continuum."""
        k, around = n * np.pi / self.length, m / self.radius
        if discrete:
            a, b = -discrete_symbol(k, self.sizes.axial), -discrete_symbol(around, self.sizes.around)
        else:
            a, b = k * k, around * around
        g, scale = self.conductivities, 1e-3 * self.diffusivity / self.conductivities.effective_axial
        a, b = scale * a / float(self.axial_stretch), scale * b / float(self.hoop_stretch)
        return g.inner_axial * a + g.inner_around * b, g.outer_axial * a + g.outer_around * b

    def decay(self, n: int, m: int, discrete: bool = True) -> float:
        """Q = q_i q_e/(q_i + q_e) of a wave [1/ms], Eq. (6)."""
        inner, outer = self.symbols(n, m, discrete)
        return inner * outer / (inner + outer)


@dataclass
class PathmanathanGray:
    """The unforced nonlinear problem of Pathmanathan and Gray on the cylinder, for one wave of V.

    P. Pathmanathan, R. A. Gray, Int. J. Numer. Methods Biomed. Eng. 30 (2014) 1525: V = sqrt(1 + t) F,
    u1 = (1 + t) G^2 + V, u2 = 1/((1 + t) G), here with F a wave of the sealed cylinder and G = 1 + z cos(theta)/(2L).
    Since F is an eigenfunction of the bidomain too, unequal anisotropy only changes the constant beta to -Q.
    """

    surface: Surface
    operator: SurfaceOperator
    n: int
    m: int
    discrete: bool

    def exact(self, t: float) -> Floats:
        return np.sqrt(1.0 + t) * self.surface.wave(self.n, self.m)

    def run(self, dt: float, steps: int) -> Floats:
        """V after `steps` steps of G(dt/2) V(dt) G(dt/2), with the package's operator and stabilised step."""
        s = self.surface
        shape = 1.0 + 0.5 * s.z / s.length * np.cos(s.theta)
        gain = s.decay(self.n, self.m, self.discrete)
        v = self.exact(0.0)
        u = np.stack([shape**2 + v, 1.0 / shape])
        fastest = s.decay(s.n_z, s.n_theta // 2) + self.operator.ring_rate
        table = coefficients(max(stages_for(dt * (fastest + 1.0)), 2))
        for _ in range(steps):
            u = self._gates(v, u, 0.5 * dt)

            def rate(x: Floats, u: Floats = u) -> Floats:
                return dt * (apply_surface(self.operator, x) + 0.5 * (u[0] - x) * u[1] ** 2 * x + gain * x)

            first = rate(v)
            older, last = v, v + table[0, 2] * first
            for mu, nu, mu_rate, gamma_rate in table[1:]:
                older, last = (
                    last,
                    ((1.0 - mu - nu) * v + mu * last + nu * older + mu_rate * rate(last) + gamma_rate * first),
                )
            v = last
            u = self._gates(v, u, 0.5 * dt)
        return v

    @staticmethod
    def _gates(v: Floats, u: Floats, dt: float) -> Floats:
        """u1, u2 over dt at held V, by two classical Runge-Kutta steps: far below the error of the splitting."""

        def rate(u: Floats) -> Floats:
            w = u[0] - v
            return np.stack([w * w * u[1] ** 2 + 0.5 * w * u[1] ** 2 * v, -w * u[1] ** 3])

        for _ in range(2):
            h = 0.5 * dt
            a = rate(u)
            b = rate(u + 0.5 * h * a)
            c = rate(u + 0.5 * h * b)
            d = rate(u + h * c)
            u = u + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        return u
