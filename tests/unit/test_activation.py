"""Activations chosen by configuration: what drives the muscle, states of its own, what is refused, in which words."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import peristalsis as ps
from peristalsis.errors import ConfigurationError
from peristalsis.inputs import asked, parts
from peristalsis.inputs.build import build
from peristalsis.model.guards import advance_safely, violation
from peristalsis.model.initial import initial_state, straight_state
from peristalsis.model.muscle import advance_muscle, drive_of_cells
from peristalsis.model.schemes.column import muscle_drive, trigger_force
from peristalsis.model.state import State
from peristalsis.storing.packing import pack, unpack
from peristalsis.tissue.activation import SHIPPED_ACTIVATION, activation_of
from peristalsis.wall.active import active_tension
from verification.exact.orders import observed_orders

TINY = {"grid.n_z": 50, "grid.n_z_wall": 60, "run.duration": "60 ms", "output.interval": "20 ms"}
STOMACH = {"tissue.cell": "corrias_buist_2007", "pacemaker.intensity": "3 uA/cm^2"}
CALCIUM = 12
"""Row of calcium among the states of the gastric muscle."""
DECLARED = {one.name: one.value for one in parts.find("activation", "hai_murphy").parameters}


def configured(**changes: Any) -> ps.Configuration:
    return ps.configuration(changes={**TINY, **{name.replace("__", "."): value for name, value in changes.items()}})


def kernels(name: str) -> Any:
    return activation_of(name, parts.find("activation", name).file).kernels


def bridges(**changes: float) -> Any:
    return kernels("hai_murphy").ActivationConstants(**{**DECLARED, **changes})


def rates(calcium: float, c: Any) -> np.ndarray:
    """The matrix of Eq. (80), written once more: columns are the states M, Mp, AMp, AM that are left."""
    k1 = c.fastest * calcium**c.exponent / (c.half**c.exponent + calcium**c.exponent)
    k2, k3, k4, k7 = c.dephosphorylation, c.attachment, c.detachment, c.latch_detachment
    return np.array(
        [
            [-k1, k2, 0.0, k7],
            [k1, -(k2 + k3), k4, 0.0],
            [0.0, k3, -(k4 + k2), k1],
            [0.0, 0.0, k2, -(k1 + k7)],
        ]
    )


# --- Hill's curve -----------------------------------------------------------------------------------


def test_half_of_the_drive_at_half_of_the_calcium() -> None:
    hill = kernels("calcium_hill")
    c = hill.ActivationConstants(half=0.3, exponent=3.0, full=20.0, calcium_unit=1.0)
    calcium = np.array([-1.0, 0.0, 0.15, 0.3, 0.6, 1e300])
    out = np.empty(calcium.size)
    hill.drive_of_cells(calcium, calcium, 1.0, np.empty((0, 0)), c, out)
    assert out == pytest.approx([0.0, 0.0, 20.0 / 9.0, 10.0, 20.0 * 8.0 / 9.0, 20.0], rel=1e-14)


def test_calcium_is_read_in_the_unit_of_its_cell() -> None:
    """0.4 uM is 0.0004 of the stomach's mM, and 0.8 of Plant's numbers where 1 stands for 0.5 uM."""
    for changes, state, value in (
        ({**STOMACH}, CALCIUM, 0.0004),
        ({"tissue.calcium_hill.calcium_unit": "500 nM"}, 3, 0.8),
    ):
        model = build(configured(**{"tissue.activation": "calcium_hill", **changes}))
        sheet = straight_state(model).circular
        gates = sheet.gates.copy()
        gates[state] = value
        driven = drive_of_cells(model.circular, replace(sheet, gates=gates))
        assert driven == pytest.approx(20.0, rel=1e-13)


def test_factors_on_force_multiply_any_drive_and_the_trigger_reads_it_before_them() -> None:
    """On a column and on the surface; the region weakens both layers to 0.25 of twice."""
    band = {"name": "weak", "shape": "band", "z_from": "0 cm", "z_to": "10 cm", "active": 0.25}
    for columns in (1, 8):
        model = build(
            configured(
                **STOMACH,
                tissue__activation="calcium_hill",
                longitudinal__active=2.0,
                regions=[band],
                grid__n_theta=columns,
            )
        )
        state = straight_state(model)
        gates = state.longitudinal.gates.copy()
        gates[CALCIUM] = 0.0004
        sheet = replace(state.longitudinal, gates=gates)
        assert muscle_drive(model, model.longitudinal, sheet) == pytest.approx(10.0, rel=1e-12)
        assert muscle_drive(model, model.circular, state.circular) == pytest.approx(0.0, abs=0.05), "at rest"
        along = active_tension(1.0, model.wall.longitudinal)[0]
        assert trigger_force(model, sheet, state.wall) == pytest.approx(20.0 * along, rel=1e-9)


# --- cross-bridges ----------------------------------------------------------------------------------


@pytest.mark.parametrize("calcium", [0.0, 0.05, 0.3, 0.4, 5.0])
def test_bridges_stay_in_their_steady_state(calcium: float) -> None:
    c, states = bridges(), np.zeros((4, 1))
    kernels("hai_murphy").set_steady(np.array([calcium]), 1.0, c, states)
    assert states.sum() == pytest.approx(1.0, rel=1e-15)
    assert (states >= 0.0).all()
    assert np.abs(rates(calcium, c) @ states).max() < 1e-16


@pytest.mark.parametrize("dt", [0.002, 0.3, 1.0, 60.0])
def test_a_step_at_constant_calcium_is_the_matrix_exponential(dt: float) -> None:
    """Whatever its length: the rates do not change, so nothing is left to converge but rounding."""
    c = bridges(fastest=3.0)
    states = np.array([[0.7], [0.1], [0.15], [0.05]])
    calcium = np.array([0.5])
    expected = expm(dt * rates(0.5, c)) @ states
    kernels("hai_murphy").advance_states(calcium, calcium, 1.0, dt, c, states)
    assert np.abs(states - expected).max() < 5e-14
    assert states.sum() == pytest.approx(1.0, abs=2e-14)


def test_a_step_in_changing_calcium_is_of_second_order() -> None:
    """Against a stiff solver to 1e-12, over three seconds in which calcium goes up and down."""
    c = bridges(fastest=3.0)
    start = np.array([0.9, 0.05, 0.03, 0.02])

    def calcium(t: float) -> float:
        return 0.45 + 0.35 * np.sin(2.0 * t)

    exact = solve_ivp(lambda t, y: rates(calcium(t), c) @ y, (0.0, 3.0), start, method="LSODA", rtol=1e-12, atol=1e-14)
    sizes, errors = [], []
    for steps in (12, 24, 48, 96):
        states, dt = start[:, None].copy(), 3.0 / steps
        for k in range(steps):
            ends = np.array([calcium(k * dt)]), np.array([calcium((k + 1) * dt)])
            kernels("hai_murphy").advance_states(*ends, 1.0, dt, c, states)
        sizes.append(dt)
        errors.append(float(np.abs(states[:, 0] - exact.y[:, -1]).max()))
    assert observed_orders(sizes, errors)[-1] == pytest.approx(2.0, abs=0.1)
    assert errors[-1] < 1e-4


def test_shares_stay_shares_at_any_rate_and_step() -> None:
    """Rates over eight decades, steps up to a second: nothing leaves 0...1, and the sum stays."""
    rng = np.random.default_rng(3)
    for _ in range(200):
        fast = 10.0 ** rng.uniform(-4.0, 4.0, 5)
        names = ("fastest", "dephosphorylation", "attachment", "detachment", "latch_detachment")
        c = bridges(**dict(zip(names, fast.tolist(), strict=True)))
        states = rng.dirichlet(np.ones(4))[:, None]
        ends = rng.uniform(0.0, 2.0, (2, 1))
        kernels("hai_murphy").advance_states(ends[0], ends[1], 1.0, float(10.0 ** rng.uniform(-3, 0)), c, states)
        assert (states >= 0.0).all()
        assert states.sum() == pytest.approx(1.0, abs=1e-12)


def test_force_is_held_by_latched_bridges_while_phosphorylation_falls() -> None:
    """Ten seconds after calcium is gone a tenth is phosphorylated of what was, and four fifths of the force is left."""
    c, kernel = bridges(), kernels("hai_murphy")
    states = np.zeros((4, 1))
    kernel.set_steady(np.array([2.0]), 1.0, c, states)
    before = states.copy()
    low = np.array([0.0])
    for _ in range(1000):
        kernel.advance_states(low, low, 1.0, 0.01, c, states)
    phosphorylated = (states[1] + states[2]) / (before[1] + before[2])
    attached = (states[2] + states[3]) / (before[2] + before[3])
    assert phosphorylated < 0.1
    assert attached > 0.8


def test_cells_begin_with_their_muscle_at_rest_and_stay_there() -> None:
    configuration = configured(tissue__activation="hai_murphy", pacemaker__kind="none", **{"tissue.cell": "plant"})
    model, state, remarks = initial_state(build(configuration))
    assert state.circular.muscle.shape == (4, 50, 1)
    assert any("by circular.activation = hai_murphy its muscle has a drive of up to 23 mV" in one for one in remarks)
    after = advance_muscle(model.circular, state.circular, state.circular, 1.0)
    assert np.abs(after.muscle - state.circular.muscle).max() < 1e-15


def test_a_run_goes_on_from_its_bytes_to_the_same_bits() -> None:
    model, state, _ = initial_state(build(configured(tissue__activation="hai_murphy", **STOMACH)))
    for _ in range(10):
        state, _ = advance_safely(model, state)
    again = unpack(pack({"state": (state, State)}), {"state": State})["state"]
    for _ in range(10):
        state, _ = advance_safely(model, state)
        again, _ = advance_safely(model, again)
    assert np.array_equal(state.longitudinal.muscle, again.longitudinal.muscle)
    assert np.array_equal(state.wall.position, again.wall.position)
    assert np.ptp(state.longitudinal.muscle[1]) > 1e-6, "calcium has moved the bridges at the oral end"
    assert state.longitudinal.muscle.sum(axis=0) == pytest.approx(1.0, abs=1e-14)


def test_a_share_out_of_its_bounds_is_named() -> None:
    model = build(configured(circular__activation="hai_murphy"))
    state = straight_state(model)
    assert state.longitudinal.muscle.shape == (0, 50, 1), "the other layer has none"
    muscle = state.circular.muscle.copy()
    muscle[3, 20, 0] = -1e-6
    bad = replace(state, circular=replace(state.circular, muscle=muscle))
    assert violation(model, state) is None
    assert violation(model, bad) == "circular muscle am is -1e-06 at z = 4.1 cm,"


# --- choosing ---------------------------------------------------------------------------------------


def test_the_shipped_activation_is_bound_to_nothing() -> None:
    model = build(configured(tissue__activation="depolarisation"))
    assert model.circular.activation is SHIPPED_ACTIVATION
    assert model.circular.activation_constants == (-55.0,)


def test_each_layer_has_its_own_activation_and_numbers() -> None:
    model = build(
        configured(
            tissue__activation="calcium_hill",
            circular__activation="hai_murphy",
            longitudinal__calcium_hill__half="100 nM",
            circular__hai_murphy__full="30 mV",
        )
    )
    assert (model.longitudinal.activation.name, model.circular.activation.name) == ("calcium_hill", "hai_murphy")
    assert model.longitudinal.activation_constants.half == pytest.approx(0.1)
    assert model.circular.activation_constants.full == 30.0


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "no calcium": (
        {"tissue.cell": "morris_lecar", "tissue.activation": "calcium_hill"},
        "morris_lecar of the layer has no calcium; use depolarisation, or .*: corrias_buist_2007, du_2013, plant",
    ),
    "explicit": (
        {"circular.activation": "hai_murphy", "solver.integrator": "explicit"},
        "the explicit scheme has the activation of the paper only",
    ),
    "not chosen": ({"tissue.calcium_hill.half": "1 uM"}, r"set tissue\.activation = calcium_hill"),
    "no such": ({"circular.activation": "calcium"}, r"circular\.activation = 'calcium' is no activation"),
    "no unit": ({"tissue.activation": "calcium_hill", "tissue.calcium_hill.half": 1.0}, "unit is missing"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_is_refused_in_a_sentence(case: str) -> None:
    changes, words = REFUSED[case]
    with pytest.raises(ConfigurationError, match=words) as caught:
        configured(**changes)
    assert "\n" not in str(caught.value)


def test_a_threshold_without_effect_is_told() -> None:
    said = list(asked.remarks(configured(circular__activation="calcium_hill", circular__threshold="-50 mV")))
    assert "circular.threshold is set and has no effect: circular.activation = calcium_hill" in said


# --- from outside of the package --------------------------------------------------------------------

OWN = """
from typing import NamedTuple
from peristalsis.declared import number
from peristalsis.numerics.compiled import inlined

