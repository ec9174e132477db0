"""Longitudinal muscle gathered in three bands, as in the human colon."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="taenia",
    title="Taenia-like bands",
    description=(
        "The longitudinal muscle pulls in three stripes of 6 mm, evenly spread around the ring, and with a fifth of "
        "its force in between. Cells and conduction are those of the baseline."
    ),
    expected=(
        "Shortening along the bands and pouches between them while the longitudinal muscle is active; the circular "
        "ring that propels the pellet is as before, so the transit changes little."
    ),
    changes={
        "regions": [
            {
                "name": "between the taeniae",
                "layer": "longitudinal",
                "shape": "band",
                "z_from": "0 cm",
                "z_to": "10 cm",
                "active": 0.2,
            },
            {
                "name": "taeniae",
                "layer": "longitudinal",
                "shape": "stripes",
                "number": 3,
                "width": "6 mm",
                "edge": "1 mm",
                "active": 5.0,
            },
        ],
        "grid.n_z": 400,
        "grid.n_z_wall": 100,
        "grid.n_theta": 12,
        "grid.n_theta_conduction": 48,
        "output.interval": "20 ms",
        "run.duration": "4 s",
    },
)
