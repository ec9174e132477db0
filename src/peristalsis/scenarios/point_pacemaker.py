"""A pacemaker on one side of the tube: fronts that wrap around the ring."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="point_pacemaker",
    title="Pacemaker at a point",
    description=(
        "The pacemaker drives a patch 5 mm long and 60 degrees wide at the oral end instead of the whole ring. The "
        "front runs along the fibres of each layer faster than across them and has to wrap around the tube before a "
        "ring can close behind the pellet."
    ),
    expected=(
        "An oblique front on either layer, a wall that contracts on one side first and bows, and a later start of the "
        "pellet than with a ring of pacemakers."
    ),
    changes={
        "pacemaker.width": "5 mm",
        "pacemaker.angular_width": "60 deg",
        "grid.n_z": 400,
        "grid.n_z_wall": 100,
        "grid.n_theta": 16,
        "grid.n_theta_conduction": 128,
        "output.interval": "20 ms",
        "output.fields": [
            "stretch_longitudinal",
            "stretch_circumferential",
            "tension_longitudinal",
            "tension_circumferential",
            "contact_pressure",
        ],
        "run.duration": "4 s",
    },
)
