"""The axial force on the pellet in three separately coded ways, from the stored results alone.

End reactions of the tube; quadrature of the stored contact pressure over the deformed wall; the pellet's own
equation, eta*v + F_d*sgn(v). Writes docs/evidence/forces.md. About two minutes on one core.
"""

from __future__ import annotations

import numpy as np
from common import run_all, save_text, table

ELEMENTS = (200, 400, 800, 1600)


def quadrature(result) -> np.ndarray:  # type: ignore[no-untyped-def]
    """-2 pi int q (zeta - Z) d zeta over the contact [mN] at every stored frame: on a sphere, exact area by height."""
    d = result.dataset
    q = d["contact_pressure"].values[:, :, 0] * 100.0
    zeta = d["axial_position"].values[:, :, 0]
    frames = np.rint(d["time"].values / (d["time_step"].values[1])).astype(int)
    centre = d["pellet_position"].values[frames]
    moment = q * (zeta - centre[:, None])
    return -2.0 * np.pi * np.sum(0.5 * (moment[:, 1:] + moment[:, :-1]) * np.diff(zeta, axis=1), axis=1)


def from_stored_pressure(result) -> np.ndarray:  # type: ignore[no-untyped-def]
    """(F -+ F_d) / eta [cm/s] at every stored frame, from the stored contact pressures and wall shapes alone."""
    d, c = result.dataset, result.configuration
    frames = np.rint(d["time"].values / (d["time_step"].values[1])).astype(int)
    centre = d["pellet_position"].values[frames][:, None]
    zeta, rho = d["axial_position"].values[:, :, 0], d["radius"].values[:, :, 0]
    stretches = d["stretch_longitudinal"].values[:, :, 0] * d["stretch_circumferential"].values[:, :, 0]
    area = 2.0 * np.pi * c.wall.radius * c.wall.length / c.grid.n_z_wall * stretches
    push = d["contact_pressure"].values[:, :, 0] * 100.0 * area
    force = -(push * (zeta - centre) / np.hypot(rho, zeta - centre)).sum(axis=1)
    excess = np.maximum(np.abs(force) - c.pellet.dry_friction, 0.0)
    return np.sign(force) * excess / c.pellet.viscous_friction


def main() -> None:
    """Run the grids and write the table."""
    cases = {
        str(n): ("baseline", {"grid.n_z_wall": n, "output.interval": "5 ms", "run.duration": "1.2 s"}) for n in ELEMENTS
    }
    results = run_all(cases)
    rows = []
    before = None
    for label, result in results.items():
        d = result.dataset
        force, velocity = d["axial_force"].values, d["pellet_velocity"].values
        eta, dry = result.configuration.pellet.viscous_friction, result.configuration.pellet.dry_friction
        ends = d["anal_reaction"].values - d["oral_reaction"].values
        scale = np.abs(force).max()
        sliding = velocity != 0.0
        law = eta * velocity + dry * np.sign(velocity)
        pressure = quadrature(result)
        frames = np.rint(d["time"].values / (d["time_step"].values[1])).astype(int)
        moved = np.abs(from_stored_pressure(result) - velocity[frames]).max()
        error = float(np.sqrt(np.mean((pressure - force) ** 2)) / scale)
        order = None if before is None else float(np.log2(before / error))
        before = error
        rows.append(
            (
                label,
                f"{np.abs(ends - force)[1:].max() / scale:.1e}",
                f"{np.abs(law - force)[sliding].max() / scale:.1e}",
                f"{moved:.1e}",
                f"{error:.2e}",
                order,
                int((~sliding).sum()),
                float(np.abs(force[~sliding]).max()),
            )
        )
    head = (
        "wall elements",
        "ends, largest / max F",
        "eta v + F_d sgn v, largest / max F",
        "v from stored contact pressures, largest difference (cm/s)",
        "pressure quadrature, rms / max F",
        "order",
        "steps stuck (v = 0 exactly)",
        "largest force while stuck (mN), F_d = 20",
    )
    text = "# Three evaluations of the axial force\n\nMade by `python evidence/forces.py`.\n\n" + table(head, rows)
    save_text("forces.md", text)


if __name__ == "__main__":
    main()
