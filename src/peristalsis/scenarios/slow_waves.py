"""Interstitial cells and gastric muscle: slow waves that arise by themselves."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="slow_waves",
    title="Slow waves of interstitial cells",
    description=(
        "A network of interstitial cells (du_2013) drives both layers of gastric muscle (corrias_buist_2007) by gaps; "
        "there is no pacemaker, no trigger and no reflex. The network's cells begin a slow wave under way, a second "
        "later with every centimetre, and their period is a little shorter at the oral end. The muscle of the paper "
        "pulls four times as hard above -55 mV, since slow waves reach -45 mV only. The cells are those of a stomach."
    ),
    expected="One slow wave runs along the tube in some ten seconds and carries the pellet before it.",
    changes={
        "tissue.cell": "corrias_buist_2007",
        "network.enabled": True,
        "network.head_start": "19 s",
        "network.lag": "1 s/cm",
        "pacemaker.kind": "none",
        "trigger.rule": "none",
        "reflex.enabled": False,
        "longitudinal.active": 4.0,
        "circular.active": 4.0,
        "pellet.start_gap": "1 cm",
        "regions": [
            {
                "name": "gradient of the period",
                "layer": "network",
                "shape": "map",
                "quantities": ["ip3_voltage_production"],
                "z": ["0 cm", "10 cm"],
                "angle": ["0 deg"],
                "values": [[1.12], [0.97]],
            }
        ],
        "grid.n_z": 200,
        "grid.n_z_wall": 600,
        "step.wall": "10 ms",
        "step.conduction": "0.5 ms",
        "output.interval": "50 ms",
        "run.duration": "40 s",
    },
)
