"""A small diameter map for notebooks, as an HTML image."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING

from . import data

if TYPE_CHECKING:
    from ..results.result import Result


def thumbnail(result: Result) -> str:
    """Diameter over time (to the right) and place (oral end at the top); empty where nothing can be drawn."""
    from matplotlib.figure import Figure

    from . import style

    time, axis, diameter = data.diameter_map(result)
    if time.size < 2:
        return ""
    with style.applied():
        figure = Figure(figsize=(3.2, 1.8), dpi=100, layout="constrained")
        panel = figure.subplots()
        mesh = panel.pcolormesh(time, axis, diameter.T, cmap=style.DIAMETER, shading="nearest", rasterized=True)
        panel.set_ylim(axis[-1], axis[0])
        panel.set_xlabel("time (s)")
        panel.set_ylabel("position (mm)")
        figure.colorbar(mesh, ax=panel, label="diameter (mm)")
        image = io.BytesIO()
        figure.savefig(image, format="png")
    text = base64.b64encode(image.getvalue()).decode("ascii")
    return f'<img alt="diameter over time and place, oral end at the top" src="data:image/png;base64,{text}"/>'
