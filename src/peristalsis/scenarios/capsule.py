"""A capsule of the size of those that are swallowed to look at the gut from within."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="capsule",
    title="A capsule of 11 x 26 mm",
    description=(
        "A cylinder with round caps, 11 mm wide and 26 mm long, the size of a video capsule, in a tube of 9.72 mm: the "
        "ratio of girth and tube is that of the reading tight. All else is the baseline."
    ),
    expected="The capsule is expelled somewhat earlier than the sphere: its leading pole has a shorter way to go.",
    changes={
        "pellet.shape": "capsule",
        "pellet.radius": "5.5 mm",
        "pellet.capsule.length": "26 mm",
        "wall.radius": "4.86 mm",
    },
)
