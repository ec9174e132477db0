"""A patch of tissue whose calcium channels are blocked: a wave that goes round it."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="blocked_patch",
    title="Patch of blocked channels",
    description=(
        "A disc of 8 mm radius on one side of the tube, half-way along, where fast and slow calcium channels of both "
        "layers are blocked, as by a drug applied there. The pacemaker drives the whole ring."
    ),
    expected=(
        "The front is delayed in the shadow of the patch and closes again behind it; inside the patch no muscle pulls, "
        "so the ring is squeezed from one side there and the pellet is slowed."
    ),
    changes={
        "regions": [
            {
                "name": "blocked patch",
                "shape": "disc",
                "z": "5 cm",
                "angle": "180 deg",
                "radius": "8 mm",
                "edge": "1 mm",
                "fast_calcium": 0.0,
                "slow_calcium": 0.0,
            }
        ],
        "grid.n_z": 400,
        "grid.n_z_wall": 100,
        "grid.n_theta": 16,
        "grid.n_theta_conduction": 64,
        "output.interval": "20 ms",
        "run.duration": "4 s",
    },
)
