"""What half the muscle costs in time.

Halves the force of both layers, leaves their waves alone, and prints how much later the pellet arrives. `--quick`
takes coarser grids and steps.
"""

from __future__ import annotations

import argparse
import sys

import peristalsis as ps

QUICK = {"grid.n_z": 400, "grid.n_z_wall": 200, "step.conduction": "0.5 ms", "step.wall": "4 ms"}

# `active` is a factor on the force that the wall feels. The electrical side does not know it: the wave that the layer
# carries, and the rule that starts the circular layer, are those of full force.
HALF = {"longitudinal.active": 0.5, "circular.active": 0.5}


def transit(changes: dict[str, object]) -> float:
    """Transit time [s] of the baseline with some changes."""
    result = ps.run("baseline", changes)
    for remark in result.remarks:
        print(f"note: {remark}", file=sys.stderr)
    if result.status != "expelled":
        raise SystemExit(f"the pellet was not expelled: {result.status} {result.error or ''}")
    return float(result.summary["transit_s"])


def main() -> None:
    """Run with full and with half force."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="coarser grids and steps")
    grids: dict[str, object] = dict(QUICK) if parser.parse_args().quick else {}
    if grids:
        print("note: coarse grids, the number is rough", file=sys.stderr)

    full = transit(grids)
    half = transit(grids | HALF)

    print(
        f"{half - full:.2f} s: delay of the pellet when both layers pull with half their force; {half:.2f} s instead "
        f"of {full:.2f} s."
    )


if __name__ == "__main__":
    main()
