"""Why a potential left the range of its cell's tables: a stimulus, a reversal potential beyond them, or the step."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..tissue.cell import SHIPPED_CELL, Cell
from ..tissue.records import Tables
from .model import Model
from .scheme import Conduction
from .stimulation import Stimulus

Floats = NDArray[np.float64]


class Tissue(NamedTuple):
    """The cells of a sheet as a step takes them: cell, conductances [mS/cm^2], conduction, coefficients of the step."""

    cell: Cell
    conductances: Floats
    conduction: Conduction
    stages: Floats
    tables: Tables
    constants: Any


FINE_STEP = 0.05
"""A conduction step so short [ms] is not what takes a potential out of range: no gate moves by much within it."""


def _overwhelmed(tissue: Tissue, stimulus: Stimulus, gates: Floats, at: int) -> bool:
    """Whether the channels of a cell, as open as they are, carry off less than its stimulus at the end of the range."""
    current = float(stimulus.current.ravel()[at])
    edge = tissue.cell.highest if current > 0.0 else tissue.cell.lowest
    one = slice(at, at + 1)
    flows = tissue.cell.kernels.currents(np.array([edge]), gates[:, one], tissue.conductances[:, one], tissue.constants)
    carried = tissue.constants.kinetics_rate * sum(float(flow[0]) for flow in flows.values())
    carried += float(stimulus.conductance.ravel()[at]) * edge
    return current > max(carried, 0.0) if current > 0.0 else current < min(carried, 0.0)


def why_out_of_range(model: Model, tissue: Tissue, stimulus: Stimulus, field: str, gates: Floats, bad: int) -> str:
    """What takes a potential out of the tables: a stimulus, a reversal potential beyond them, or the step."""
    low, high = tissue.cell.lowest, tissue.cell.highest
    current = stimulus.current.ravel()
    strongest = int(np.argmax(np.abs(current)))
    if current[strongest] != 0.0:
        # Where a cell would end up with every channel open but the fast one, which inactivates: channels that are
        # closed hold it back even less. Currents run at the tissue's rate (20), stimuli do not.
        pull, total = tissue.cell.kernels.standing_current(tissue.conductances[:, strongest], tissue.constants)
        total += float(stimulus.conductance.ravel()[strongest])
        rate = (float(current[strongest]) + pull) / tissue.constants.capacitance  # mV in a ms, from 0 mV
        target = (float(current[strongest]) + pull) / total if total > 0.0 else np.inf
        at = bad if current[bad] != 0.0 else strongest
        too_strong = model.dt_cell <= FINE_STEP and _overwhelmed(tissue, stimulus, gates, at)
        if too_strong or not low < target < high or abs(rate) * model.dt_wall * 1e3 > high - low:
            layer = field.partition(" ")[0]
            names = {
                "longitudinal": "pacemaker.intensity, or the strength of listed stimuli",
                "circular": "trigger.intensity, reflex.excitation_intensity or rings.intensity",
            }
            return (
                f"a stimulus of {current[at if too_strong else strongest]:.4g} uA/cm^2 drives the cells there, beyond "
                f"what their channels carry off; lower {names.get(layer, 'pacemaker.cell_coupling')}"
            )
    for name, value in tissue.constants._asdict().items():
        if name.endswith("_reversal") and not low < value < high:
            section = "cell" if tissue.cell is SHIPPED_CELL else f"tissue.{tissue.cell.name}"
            return f"{section}.{name} = {value:g} mV pulls it there; bring it into that range"
    return f"the conduction step of {model.dt_cell:g} ms is too large; lower step.conduction"
