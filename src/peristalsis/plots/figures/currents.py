"""Potential, ion currents and calcium at a probe, in both layers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...errors import ConfigurationError
from ...inputs.parts import SHIPPED
from .. import data, style
from ..data import Floats
from ..figure import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from ...results.result import Result

LAYERS = ("longitudinal", "circular")
LARGE = {
    "fast_calcium": (r"fast Ca$^{2+}$", style.VERMILION),
    "potassium": (r"delayed K$^{+}$", style.BLUE),
}
SMALL = {
    "slow_calcium": (r"slow Ca$^{2+}$", style.ORANGE),
    "calcium_potassium": (r"Ca$^{2+}$-activated K$^{+}$", style.SKY),
    "leak": (r"leak Cl$^{-}$", style.GREEN),
}


def currents_at(result: Result, layer: str, probe: int = 0) -> dict[str, Floats]:
    """The currents of a layer at a probe [uA/cm^2] at every step, before the tissue's rate factor.

    With the conductances that the model had there and then: regions and protocols change them.
    """

    from ...inputs.build import cell_of_layer

    cell, constants, _ = cell_of_layer(result.configuration, layer)
    potential = data.values(result, f"potential_{layer}_probe")[:, probe]
    states = np.stack(list(states_at(result, layer, cell.states, probe).values()))
    recorded = [data.values(result, f"conductance_{name}_{layer}_probe")[:, probe] for name in cell.channels]
    found: dict[str, Floats] = cell.kernels.currents(potential, states, np.stack(recorded), constants)
    return found


def states_at(result: Result, layer: str, names: Sequence[str], probe: int = 0) -> dict[str, Floats]:
    """States of the cells of a layer at a probe at every step."""
    plants = result.configuration.cell_of(layer) == SHIPPED["cell"]
    return {
        name: data.values(result, f"{'calcium' if plants and name == 'c' else name}_{layer}_probe")[:, probe]
        for name in names
    }


def _draw_any(result: Result, probe: int, figure: Canvas) -> Canvas:
    """Traces of cells of any kind: potential, every current, every state."""
    from ...inputs.build import cell_of_layer

    grid = figure.subplots(3, 2, sharex=True)
    time = data.values(result, "time_step")
    for side, layer in enumerate(LAYERS):
        cell, _, _ = cell_of_layer(result.configuration, layer)
        potential, flows, states = grid[:, side]
        potential.plot(time, data.values(result, f"potential_{layer}_probe")[:, probe], color=style.BLACK)
        threshold = data.values(result, f"threshold_{layer}")
        potential.plot(time, threshold, color=style.GREY, linewidth=0.9, linestyle=":")
        flows.axhline(0.0, color=style.GREY, linewidth=0.6)
        for name, values in currents_at(result, layer, probe).items():
            flows.plot(time, values, label=name.replace("_", " "))
        for name, values in states_at(result, layer, cell.states, probe).items():
            largest = float(np.abs(values).max())
            scale = 1.0 if 0.02 < largest <= 2.0 else 10.0 ** np.floor(np.log10(largest)) if largest > 0.0 else 1.0
            label = name.replace("_", " ") + ("" if scale == 1.0 else f" / {scale:g}")
            states.plot(time, values / scale, label=label)
        style.time_axis(states, result)
        style.legend_above(flows)
        style.legend_above(states)
    for row, label in enumerate(("potential (mV)", "current (µA/cm²)", "states of the cell")):
        grid[row, 0].set_ylabel(label)
    style.letters(list(grid[0]), [f"{layer} muscle" for layer in LAYERS])
    figure.align_ylabels(grid[:, 0])
    return figure


def draw(result: Result, probe: int = 0) -> Canvas:
    """Traces at probe number `probe` of output.probes."""
    places = data.values(result, "probe", "mm")
    if not 0 <= probe < places.size:
        raise ConfigurationError(
            f"probe = {probe}: this run has {places.size} probes, counted from 0; add places to output.probes"
        )
    figure = style.canvas(result, 8.0, f"Ion currents at z = {places[probe]:.3g} mm")
    if any(result.configuration.cell_of(layer) != SHIPPED["cell"] for layer in LAYERS):
        return _draw_any(result, probe, figure)
    grid = figure.subplots(4, 2, sharex=True, sharey="row")
    time = data.values(result, "time_step")
    flows = {layer: currents_at(result, layer, probe) for layer in LAYERS}
    for side, layer in enumerate(LAYERS):
        potential, large, small, calcium = grid[:, side]
        potential.plot(time, data.values(result, f"potential_{layer}_probe")[:, probe], color=style.BLACK)
        threshold = data.values(result, f"threshold_{layer}")
        potential.plot(time, threshold, color=style.GREY, linewidth=0.9, linestyle=":")
        for axes, group in ((large, LARGE), (small, SMALL)):
            axes.axhline(0.0, color=style.GREY, linewidth=0.6)
            for name, (label, colour) in group.items():
                axes.plot(time, flows[layer][name], color=colour, label=label)
        calcium.plot(time, data.values(result, f"calcium_{layer}_probe")[:, probe], color=style.PURPLE)
        style.time_axis(calcium, result)
    for row, label in enumerate(("potential (mV)", "current (µA/cm²)", "current (µA/cm²)", "calcium (relative)")):
        grid[row, 0].set_ylabel(label)
    calcium_curves = [data.values(result, f"calcium_{layer}_probe")[:, probe] for layer in LAYERS]
    potentials = [data.values(result, f"potential_{layer}_probe")[:, probe] for layer in LAYERS]
    grid[0, 0].set_ylim(style.widened(*data.limits(*potentials, least=20.0)))
    grid[3, 0].set_ylim(style.widened(*data.limits(*calcium_curves, least=0.002)))
    for row, group in ((1, LARGE), (2, SMALL)):
        curves = [flows[layer][name] for layer in LAYERS for name in group]
        grid[row, 0].set_ylim(style.finite_range(*curves, least=0.01))
        style.legend_above(grid[row, 1])
    style.letters(list(grid[0]), [f"{layer} muscle" for layer in LAYERS])
    figure.align_ylabels(grid[:, 0])
    return figure


FIGURE = Figure(
    name="currents",
    title="Ion currents at a probe",
    caption=(
        "Membrane potential (dotted: above this the muscle pulls), the ion currents and intracellular calcium (of "
        "cells other than Plant's: all states) at "
        "one place of the longitudinal (a) and the circular muscle (b). Currents are those of the cell, before the "
        "factor by which the tissue's kinetics are slowed, with the conductances of that place and time; outward is "
        "positive. The stimuli and the inhibition are not among them."
    ),
    draw=draw,
)
