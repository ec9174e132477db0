"""Results made by hand, with as many columns around the ring as wanted: what the figures and exports are tried on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from peristalsis.results.result import Result

SPEED = 4.0
"""Speed of the front of `around` in every direction [cm/s]."""


def around(run: Result, columns: int, centre: tuple[float, float] = (3.0, 120.0)) -> Result:
    """A run of one column as one of many: a bulge on one side, and a front that spreads from a point [cm, deg]."""
    arrays = dict(run.arrays)
    turn = 2.0 * np.pi * np.arange(columns) / columns
    arrays["theta"] = turn
    for name, values in run.arrays.items():
        if values.ndim >= 2 and values.shape[-1] == 1:
            arrays[name] = np.repeat(values, columns, axis=-1)
    z = run.arrays["z"]
    bulge = 1.0 + 0.2 * np.sin(np.pi * z / z[-1])[:, None] * np.cos(turn)
    arrays["radius"] = arrays["radius"] * bulge
    arrays["angle"] = np.broadcast_to(turn, arrays["radius"].shape).copy()
    arrays["stretch_circumferential"] = arrays["stretch_circumferential"] * bulge
    away = (turn - np.deg2rad(centre[1]) + np.pi) % (2.0 * np.pi) - np.pi
    distance = np.hypot(run.arrays["z_cell"][:, None] - centre[0], run.configuration.wall.radius * away)
    for layer in ("longitudinal", "circular"):
        arrays[f"activation_{layer}"] = distance / SPEED
    return replace(run, arrays=arrays)
