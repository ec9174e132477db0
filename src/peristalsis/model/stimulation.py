"""What is brought to the cells over a step: pulses, the trigger, nerves, gap currents, the pacemaker cell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..control.graded import answer
from ..control.pulses import add_pulses, covered, covered_around
from ..control.sequence import add_trigger_current
from .model import Model, Network
from .state import State

Floats = NDArray[np.float64]


@dataclass
class Stimulus:
    """Current at 0 mV [uA/cm^2], inward positive, and conductance [mS/cm^2] added to every cell over a step.

    opened: the largest of the conductances.
    """

    current: Floats
    conductance: Floats
    opened: float = 0.0

    def open(self, conductance: Floats, reversal: Floats | float) -> None:
        """Add a conductance [mS/cm^2] towards a reversal potential [mV]."""
        np.add(self.conductance, conductance, out=self.conductance)
        np.add(self.current, conductance * reversal, out=self.current)
        self.opened = float(self.conductance.max())


class Stimuli(NamedTuple):
    longitudinal: Stimulus
    circular: Stimulus
    pacemaker: Stimulus
    network: Stimulus


def stimuli_of_step(model: Model, state: State, start: float, stop: float) -> Stimuli:
    """Mean stimuli over the step, Eqs. (24)-(26); the layers' have shape (n_z, n_theta), the pacemaker's (1, 1)."""
    grid = model.grid
    shape = (grid.n_z, grid.n_theta_conduction)
    stimuli = Stimuli(*(Stimulus(np.zeros(size), np.zeros(size)) for size in (shape, shape, (1, 1), shape)))
    along, around = model.longitudinal.response, model.circular.response
    for source in state.sources:
        for pulses, response, stimulus in (
            (source.longitudinal, along, stimuli.longitudinal),
            (source.circular, around, stimuli.circular),
        ):
            add_pulses(pulses, grid.cells, grid.cell_size, start, stop, stimulus.current, response.pacemaker)
    for listed, response, stimulus in (
        (model.stimuli_longitudinal, along, stimuli.longitudinal),
        (model.stimuli_circular, around, stimuli.circular),
    ):
        now = listed.between(start, stop)
        add_pulses(now, grid.cells, grid.cell_size, start, stop, stimulus.current, response.pacemaker)
    current, response = stimuli.circular.current, model.circular.response
    add_pulses(state.reflex.excitation, grid.cells, grid.cell_size, start, stop, current, response.excitation)
    add_trigger_current(state.trigger, start, stop, current, response.trigger)
    if state.reflex.inhibition:
        inhibition = np.zeros(shape)
        add_pulses(state.reflex.inhibition, grid.cells, grid.cell_size, start, stop, inhibition, response.inhibition)
        stimuli.circular.open(inhibition, model.circular.cell.inhibition(model.circular.constants))
    if state.reflex.receptors is not None:
        _excite(model, state, start, stop, stimuli)
    if model.network is not None and state.network is not None:
        _couple(model.network, state, state.network.potential, stimuli)
    if model.pacemaker_cell is not None:
        # Each side sees the other's potential of the step before and its own of now: stable at any coupling.
        cell = model.pacemaker_cell
        edge = 0.5 * grid.cell_size
        places = covered(grid.cells - edge, grid.cells + edge, cell.place, cell.place + cell.width)
        columns = covered_around(grid.n_theta_conduction, cell.angle, cell.sector)
        where = places[:, None] * columns * model.longitudinal.response.pacemaker
        reached = float(where.sum())
        if reached > 0.0:  # a region may cut the cell off from all of the tissue
            stimuli.longitudinal.open(cell.coupling * where, float(state.pacemaker.potential[0, 0]))
            mean = float((where * state.longitudinal.potential).sum() / reached)
            stimuli.pacemaker.open(np.full((1, 1), cell.coupling), mean)
    return stimuli


def _excite(model: Model, state: State, start: float, stop: float, stimuli: Stimuli) -> None:
    """What the receptors of the graded reflex bring, Eqs. (121), (122)."""
    assert state.reflex.receptors is not None
    reflex, grid = model.reflex, model.grid
    brought = answer(reflex, state.reflex.receptors, grid.nodes, grid.cells, start, stop)
    if brought is None:
        return
    around = model.circular.response
    stimuli.longitudinal.current += reflex.gain * reflex.longitudinal_intensity * brought.longitudinal[:, None]
    excitation = reflex.gain * reflex.excitation_intensity * brought.excitation[:, None]
    stimuli.circular.current += excitation * around.excitation
    inhibition = reflex.gain * reflex.inhibition_conductance * brought.inhibition[:, None] * around.inhibition
    reversal = model.circular.cell.inhibition(model.circular.constants)
    stimuli.circular.open(np.broadcast_to(inhibition, stimuli.circular.conductance.shape), reversal)


def _couple(network: Network, state: State, potential: Floats, stimuli: Stimuli) -> None:
    """Gap currents between the network and both layers, Eq. (77): each side sees the other's potential of before."""
    for gap, muscle, stimulus in (
        (network.longitudinal, state.longitudinal, stimuli.longitudinal),
        (network.circular, state.circular, stimuli.circular),
    ):
        if gap > 0.0:
            conductance = np.full_like(potential, gap)
            stimulus.open(conductance, potential)
            stimuli.network.open(network.load * conductance, muscle.potential)
