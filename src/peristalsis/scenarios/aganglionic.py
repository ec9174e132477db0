"""A segment without nerves and without pacemaker cells."""

from peristalsis.scenarios import Scenario

SCENARIO = Scenario(
    name="aganglionic",
    title="Aganglionic segment",
    description=(
        "Between 5 and 8 cm both layers lack what drives them, as in Hirschsprung's disease: no excitation and no "
        "inhibition by the reflex, no trigger, and no network of pacemaker cells, so that no wave is passed on. The "
        "muscle itself is healthy."
    ),
    expected=(
        "A functional obstruction: the waves end at the oral edge of the segment, and the pellet is left there. "
        "Nerves alone make no such obstruction in this model: where the sheets still conduct, the wave runs through."
    ),
    changes={
        "regions": [
            {
                "name": "aganglionic segment",
                "shape": "band",
                "z_from": "5 cm",
                "z_to": "8 cm",
                "conductivity": 0.0,
                "pacemaker": 0.0,
                "trigger": 0.0,
                "excitation": 0.0,
                "inhibition": 0.0,
            }
        ],
        "run.duration": "6 s",
    },
)
