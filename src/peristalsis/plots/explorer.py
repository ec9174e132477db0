"""A run to look through in a notebook: tube and pellet at a time, the diameter map, numbers, moved by a slider."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass, field
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ConfigurationError
from ..names import OUTPUTS
from . import data

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..results.result import Result

MOST_FRAMES = 400
NODES = 110
"""Most nodes of the wall in a picture: closer than a millimetre in the shipped tube."""
FINE = 100.0
"""Lengths go as whole numbers of 1/100 mm, which no screen shows."""
NUMBERS = ("pellet_position", "pellet_velocity", "axial_force", "max_contact_pressure", "min_diameter")


@dataclass(frozen=True)
class Explorer:
    """What the last line of a notebook's cell shows; `html` can stand in any page, and asks no kernel for anything."""

    html: str = field(repr=False)
    frames: int

    def _repr_html_(self) -> str:
        return self.html


def explorer(result: Result, frames: int) -> Explorer:
    """The explorer of a run. Raises ConfigurationError for no frames or too many, or where fields were not stored."""
    if not 1 <= frames <= MOST_FRAMES:
        raise ConfigurationError(f"explorer with {frames} frames: give 1 to {MOST_FRAMES}")
    chosen = data.spread_frames(result, frames)
    content = html.escape(json.dumps(_content(result, chosen), separators=(",", ":")))
    script = resources.files(__package__ or "").joinpath("explorer.js").read_text(encoding="utf-8")
    about = html.escape(f"{result.configuration.scenario}, reading {result.configuration.reading}")
    return Explorer(
        f'<div class="peristalsis-explorer" data-run="{content}"><b>{about}</b>'
        '<canvas role="img" aria-label="tube and pellet, cut along the axis, oral end on the left"></canvas>'
        '<div style="display:flex;gap:0.7em"><input type="range" min="0" step="1" aria-label="time" style="flex:1">'
        "<output></output></div>"
        '<canvas role="img" aria-label="diameter over place, to the right, and time, downwards"></canvas>'
        f"<table></table></div><script>{script}</script>",
        len(chosen),
    )


def _content(result: Result, chosen: list[int]) -> dict[str, Any]:
    """Times [s], wall and pellet [1/100 mm], and numbers at these times with their labels and units."""
    axial, across = data.cut(result, "axial_position", "mm")[:, chosen], data.profile(result)[:, chosen]
    count = axial.shape[2]
    nodes = np.unique(np.rint(np.linspace(0, count - 1, min(count, NODES))).astype(np.int64))
    sides = 1 if np.array_equal(across[0], -across[1]) and np.array_equal(axial[0], axial[1]) else 2
    names = [name for name in NUMBERS if name in result.arrays]
    content = {
        "time": data.values(result, "time")[chosen].round(4).tolist(),
        "span": round(FINE * data.span(result)),
        "axial": _whole(axial[:sides][:, :, nodes]),
        "across": _whole(across[:sides][:, :, nodes]),
        "numbers": [
            {
                "label": OUTPUTS[name].long_name,
                "unit": OUTPUTS[name].unit,
                "values": [float(f"{value:.4g}") for value in data.at_frames(result, name)[chosen]],
            }
            for name in names
        ],
    }
    if data.has_pellet(result):
        content["centre"] = _whole(data.at_frames(result, "pellet_position", "mm")[chosen])
        content["outline"] = _whole(data.pellet_outline(result)[::2])
    return content


def _whole(lengths: NDArray[np.float64]) -> Any:
    return np.rint(FINE * lengths).astype(np.int64).tolist()
