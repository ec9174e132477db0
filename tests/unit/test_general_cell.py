"""Cells from descriptions: the sheet's kernels follow an independent solution of the same equations, second order."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import peristalsis
from peristalsis.numerics.binding import Binding, bind
from peristalsis.numerics.stabilised import coefficients
from peristalsis.tissue.records import Brought, SheetArrays, Steps, Tables

CELLS = Path(peristalsis.__file__).parent / "tissue" / "cells"
Floats = NDArray[np.float64]

NAMES = ("hodgkin_huxley", "morris_lecar", "fitzhugh_nagumo")
SOME = ["fitzhugh_nagumo", *(pytest.param(name, marks=pytest.mark.slow) for name in NAMES[:2])]
"""Each cell is a set of kernels to compile, which takes half a minute where none is cached: one in the quick tests."""
DRIVE = {"hodgkin_huxley": 10.0, "morris_lecar": 100.0, "fitzhugh_nagumo": 16.0}
"""Stimulus [uA/cm^2] under which the cell fires again and again."""
STEP = {"hodgkin_huxley": 0.02, "morris_lecar": 0.2, "fitzhugh_nagumo": 0.2}
SPAN = {"hodgkin_huxley": 20.0, "morris_lecar": 120.0, "fitzhugh_nagumo": 60.0}


def bound(name: str) -> Binding:
    return bind({"tissue.cells.plant": CELLS / "general.py", "tissue.cells.hodgkin_huxley": CELLS / f"{name}.py"})


def constants_of(cell: ModuleType) -> Any:
    return cell.CellConstants(*(one.value for one in cell.PARAMETERS))


def channels_of(cell: ModuleType) -> Floats:
    return np.array([[one.value] for one in cell.CONDUCTANCES])


def rates(cell: ModuleType, v: float, states: Floats, drive: float) -> list[float]:
    """Right-hand side written with the description's functions and none of the kernels."""
    column, channels = states.reshape(-1, 1), channels_of(cell)
    row, instants = np.zeros(2 * cell.GATES + 1), np.zeros((max(cell.INSTANT, 1), 1))
    cell.gates(v, constants_of(cell), row)
    cell.instant(v, constants_of(cell), instants[:, 0])
    ionic = cell.current(v, column, channels, instants, 0, constants_of(cell))
    others = np.zeros(2 * (len(states) - cell.GATES) + 1)
    cell.others(v, column, channels, 0, constants_of(cell), others)
    gating = [row[2 * g + 1] * (row[2 * g] - states[g]) for g in range(cell.GATES)]
    rest = [others[2 * s] - others[2 * s + 1] * states[cell.GATES + s] for s in range(len(states) - cell.GATES)]
    return [(drive - ionic) / constants_of(cell).capacitance, *gating, *rest]


def traced(name: str, dt: float, exact: bool = False) -> Floats:
    """Potential at every multiple of the coarsest step, by the sheet."""
    binding = bound(name)
    kernels, cell, sheet = (
        binding.module(f"tissue.{part}") for part in ("cells.plant", "cells.hodgkin_huxley", "sheet")
    )
    tables = kernels.gate_table(dt, constants_of(cell)), kernels.gate_table(0.5 * dt, constants_of(cell))
    v, states = np.full(1, -60.0), np.full((len(cell.STATES), 1), 0.2)
    channels, unset = channels_of(cell), np.full(1, np.nan)
    found = []
    for _ in range(round(SPAN[name] / STEP[name])):
        code = sheet.advance_sheet(
            SheetArrays(v, states, unset, unset.copy()),
            channels,
            np.zeros(0),
            Brought(np.full(1, DRIVE[name]), np.zeros(1)),
            Steps(0.0, dt, round(STEP[name] / dt), 1, exact, 0.0),
            coefficients(4),
            Tables(*tables),
            constants_of(cell),
        )
        assert code == -1
        found.append(v[0])
    return np.array(found)


def reference(name: str) -> Floats:
    cell = bound(name).module("tissue.cells.hodgkin_huxley")
    times = STEP[name] * np.arange(1, round(SPAN[name] / STEP[name]) + 1)
    start = [-60.0, *[0.2] * len(cell.STATES)]
    solved = solve_ivp(
        lambda t, y: rates(cell, y[0], y[1:], DRIVE[name]),
        (0.0, times[-1] + 1e-9),
        start,
        method="LSODA",
        rtol=1e-10,
        atol=1e-10,
        t_eval=times,
    )
    return np.asarray(solved.y[0])


@pytest.mark.parametrize("name", SOME)
def test_trace_converges_with_second_order(name: str) -> None:
    expected = reference(name)
    assert np.ptp(expected) > 50.0, "it fires"
    coarse, fine = (np.abs(traced(name, STEP[name] / parts) - expected).max() for parts in (4, 8))
    assert abs(np.log2(coarse / fine) - 2.0) < 0.25
    assert fine < 0.01 * np.ptp(expected)


@pytest.mark.parametrize("name", SOME)
def test_tables_stand_for_the_formulas(name: str) -> None:
    assert np.abs(traced(name, STEP[name] / 4, exact=True) - traced(name, STEP[name] / 4)).max() < 1e-3


@pytest.mark.slow
def test_two_cells_live_in_one_process() -> None:
    """Each is still itself after the other was bound and run."""
    alone = traced(NAMES[0], STEP[NAMES[0]])
    other = traced(NAMES[1], STEP[NAMES[1]])
    assert np.array_equal(traced(NAMES[0], STEP[NAMES[0]]), alone)
    assert abs(np.ptp(alone) - np.ptp(other)) > 5.0
