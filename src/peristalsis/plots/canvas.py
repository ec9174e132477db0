"""A matplotlib Figure that a notebook shows as it is, whether or not pyplot was ever imported there."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

SHOWN_DPI = 110
"""Of pictures in notebooks; files have their own."""


class ShownFigure(Figure):  # type: ignore[misc]  # matplotlib has no types here
    """Belongs to no window; the last line of a notebook's cell shows it."""

    def _repr_png_(self) -> bytes:
        from .style import applied

        image = io.BytesIO()
        with applied():
            self.savefig(image, format="png", dpi=SHOWN_DPI)
        return image.getvalue()
