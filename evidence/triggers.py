"""The rules by which the circular layer follows the longitudinal one, with and without the receptors.

Writes docs/evidence/triggers.md and triggers.png. About two minutes on one core.
"""

from __future__ import annotations

from common import diameter_maps, run_all, save_text, table

RULES = ("active", "total", "pacemaker", "delay", "none")


def main() -> None:
    """Run the rules and write table and picture."""
    cases = {}
    for receptors in (True, False):
        for rule in RULES:
            label = f"{rule}, receptors {'on' if receptors else 'off'}"
            cases[label] = ("baseline", {"trigger.rule": rule, "reflex.enabled": receptors})
    results = run_all(cases)
    rows = [
        (
            label,
            result.status,
            result.summary["transit_s"],
            result.summary["final_position_cm"],
            result.summary["mean_velocity_cm_s"],
            result.summary["wave_speed_cm_s"]["circular"],
            result.summary["max_axial_force_mN"],
        )
        for label, result in results.items()
    ]
    head = (
        "trigger.rule",
        "status",
        "transit (s)",
        "final position (cm)",
        "mean velocity (cm/s)",
        "circular wave (cm/s)",
        "largest axial force (mN)",
    )
    text = "# Trigger rules\n\nMade by `python evidence/triggers.py`.\n\n" + table(head, rows)
    save_text("triggers.md", text + "\n![diameter maps](triggers.png)\n")
    diameter_maps("triggers.png", results, columns=2)


if __name__ == "__main__":
    main()
