"""Circular muscle alone, in rings that stand."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="segmentation",
    title="Segmentation",
    description=(
        "Rings of the circular layer contract together every 3 s and do not spread; the longitudinal layer "
        "has no force, and pacemaker, trigger and reflex are off."
    ),
    expected="The paper reports librations of small amplitude without propulsion.",
    changes={
        "longitudinal.active": 0.0,
        "circular.conduction": False,
        "rings.enabled": True,
        "pacemaker.kind": "none",
        "trigger.rule": "none",
        "reflex.enabled": False,
    },
)
