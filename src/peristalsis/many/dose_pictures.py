"""Pictures of dose and response: what a pellet does against the concentration of an agent."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..inputs.drugs import NOT_ADVICE, amount
from ..plots import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .dose_response import DoseResponse

PANELS = (
    ("transit", "transit_s", "transit (s)", style.BLACK),
    ("speed", "mean_velocity_cm_s", "mean speed (cm/s)", style.BLUE),
    ("force", "max_axial_force_mN", "largest axial force (mN)", style.VERMILION),
)
"""Response, number of a run, label, colour."""
UNITS = (("mM", 1e6), ("uM", 1e3), ("nM", 1.0), ("pM", 1e-3))


def dose_figure(found: DoseResponse) -> Figure:
    """Three panels side by side, with the fitted curves; a run without a transit is a cross, with its status."""
    from matplotlib.figure import Figure

    middle = float(np.sqrt(found.concentrations[0] * found.concentrations[-1]))
    unit, size = next((one for one in UNITS if middle >= one[1]), UNITS[-1])
    with style.applied():
        figure = Figure(figsize=(1.35 * style.WIDTH, 3.6), dpi=style.DPI, layout="constrained")
        beside = f", beside {', '.join(found.beside)}" if found.beside else ""
        targets = ", ".join(f"{one.target}, IC50 {amount(one.ic50)} in {one.tissue}" for one in found.doses)
        figure.suptitle(f"{found.agent} ({targets}){beside}", x=0.01, ha="left")
        for axes, (response, name, label, colour) in zip(figure.subplots(1, 3), PANELS, strict=True):
            _points(axes, found, name, colour, size)
            if response in found.curves:
                _curve(axes, found, response, colour, size)
            axes.set_xscale("log")
            axes.set(xlabel=f"concentration ({unit.replace('u', 'µ')})", ylabel=label)
            axes.set_ylim(0.0, 1.05 * axes.get_ylim()[1])
            axes.grid(alpha=0.25)
            if axes.get_legend_handles_labels()[0]:
                axes.legend(loc="best")
        figure.supxlabel(NOT_ADVICE, x=0.99, ha="right", fontsize=7.5, color=style.GREY)
    return figure


def _points(axes: Axes, found: DoseResponse, name: str, colour: str, size: float) -> None:
    control = found.control.summary.get(name)
    if control is not None:
        axes.axhline(control, color=style.GREY, linestyle=":", linewidth=1.0, label="without")
    places = np.array(found.concentrations) / size
    values = [row.summary.get(name) for row in found.rows]
    known = [k for k, value in enumerate(values) if value is not None]
    axes.plot(places[known], [values[k] for k in known], "o", color=colour, markersize=4.5)
    for status in dict.fromkeys(found.rows[k].status for k in range(len(values)) if values[k] is None):
        at = [k for k, row in enumerate(found.rows) if values[k] is None and row.status == status]
        axes.plot(
            places[at],
            np.full(len(at), 0.97),
            "x",
            color=style.PURPLE,
            transform=axes.get_xaxis_transform(),
            label=status.replace("_", " "),
            clip_on=False,
        )


def _curve(axes: Axes, found: DoseResponse, response: str, colour: str, size: float) -> None:
    curve, whole = found.curves[response], found.whole_band(response)
    if curve.half is None or whole is None or curve.half_band is None:
        return
    control = {name: found.control.summary[key] for name, key, _, _ in PANELS}[response]
    fine = np.geomspace(found.concentrations[0], found.concentrations[-1], 300)
    axes.plot(fine / size, control * curve.at(fine), color=colour, linewidth=1.2)
    low, high = found.concentrations[0], found.concentrations[-1]
    if whole[1] >= low and whole[0] <= high:  # bands beyond the axis would stretch it
        span = (max(whole[0], low) / size, min(whole[1], high) / size)
        axes.axvspan(*span, color=style.GREY, alpha=0.15, linewidth=0.0, label="with range of IC50")
    if low <= curve.half <= high:
        axes.axvline(curve.half / size, color=colour, linestyle="--", linewidth=1.0, label=f"EC50 {amount(curve.half)}")
