"""How long one wave takes to carry the pellet through the segment.

Prints the transit time of the baseline. Run it as `python examples/transit_time.py`; `--quick` takes coarser
grids, which is faster and less exact.
"""

from __future__ import annotations

import argparse
import sys

import peristalsis as ps

QUICK = {"grid.n_z": 400, "grid.n_z_wall": 200, "step.conduction": "0.5 ms", "step.wall": "4 ms"}


def main() -> None:
    """Run the baseline and print its transit time."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="coarser grids and steps")
    quick = parser.parse_args().quick

    result = ps.run("baseline", QUICK if quick else {})
    for remark in result.remarks:
        print(f"note: {remark}", file=sys.stderr)
    if result.status != "expelled":
        raise SystemExit(f"the pellet was not expelled: {result.status} {result.error or ''}")

    # The pellet starts with its trailing pole 0.3 cm from the oral end and is expelled when its leading pole reaches
    # the anal end, so it travels less than the length of the segment.
    summary = result.summary
    travel, length = summary["travel_cm"], result.configuration.wall.length
    mean = summary["mean_velocity_cm_s"]

    print(
        f"{summary['transit_s']:.3f} s: transit time of the pellet. It travelled {travel:.2f} cm of a segment of "
        f"{length:g} cm at a mean speed of {mean:.2f} cm/s; the paper reports 2.4 s."
    )


if __name__ == "__main__":
    main()
