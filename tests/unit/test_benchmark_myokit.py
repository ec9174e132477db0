"""The comparison with Myokit, with a stand-in for Myokit: what it is handed, and what is made of its answers."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks import myokit_cable
from benchmarks.clock import Spent
from benchmarks.myokit_cable import MODEL, PULSE, Cable, _difference, _speeds, compare
from peristalsis.model.model import ACTIVATION_LEVEL

Floats = NDArray[np.float64]


class Simulation1d:
    """What the bench asks of Myokit's simulation, and remembers."""

    made: ClassVar[list[Simulation1d]] = []

    def answer(self, times: Floats, cell: int) -> Floats:
        """Potential of a cell at these times [ms]; tests say what it is."""
        raise NotImplementedError

    def __init__(self, model: str, protocol: Protocol, ncells: int, rl: bool) -> None:
        self.model, self.protocol, self.cells, self.rl = model, protocol, ncells, rl
        self.runs: list[float] = []
        Simulation1d.made.append(self)

    def set_step_size(self, step: float) -> None:
        self.step = step

    def set_paced_cells(self, cells: int) -> None:
        self.paced = cells

    def set_conductance(self, conductance: float) -> None:
        self.conductance = conductance

    def reset(self) -> None:
        self.runs.append(0.0)

    def run(self, duration: float, log: Any, log_interval: float = 1.0) -> dict[Any, Floats] | None:
        self.runs.append(duration)
        if log is None:
            return None
        times = np.arange(0.0, duration, log_interval)
        answers = {("membrane.V", k): self.answer(times, k) for k in range(self.cells)}
        return {"engine.time": times, **answers}


class Protocol:
    """A stimulus: level, start, length."""

    def schedule(self, *pulse: float) -> None:
        self.pulse = pulse


@pytest.fixture(autouse=True)
def stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    myokit = SimpleNamespace(
        Protocol=Protocol, Simulation1d=Simulation1d, parse_model=str, LOG_NONE=None, __version__="9.9"
    )
    monkeypatch.setitem(sys.modules, "myokit", myokit)  # type: ignore[arg-type]
    Simulation1d.made.clear()


def derivatives(text: str) -> dict[str, float]:
    """Every dot(...) of a model in Myokit's language at its initial values, without stimulus."""
    sections: dict[str, dict[str, str]] = {}
    name = ""
    for line in text.splitlines():
        words = line.partition("=")
        if line.startswith("["):
            name = line.strip("[]")
            sections[name] = {}
        elif words[1]:
            sections[name][words[0].strip()] = words[2].partition(" bind ")[0].strip()
    start = {key.partition(".")[2]: float(value) for key, value in sections.pop("model").items()}

    class Names(dict[str, Any]):
        def __missing__(self, key: str) -> Any:
            for part in sections.values():
                if key in part:
                    return value(part[key])
            raise KeyError(key)

    names = Names(start, exp=math.exp, abs=abs, If=lambda test, yes, no: yes if test else no)

    def value(expression: str) -> float:
        plain = expression.replace("^", "**").replace("if(", "If(")
        for part in sections:
            plain = plain.replace(f"{part}.", "")
        return float(eval(plain, {}, names))

    found = [(key, text) for part in sections.values() for key, text in part.items() if key.startswith("dot(")]
    return {key[4:-1]: value(expression) for key, expression in found}


def test_model_in_their_language_rests_where_ours_does() -> None:
    """Its equations, read and evaluated here, stand still at the package's state of rest, and move away from it."""
    simulation = Cable(1, 0.1, exact=True).theirs()
    rates = derivatives(simulation.model)
    assert set(rates) == {"V", "h", "n", "x", "c"}
    assert max(abs(rate) for rate in rates.values()) < 1e-9
    line = next(line for line in simulation.model.splitlines() if line.startswith("membrane.V"))
    raised = derivatives(simulation.model.replace(line, "membrane.V = -40.0"))
    assert raised["n"] > 0.0 > raised["h"], "potassium gates open, those of fast calcium close"


@pytest.mark.parametrize("cells", [1, 50])
def test_their_simulation_is_of_the_same_cable(cells: int) -> None:
    cable = Cable(cells, 0.25)
    tissue = replace(cable.model.longitudinal, constants=cable.model.cell._replace(capacitance=1.5))
    cable.model = replace(cable.model, longitudinal=tissue)
    simulation = cable.theirs()
    assert (simulation.cells, simulation.step, simulation.rl) == (cells, 0.25, True)
    assert simulation.protocol.pulse == (1.0, 0.0, PULSE)
    assert "{" not in simulation.model
    assert simulation.model.count("\n") == MODEL.count("\n")
    width = cable.configuration.pacemaker.width
    assert simulation.paced == (1 if cells == 1 else round(width / (10.0 / cells)))
    size = cable.model.grid.cell_size
    per_second = simulation.conductance * size**2 / cable.model.cell.capacitance * 1e3
    assert per_second == pytest.approx(cable.layer.diffusivity)


