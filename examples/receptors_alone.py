"""Can the pellet start its own way out?

Turns the pacemaker off and leaves the stretch receptors on: the pellet itself excites the wall behind it and inhibits
it ahead. Prints the transit time. `--quick` takes coarser grids and steps.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np

import peristalsis as ps

QUICK = {"grid.n_z": 400, "grid.n_z_wall": 200, "step.conduction": "0.5 ms", "step.wall": "4 ms"}
STILL = 0.01  # cm/s


def main() -> None:
    """Run the scenario of the reflex alone and print the transit time."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="coarser grids and steps")
    quick = parser.parse_args().quick

    result = ps.run("reflex_only", QUICK if quick else {})
    for remark in result.remarks:
        print(f"note: {remark}", file=sys.stderr)
    if result.status != "expelled":
        raise SystemExit(f"the pellet was not expelled: {result.status} {result.error or ''}")

    # How irregular the motion is shows in the time the pellet stands still, or is pushed back.
    velocity = result.dataset["pellet_velocity"]
    standing = 100.0 * float(np.mean(np.abs(velocity) < STILL))
    back = 100.0 * float(np.mean(velocity <= -STILL))

    print(
        f"{result.summary['transit_s']:.2f} s: transit time with the stretch receptors alone; the pellet stood still "
        f"for {standing:.0f} % of it and moved backwards for {back:.0f} %."
    )


if __name__ == "__main__":
    main()