KIND, NAME, TITLE = "activation", "own_threshold", "the paper's, from outside"
PARAMETERS = (number("level", -55.0, "mV", "potential from which on muscle pulls", lowest=-100.0, highest=0.0),)

class ActivationConstants(NamedTuple):
    level: float

@inlined
def drive(potential, calcium, states, k, c):
    return max(potential - c.level, 0.0)
"""


@pytest.fixture
def register(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], Path]]:
    """Makes a part of a text known, for one test."""
    monkeypatch.setenv(parts.VARIABLE, "")
    monkeypatch.setattr(parts, "_registered", {})

    def one(text: str) -> Path:
        file = tmp_path / "own.py"
        file.write_text(text, encoding="utf-8")
        parts.register(file)
        return file

    yield one
    parts._known.cache_clear()


def test_an_activation_from_outside_gives_the_bits_of_the_paper_s(register: Callable[[str], Path]) -> None:
    register(OWN)
    one = ps.Simulation(configured(tissue__activation="own_threshold")).run().arrays
    other = ps.Simulation(configured()).run().arrays
    assert other["pellet_position"][-1] != other["pellet_position"][0]
    assert all(one[name].tobytes() == other[name].tobytes() for name in other if other[name].dtype.kind == "f")


FAULTS = {
    "broken": ("import nothing_of_this_name\n" + OWN, "cannot be taken up"),
    "nothing": (OWN[: OWN.index("@inlined")], "cannot be taken up"),
    "numbers": (OWN.replace("    level: float", "    other: float"), "PARAMETERS and the fields"),
    "negative": (OWN.replace("max(potential - c.level, 0.0)", "potential - c.level"), "its drive at -100 mV"),
    "formula": (OWN.replace("c.level, 0.0", "c.lavel, 0.0"), "cannot be used"),
    "largest": (OWN + "\ndef largest_drive(highest, c):\n    return 1.0\n", "more than its largest_drive"),
    "states": (OWN + '\nSTATES = (("s", 1.0, 2.0),)\n', r"its state s leaves 1\.\.\.2"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_faulty_activation_is_refused_in_a_sentence(name: str, register: Callable[[str], Path]) -> None:
    text, said = FAULTS[name]
    register(text)
    with pytest.raises(ConfigurationError, match=said) as caught:
        build(configured(tissue__activation="own_threshold"))
    assert "longitudinal.activation = own_threshold" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_cell_has_to_say_in_which_unit_its_calcium_is(register: Callable[[str], Path]) -> None:
    """mM and uM are a thousand apart, and neither is guessed."""
    cell = (parts.PACKAGE / "tissue" / "cells" / "corrias_buist_2007.py").read_text(encoding="utf-8")
    unsaid = cell.replace('NAME, TITLE = "cell", "corrias_buist_2007"', 'NAME, TITLE = "cell", "own_muscle"').replace(
        'CALCIUM_STATE = ("calcium", "mM")', ""
    )
    register(unsaid)
    own = {"tissue.cell": "own_muscle", "tissue.activation": "calcium_hill"}
    with pytest.raises(ConfigurationError, match="own_muscle does not say in which unit its calcium is; write CALCIUM"):
        configured(**own)
    for said, words in (('("calcum", "mM")', "is none of STATES"), ('("calcium", "mg")', "is none of M, mM, uM")):
        with pytest.raises(ConfigurationError, match=words):
            register(unsaid + f"\nCALCIUM_STATE = {said}\n")


def test_a_name_stands_for_one_kind(register: Callable[[str], Path]) -> None:
    """Numbers go by section and name: circular.bell.peak would be of two parts."""
    with pytest.raises(ConfigurationError, match="bell is the name of a muscle already"):
        register(OWN.replace('"own_threshold"', '"bell"'))
