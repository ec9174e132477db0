"""The paper's own misprints, each put back into a copy of the program: which tests notice, what the baseline does.

Writes docs/evidence/misprints.md. About a quarter of an hour on one core.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

from common import save_text, table
from patching import Patch, baseline, failing_tests, patched

PHYSICS = ("tests/verification", "tests/properties", "tests/unit")
QUICK = (
    "tests/unit/test_passive.py",
    "tests/unit/test_membrane.py",
    "tests/unit/test_shapes.py",
    "tests/unit/test_contact.py",
    "tests/unit/test_friction.py",
    "tests/unit/test_parameters.py",
    "tests/unit/test_units.py",
    "tests/verification/test_problems.py",
    "tests/verification/test_wall_problems.py",
    "tests/verification/test_contact_problems.py",
    "tests/properties",
)


@dataclass(frozen=True)
class Misprint:
    """What the paper prints: as patches of the program, or as values where only a number is misprinted."""

    where: str
    printed: str
    patches: tuple[Patch, ...] = ()
    changes: tuple[str, ...] = ()
    tests: Sequence[str] = QUICK


MEMBRANE, PASSIVE = "wall/membrane.py", "wall/laws/tong_fung.py"
MISPRINTS = (
    Misprint(
        "(2)",
        "the passive tension multiplies the active one",
        (
            Patch(MEMBRANE, "carried(vl, al, pl, fold_l, c)", "carried(vl, al * pl, 0.0, fold_l, c)"),
            Patch(MEMBRANE, "carried(vc, ac, pc, fold_c, c)", "carried(vc, ac * pc, 0.0, fold_c, c)"),
            Patch(
                MEMBRANE,
                "drive_longitudinal * dml + dpl * wll",
                "drive_longitudinal * (dml * pl + ml * dpl * wll)",
            ),
            Patch(MEMBRANE, "drive_circular * dmc + dpc * wcc", "drive_circular * (dmc * pc + mc * dpc * wcc)"),
            Patch(MEMBRANE, "dl * dpl * wlc", "dl * drive_longitudinal * ml * dpl * wlc"),
            Patch(MEMBRANE, "dc * dpc * wlc", "dc * drive_circular * mc * dpc * wlc"),
        ),
    ),
    Misprint(
        "after (2)",
        "strain is stretch plus one",
        (
            Patch(PASSIVE, "el = longitudinal - 1.0", "el = longitudinal + 1.0", 3),
            Patch(PASSIVE, "ec = circumferential - 1.0", "ec = circumferential + 1.0", 3),
        ),
    ),
    Misprint(
        "(4)",
        "the cross term squared in ε_c",
        (
            Patch(PASSIVE, "2.0 * c.c3 * el * ec + c.c2", "2.0 * c.c3 * el * ec * ec + c.c2"),
            Patch(PASSIVE, "c.c1 * el + c.c3 * ec + g * gl", "c.c1 * el + c.c3 * ec * ec + g * gl"),
            Patch(PASSIVE, "c.c3 * el + c.c2 * ec + g * gc", "2.0 * c.c3 * el * ec + c.c2 * ec + g * gc"),
            Patch(PASSIVE, "c.c3 + g * (gl * gc", "2.0 * c.c3 * ec + g * (gl * gc"),
            Patch(PASSIVE, "c.c2 + g * (gc * gc", "c.c2 + 2.0 * c.c3 * el + g * (gc * gc"),
        ),
    ),
    Misprint(
        "(11)",
        "M_vs/(1 + μ) before the term around the ring only",
        tests=(*QUICK, "tests/verification/test_wave_speed.py"),
        patches=(
            Patch(
                "inputs/build.py",
                "    return 1e3 * c.tissue.volume_to_surface * series / capacitance",
                "    if layer is c.circular:\n"
                "        return 1e3 * layer.conductivity_scale * outer / capacitance\n"
                "    return 1e3 * c.tissue.volume_to_surface * series / capacitance",
            ),
        ),
    ),
    Misprint(
        "(12)",
        "the displacement u_z for the place, and a term in u_s",
        (
            Patch(
                "model/residual.py",
                "axial = zeta[i] - scalars[1]\n            work[TOUCHES, i] = 0.0",
                "axial = zeta[i] - i * h - scalars[1]\n            work[TOUCHES, i] = 0.0",
            ),
            Patch(
                "pellet/shapes/sphere.py",
                "distance = math.sqrt(rho * rho + axial * axial)",
                "distance = math.sqrt(rho * rho + axial * axial + 0.795 * 0.795)",
            ),
        ),
    ),
    Misprint(
        "(13)",
        "dry friction without the sign of the motion",
        (Patch("pellet/friction.py", "    if force > dry:\n", "    if force > -1e300:\n"),),
    ),
    Misprint(
        "γ0",
        "26.14 g/cm² (with wall inertia)",
        changes=("wall.inertia=true", "wall.surface_density=26140 mg/cm^2"),
    ),
    Misprint(
        "friction",
        "230 N s/m and 20 N taken literally",
        changes=("pellet.viscous_friction=2300 mN*s/cm", "pellet.dry_friction=20000 mN"),
    ),
    Misprint("p0", "1.0 kPa, as in the list of parameters", changes=("lumen.pressure=1 kPa",)),
    Misprint(
        "conductivities",
        "as printed, without the calibrated scale (60 ms)",
        changes=("longitudinal.conductivity_scale=1", "circular.conductivity_scale=1", "run.duration=60 ms"),
    ),
    Misprint(
        "g_is = 2 in the isotropic set",
        "2 for 20",
        changes=("circular.intracellular_circumferential=2 mS/cm",),
    ),
)


WORDS = """
(11) as printed makes the circular wave six times as fast: it runs ahead of the pellet, closes the tube everywhere, and
transit takes 5.8 s. (12) as printed lets nothing touch the pellet. At the printed conductivities the pacemaker's pulse
is drained by its surroundings and starts no wave (nor within 7 s, in a run stopped by hand).
"""
"""What was seen when this was made; the table says whether it still is."""


def _speeds(found: dict[str, object]) -> str:
    """Wave speeds of both layers."""
    speeds = found.get("wave_speed_cm_s")
    if not isinstance(speeds, dict):
        return "–"
    return ", ".join("–" if speed is None else f"{speed:.4g}" for speed in speeds.values())


def main() -> None:
    """Put every misprint back, run tests and baseline, write the table."""
    rows = []
    for one in MISPRINTS:
        print(f"{one.where}: {one.printed} ...", file=sys.stderr, flush=True)
        with patched(one.patches) as tree:
            caught = failing_tests(tree, one.tests) if one.patches else []
            found = baseline(tree, one.changes)
        names = [name.rsplit("/", 1)[-1].replace(".py", "") for name in caught]
        shown = ", ".join(f"`{name}`" for name in names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
        transit = found.get("transit_s")
        force = found.get("max_axial_force_mN")
        rows.append(
            (
                one.where,
                one.printed,
                shown or "a number, not a formula: `test_parameters` holds the value",
                str(found["status"]).replace("_", " "),
                transit,
                found.get("travel_cm"),
                force,
                _speeds(found),
                str(found.get("error") or "–")[:160],
            )
        )
    head = (
        "where",
        "as printed",
        "tests that fail",
        "baseline",
        "transit (s)",
        "travel (cm)",
        "largest force (mN)",
        "waves (cm/s)",
        "error",
    )
    text = "# The paper's misprints put back\n\nMade by `python evidence/misprints.py`: each is put alone into a copy "
    text += "of the program. Where only a number or a unit is misprinted the run takes it as a change. The corrected "
    text += "baseline: 2.374 s, 7.9 cm, 1395 mN.\n\n"
    save_text("misprints.md", text + table(head, rows) + WORDS)


if __name__ == "__main__":
    main()
