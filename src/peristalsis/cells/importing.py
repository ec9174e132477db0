"""`cell import`: a foreign file read, taken apart, written as a description, and the two compared."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ConfigurationError, PeristalsisError, WriteError, shown
from . import description
from .analysis import Anatomy, analysed
from .description import Description, Floats
from .foreign import read, right_side, simulation
from .writing import Writer, _safe

EQUAL = 1e-8
"""Largest difference of rates, as a share of their size, between a file and the description made of it."""
CLOSE = 1e-3
"""Largest difference of potentials, as a share of their range."""


@dataclass(frozen=True)
class Imported:
    """What an import found. rates, trace: largest differences as shares; solver: of the reference."""

    file: Path
    cell: Description
    anatomy: Anatomy
    rates: float
    trace: float
    solver: str
    duration: float


def import_cell(source: Path, out: Path | None = None, name: str | None = None, duration: float = 1000.0) -> Imported:
    """Make a description `out` of a CellML, SBML or .mmt file and compare it over `duration` [ms].

    Raises ConfigurationError with one sentence where the file is no cell, WriteError where `out` cannot be written.
    """
    anatomy = analysed(read(source))
    chosen = name or _safe(source.stem).lower()
    target = Path(f"{chosen}.py") if out is None else out
    names = [state.qname() for state in anatomy.model.states()]
    times = np.linspace(0.0, duration / anatomy.time_scale, 401)
    course, solver = simulation(anatomy.model, times, names)
    bounds = {n: _bounds(row) for n, row in zip(names, course, strict=True)}
    header = _header(source, anatomy)
    text = Writer(anatomy, chosen, header, bounds).text()
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    except OSError as error:
        raise WriteError(f"could not write {shown(str(target))}: {error.strerror}; choose another place") from None
    cell = description.read(target)
    rates = rates_differ(cell, anatomy, names, course)
    trace = _trace_differs(cell, anatomy, names, times, course)
    if not rates < EQUAL or not trace < CLOSE:
        raise PeristalsisError(
            f"{shown(source.name)} and the description made of it differ: rates by {rates:.1e}, potential by "
            f"{trace:.1e} of its range; {shown(str(target))} is kept to look at, and must not be used"
        )
    return Imported(target, cell, anatomy, rates, trace, solver, duration)


def _bounds(course: Floats) -> tuple[float, float]:
    low, high = float(course.min()), float(course.max())
    size = max(abs(low), abs(high), 1e-12)
    return (0.0 if low >= 0.0 else -100.0 * size), 100.0 * size


def _header(source: Path, cell: Anatomy) -> str:
    title = f"Cell made from {source.name} by `peristalsis cell import`, as a description for `general`."
    lines = [title, "", "Units: mV, ms, mS/cm^2, uA/cm^2; constants keep the units of the file. What was found:"]
    lines += [f"* {remark}" for remark in cell.remarks]
    if cell.stimuli:
        lines.append(f"* stimulus of the file, left out of the cell: {', '.join(cell.stimuli)}")
    named = sum(channel.conductance is not None for channel in cell.channels)
    lines.append(f"* {len(cell.gates)} gates, {len(cell.others)} other states, {len(cell.channels)} currents, of which "
                 f"{named} have a conductance")  # fmt: skip
    return "\n".join(line.replace("\\", "/").replace('"""', "'")[:118] for line in lines) + "\n"


def ordered(cell: Description, anatomy: Anatomy, names: list[str], values: Floats) -> Floats:
    """Values in the order of a foreign model, in the order and units of the description."""
    places = [names.index(anatomy.potential.qname())]
    states = [gate.state for gate in anatomy.gates] + [other.state for other in anatomy.others]
    places += [names.index(state.qname()) for state in states]
    found = values[places].copy()
    found[0] *= anatomy.potential_scale
    return found


def rates_differ(cell: Description, anatomy: Anatomy, names: list[str], course: Floats) -> float:
    """Largest difference of any rate of change on and near the course, as a share of the size of that rate."""
    theirs, ours = right_side(anatomy.model), description.rates(cell)
    chance = np.random.default_rng(5)
    worst = 0.0
    sizes: Floats = np.zeros(course.shape[0])
    pairs = []
    for k in range(0, course.shape[1], 16):
        state = course[:, k] * (1.0 + 0.02 * chance.random(course.shape[0]))
        expected = np.array(theirs(0.0, list(state)))
        expected = ordered(cell, anatomy, names, expected) / anatomy.time_scale
        mine = ordered(cell, anatomy, names, state)
        pairs.append((expected, ours(float(mine[0]), mine[1:], 0.0)))
        sizes = np.maximum(sizes, np.abs(expected))
    for expected, found in pairs:
        with np.errstate(invalid="ignore"):
            worst = max(worst, float(np.nanmax(np.abs(found - expected) / np.maximum(sizes, 1e-300))))
        if not np.all(np.isfinite(found)):
            return float("inf")
    return worst


def _trace_differs(cell: Description, anatomy: Anatomy, names: list[str], times: Floats, course: Floats) -> float:
    from scipy.integrate import solve_ivp

    ours = description.rates(cell)
    at = times * anatomy.time_scale
    begin = ordered(cell, anatomy, names, course[:, 0])
    solved: Any = solve_ivp(lambda t, y: ours(float(y[0]), y[1:], 0.0), (0.0, at[-1] * (1 + 1e-9)), begin,
                            method="LSODA", rtol=1e-8, atol=1e-10, t_eval=at, max_step=at[-1] / 50)  # fmt: skip
    expected = course[names.index(anatomy.potential.qname())] * anatomy.potential_scale
    if solved.y.shape[1] != expected.size:
        raise ConfigurationError(f"the equations of {shown(cell.name)} could not be solved beyond {solved.t[-1]:g} ms")
    return float(np.abs(solved.y[0] - expected).max() / max(float(np.ptp(expected)), 1.0))


def reference_trace(anatomy: Anatomy, times: Floats, pulses: tuple[float, float, float, float]) -> tuple[Floats, str]:
    """Potential [mV] at times [ms] by Myokit's equations under pulses (uA/cm^2, begin, duration, period), and by which
    solver."""
    from .foreign import myokit

    kit = myokit()
    model = anatomy.model.clone()
    intensity, begin, duration, period = pulses
    if intensity != 0.0:
        potential = model.get(anatomy.potential.qname())
        component = model.add_component("stimulus_of_the_comparison")
        time = component.add_variable("now")
        bound = model.time()
        time.set_rhs(kit.Name(bound))
        amount = component.add_variable("amount")
        since = f"stimulus_of_the_comparison.now * {anatomy.time_scale!r} - {begin!r}"
        within = f"({since}) % {period!r}" if period > 0.0 else since
        capacitance = 1.0
        if anatomy.capacitance is not None:
            capacitance = float(anatomy.capacitance.eval()) * anatomy.capacitance_scale
        size = intensity / capacitance * anatomy.time_scale / anatomy.potential_scale
        amount.set_rhs(f"if({since} >= 0 and {within} < {duration!r}, {size!r}, 0)")
        potential.set_rhs(kit.Plus(potential.rhs(), kit.Name(amount)))
    found, solver = simulation(model, times / anatomy.time_scale, [anatomy.potential.qname()])
    return found[0] * anatomy.potential_scale, solver
