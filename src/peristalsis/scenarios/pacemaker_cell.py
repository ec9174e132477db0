"""A pacemaker that keeps its own time."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="pacemaker_cell",
    title="Autonomous pacemaker cell",
    description="A bursting cell coupled to the oral end replaces the pulse; 25 s hold two of its bursts.",
    expected="Not in the paper.  Alone, the cell bursts every 10.5 s; coupled, the muscle loads it.",
    changes={"pacemaker.kind": "cell", "run.duration": "25 s"},
)
