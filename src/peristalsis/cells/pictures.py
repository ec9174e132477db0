"""What a run of one cell leaves behind: a table and a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .description import Description, Floats
from .single import Trace


def keep(cell: Description, trace: Trace, folder: Path, reference: Floats | None, solver: str | None) -> list[Path]:
    """Write trace.csv (time, potential, states) and trace.png into a folder. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    table, picture = folder / "trace.csv", folder / "trace.png"
    columns, names = [trace.times, trace.potential, *trace.states], ["time [ms]", "potential [mV]", *trace.names]
    if reference is not None:
        columns.insert(2, reference)
        names.insert(2, f"potential by {solver} [mV]")
    np.savetxt(table, np.array(columns).T, delimiter=",", header=",".join(names), comments="", fmt="%.12g")
    draw(cell, trace, picture, reference, solver)
    return [table, picture]


def draw(cell: Description, trace: Trace, picture: Path, reference: Floats | None, solver: str | None) -> None:
    """Potential, gates and other states against time."""
    from matplotlib.figure import Figure

    gates = cell.module.GATES
    rows = 1 + bool(gates) + bool(len(trace.names) - gates)
    figure = Figure(figsize=(8.0, 2.4 * rows), layout="constrained")
    axes = np.atleast_1d(figure.subplots(rows, 1, sharex=True))
    long = trace.times[-1] > 5000.0
    times = trace.times / 1000.0 if long else trace.times
    axes[0].plot(times, trace.potential, label="this package")
    if reference is not None:
        axes[0].plot(times, reference, "--", label=solver)
        axes[0].legend()
    axes[0].set(ylabel="potential [mV]", title=cell.title)
    groups = [(0, gates, "gates"), (gates, len(trace.names), "other states")]
    shown = [group for group in groups if group[1] > group[0]]
    for axis, (low, high, label) in zip(axes[1:], shown, strict=True):
        for k in range(low, high):
            axis.plot(times, trace.states[k], label=trace.names[k])
        axis.set_ylabel(label)
        axis.legend(fontsize="x-small", ncols=2, loc="center left", bbox_to_anchor=(1.0, 0.5))
    axes[-1].set_xlabel("time [s]" if long else "time [ms]")
    figure.savefig(picture, dpi=110)
