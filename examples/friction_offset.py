"""How much lubrication makes up for a sticky pellet.

Raises dry friction from 20 to 450 mN and looks for the viscous friction at which the pellet is as fast as in the
baseline again. Prints that coefficient. `--quick` takes coarser grids and steps.
"""

from __future__ import annotations

import argparse
import sys

from scipy.optimize import brentq

import peristalsis as ps

QUICK = {"grid.n_z": 400, "grid.n_z_wall": 200, "step.conduction": "0.5 ms", "step.wall": "4 ms"}
DRY = "450 mN"  # the paper prints 450 N; see docs/decisions/0002
LEAST, MOST = 60.0, 230.0  # viscous friction [mN*s/cm] between which to look


def transit(changes: dict[str, object]) -> float:
    """Transit time [s] of the baseline with some changes; its 10 s if the pellet is not expelled."""
    result = ps.run("baseline", changes)
    return float(result.summary["transit_s"] or result.configuration.run.duration)


def main() -> None:
    """Search for the viscous friction that restores the transit time of the baseline."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="coarser grids and steps")
    grids: dict[str, object] = dict(QUICK) if parser.parse_args().quick else {}
    if grids:
        print("note: coarse grids, the number is rough", file=sys.stderr)

    wanted = transit(grids)

    def late(viscous: float) -> float:
        changes = {"pellet.dry_friction": DRY, "pellet.viscous_friction": f"{viscous} mN*s/cm"}
        return transit(grids | changes) - wanted

    if late(LEAST) * late(MOST) > 0.0:
        raise SystemExit(f"no viscous friction between {LEAST:g} and {MOST:g} mN*s/cm restores {wanted:.3f} s")
    viscous = brentq(late, LEAST, MOST, xtol=2.0)

    print(
        f"{viscous:.0f} mN*s/cm: viscous friction at which a dry friction of {DRY} leaves the transit time at "
        f"{wanted:.2f} s; in the baseline 230 mN*s/cm go with 20 mN."
    )


if __name__ == "__main__":
    main()
