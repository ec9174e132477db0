"""What would make runs slower unseen: operations of the hot kernels, kernels left out of the warm-up, memory of a step.

Counts and ratios within one process only; seconds are `python -m benchmarks`'s.
"""

from __future__ import annotations

import json
import tracemalloc
from collections.abc import Mapping

import pytest

from benchmarks import kernels
from benchmarks.clock import in_turns
from benchmarks.process import code
from benchmarks.runs import Counter
from benchmarks.sections.roofline import COUNT
from peristalsis import scenarios
from peristalsis.running.simulation import Simulation

Counts = Mapping[str, Mapping[str, float]]


@pytest.fixture(scope="module")
def counts() -> Counts:
    """Operations of every hot kernel for a cell and step, or a node and call."""
    found: Counts = json.loads(code(COUNT, {"NUMBA_DISABLE_JIT": "1"}).output)
    return found


@pytest.mark.parametrize(
    ("kernel", "arithmetic", "slow", "accesses"),
    [  # measured: 41, 0, 25; 102, 1, 74; 121, 1, 97; 450, 14, 76; 97, 1, 74; 203, 1, 142
        ("gates", 45, 0.1, 28),
        ("cell", 112, 1.2, 82),
        ("sheet", 132, 1.2, 107),
        ("wall forces", 490, 15, 84),
        ("wall tangent", 107, 1.2, 82),
        ("wall solve", 220, 1.1, 155),
    ],
)
def test_operations_of_hot_kernels(
    counts: Counts, kernel: str, arithmetic: float, slow: float, accesses: float
) -> None:
    """A tenth more than now: additions and multiplications; divisions, roots and functions; loads and stores."""
    n = counts[kernel]
    assert 0.8 * arithmetic < n["add"] + n["multiply"] <= arithmetic, "if there are fewer, lower the bound"
    assert sum(n.get(kind, 0.0) for kind in ("divide", "root", "function")) <= slow
    assert n["load"] + n["store"] <= accesses


def test_solve_waits_for_few_operations(counts: Counts) -> None:
    """The solve is a chain from node to node; measured 14.4 operations a node that wait for one another."""
    assert counts["wall solve"]["depth"] <= 15.0
    assert counts["wall forces"]["depth"] <= 1.0, "nodes do not wait for each other"


def test_tables_are_worth_having() -> None:
    """Measured 8 to 10 times; below 3 the loop over the table is no longer what it was."""
    model = kernels.shipped_model()
    calls = {str(exact): kernels.gates(model, 1000, exact) for exact in (False, True)}
    found = in_turns(calls, repeats=7, least=0.004)
    assert found["True"].least >= 3.0 * found["False"].least


FRESH = """
from benchmarks.census import census
from peristalsis.running.warm_up import warm_up
warm_up(surface={surface})
before = census().ready
from peristalsis import scenarios
from peristalsis.running.simulation import Simulation
changes = {{"grid.n_z": 100, "grid.n_z_wall": 80, "run.duration": "0.04 s", **{changes}}}
Simulation(scenarios.configuration("baseline", changes=changes)).run()
print(before, census().ready)
"""


@pytest.mark.parametrize(
    "changes",
    [{}, {"grid.n_theta": 8}, {"grid.n_theta": 8, "pacemaker.angular_width": "90 deg", "pellet.sideways": "free"}],
    ids=["one column", "ring-uniform", "point source"],
)
def test_runs_compile_nothing_that_the_warm_up_has_not(changes: dict[str, object]) -> None:
    """Or every process of a batch would compile it for itself, and a run would count it as time of the solver."""
    before, after = map(int, code(FRESH.format(surface="grid.n_theta" in changes, changes=changes)).output.split())
    assert before > 20
    assert after == before


def test_ring_uniform_steps_need_few_iterations() -> None:
    """The axisymmetric step of the mean is the solution there; what is left has its exact tangent."""
    counter = Counter()
    changes = {"grid.n_z": 100, "grid.n_z_wall": 80, "grid.n_theta": 8}
    simulation = Simulation(scenarios.configuration("baseline", changes=changes), (counter,))
    simulation.advance("0.04 s")
    assert simulation.state.step == round(0.04 / simulation.model.dt_wall)
    assert counter.newton <= simulation.state.step
    assert counter.krylov <= 2 * counter.newton


def test_point_source_needs_few_iterations() -> None:
    """Measured 7.8 Newton iterations a step and 12 Krylov iterations for each; a worse preconditioner takes more."""
    counter = Counter()
    changes = {"grid.n_z": 100, "grid.n_z_wall": 80, "grid.n_theta": 8, "pacemaker.angular_width": "90 deg"}
    simulation = Simulation(scenarios.configuration("baseline", changes=changes), (counter,))
    simulation.advance("0.1 s")
    steps = simulation.state.step
    assert 1.0 < counter.newton / steps <= 9.0
    assert 1.0 < counter.krylov / counter.newton <= 16.0


def test_step_holds_little_memory() -> None:
    """Beside the states before and after it: measured 0.56 of a checkpoint at the most, and nothing stays."""
    simulation = Simulation(scenarios.configuration("baseline", changes={"grid.n_z": 400, "grid.n_z_wall": 320}))
    simulation.advance("20 ms")
    state = len(simulation.checkpoint())
    from peristalsis.model.guards import advance_safely

    model, before = simulation.model, simulation.state
    after, _ = advance_safely(model, before)
    tracemalloc.start()
    try:
        for _ in range(3):
            advance_safely(model, after)
        most, stays = tracemalloc.get_traced_memory()[1], _in_arrays()
        for _ in range(20):
            advance_safely(model, after)
        stays_later = _in_arrays()
    finally:
        tracemalloc.stop()
    assert most <= 0.9 * state
    assert stays_later - stays <= 0.01 * state


def _in_arrays() -> int:
    """Bytes traced in pieces as large as an array of nodes; small ones are numba's, which keeps some for reuse."""
    return sum(trace.size for trace in tracemalloc.take_snapshot().traces if trace.size >= 1000)
