"""How hard the wall presses on the pellet.

Prints the largest contact pressure of the baseline, in kPa and in mmHg, the unit of manometry, and says when and
where it occurs. `--quick` takes coarser grids and steps.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np

import peristalsis as ps

QUICK = {"grid.n_z": 400, "grid.n_z_wall": 200, "step.conduction": "0.5 ms", "step.wall": "4 ms"}
KPA_PER_MMHG = 0.133322


def main() -> None:
    """Run the baseline and look for the largest contact pressure of all steps."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="coarser grids and steps")
    quick = parser.parse_args().quick

    result = ps.run("baseline", QUICK if quick else {})
    for remark in result.remarks:
        print(f"note: {remark}", file=sys.stderr)

    # Contact pressure comes on top of the pressure of the lumen, which is the same all along the tube.
    contact = result.dataset["max_contact_pressure"]
    step = int(np.argmax(contact.values))
    largest = float(contact[step])
    moment = result.dataset.isel(time_step=step)
    if not np.isfinite(largest):
        raise SystemExit("the wall never touched the pellet")

    print(
        f"{largest:.2f} kPa: largest contact pressure on the pellet, {largest / KPA_PER_MMHG:.0f} mmHg, at "
        f"t = {float(moment.time_step):.2f} s with the pellet at {float(moment.pellet_position):.1f} cm; the lumen "
        f"is at {float(moment.lumen_pressure):.2f} kPa then."
    )


if __name__ == "__main__":
    main()
