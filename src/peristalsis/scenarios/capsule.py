"""A capsule of the size of a swallowed one, instead of the sphere."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="capsule",
    title="Capsule of 11 x 26 mm",
    description=(
        "A cylinder with hemispherical caps, 11 mm wide and 26 mm long, in a tube of 4.86 mm radius, which it stretches "
        "as much as the sphere of the baseline stretches its own. All else is as in the baseline."
    ),
    expected=(
        "Not in the paper. Should be carried out by one wave. In the wider tube of the baseline it lies loose: the wave "
        "slips over it and leaves it behind within the first few centimetres."
    ),
    changes={
        "pellet.shape": "capsule",
        "pellet.radius": "5.5 mm",
        "pellet.capsule.length": "26 mm",
        "wall.radius": "4.86 mm",
    },
)