def test_our_cable_rests_until_the_stimulus_has_come() -> None:
    """The driven end first, the rest in turn; a single cell follows its own stimulus, and no other."""
    cable = Cable(50, 0.25)
    track, first = cable.ours(300.0, 2.0)
    assert track.size == 151
    assert track[0] == cable.rest.potential
    assert track.max() > ACTIVATION_LEVEL
    reached = np.isfinite(first)
    assert 0 < reached.sum() < 50
    assert np.all(reached[:-1] >= reached[1:])
    assert np.all(np.diff(first[cable.driven - 1 :][reached[cable.driven - 1 :]]) > 0.0)
    cable.intensity = 0.0
    still, never = cable.ours(20.0, 2.0)
    assert np.abs(still - cable.rest.potential).max() < 1e-3
    assert np.isnan(never).all()


def test_stimulus_ends_with_its_pulse(monkeypatch: pytest.MonkeyPatch) -> None:
    """A cell follows the same way until then whether it goes on or not, and another one from there."""
    short = Cable(1, 0.25).ours(100.0, 2.0)[0]
    monkeypatch.setattr(myokit_cable, "PULSE", 1000.0)
    long = Cable(1, 0.25).ours(100.0, 2.0)[0]
    steps = round(PULSE / 2.0)
    assert np.array_equal(short[: steps + 1], long[: steps + 1])
    assert np.all(long[steps + 1 :] > short[steps + 1 :])


def test_speed_of_their_wave_is_that_of_the_rise_through_the_level(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every cell rises through the level at z over 4 cm/s, between samples; cells it does not reach do not count."""
    cable = Cable(50, 0.25)
    z = cable.model.grid.cells
    monkeypatch.setattr(Cable, "ours", lambda cable, duration, every: (None, 1e3 * z / 2.5))

    def rising(simulation: Simulation1d, times: Floats, k: int) -> Floats:
        speed = 4.0 if z[k] < 9.0 else 1e-9
        return ACTIVATION_LEVEL + 3.0 * (times - 1e3 * z[k] / speed)

    monkeypatch.setattr(Simulation1d, "answer", rising)
    ours, theirs = _speeds(cable, cable.theirs())
    assert ours == pytest.approx(2.5)
    assert theirs == pytest.approx(4.0)


@pytest.fixture
def first_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """A potential that is ours and an error in proportion to the step: 30 mV/ms, falling off with time."""
    resting = Cable(1, 0.005, exact=True).rest.potential
    monkeypatch.setattr(
        Cable, "ours", lambda cable, duration, every: (np.full(round(duration / every) + 1, resting), np.zeros(1))
    )

    def answer(simulation: Simulation1d, times: Floats, k: int) -> Floats:
        return resting + 30.0 * simulation.step * np.exp(-times / 500.0)

    monkeypatch.setattr(Simulation1d, "answer", answer)


def test_difference_is_the_largest_over_the_samples(first_order: None) -> None:
    largest, difference = _difference(0.02)
    assert largest == pytest.approx(0.6)
    assert difference == pytest.approx(0.6 * np.exp(-np.arange(1501) / 500.0))


@pytest.mark.parametrize("full", [False, True])
def test_comparison(first_order: None, monkeypatch: pytest.MonkeyPatch, full: bool) -> None:
    """In turns: Myokit 8 s, tables 2 s, exponentials 4 s; the error halves with the step, and is gone at step zero."""
    costs = iter([8.0, 2.0, 4.0] * 3)

    def once(call: Callable[[], object]) -> Spent:
        call()
        return Spent(99.0, next(costs))

    monkeypatch.setattr(myokit_cable, "once", once)
    monkeypatch.setattr(myokit_cable, "_speeds", lambda cable, simulation: (5.0, 6.0))
    found = compare(3, full)
    assert (found["ratio"], found["ratio_exact"], found["version"]) == (4.0, 2.0, "9.9")
    assert found["duration"] == (1600.0 if full else 400.0)
    node_steps = found["cells"] * found["duration"] / found["step"]
    costs_and_speeds = [row[1:] for row in found["cable"]]
    ours, theirs = (5.0, 6.0) if full else (None, None)
    assert costs_and_speeds == [[2e9 / node_steps, ours], [4e9 / node_steps, ours], [8e9 / node_steps, theirs]]
    assert Simulation1d.made[0].runs == [0.0, found["duration"]] * 3, "each time from the start"
    assert [pair[1] / pair[0] for pair in found["agreement"]] == pytest.approx([30.0] * 4)
    assert found["extrapolated"] == pytest.approx(0.0, abs=1e-12)
