"""An option at its limit gives what the option off gives: pairs of runs that must agree."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.inputs.build import build
from peristalsis.model.balance import _gas_energy
from peristalsis.pellet.friction import FrictionLaw, pressed_part

SMALL: dict[str, Any] = {
    "grid.n_z": 150,
    "grid.n_z_wall": 80,
    "run.duration": "0.6 s",
    "step.wall": "4 ms",
    "step.conduction": "0.5 ms",
    "output.interval": "0.6 s",
}
WALL = {"pellet.friction_frame": "wall"}
FREE = {"pellet.dry_friction": "0 mN"}

PAIRS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "dry friction": (FREE, {"pellet.dry_friction": "1e-12 mN"}),
    "static friction": ({}, {"pellet.static_friction_factor": 1.0 + 1e-12}),
    "friction by pressing, at rest": ({}, {"pellet.friction_coefficient": 1e-12}),
    "friction by pressing, on the wall": (WALL, WALL | {"pellet.friction_coefficient": 1e-12}),
    "friction by pressing alone": (WALL | FREE, WALL | FREE | {"pellet.friction_coefficient": 1e-12}),
    "inertia": ({}, {"wall.inertia": True, "wall.surface_density": "1e-12 mg/cm^2"}),
    "adiabatic exponent 0": ({"lumen.adiabatic_exponent": 0}, {"lumen.adiabatic_exponent": 1e-12}),
    "adiabatic exponent 1": ({"lumen.adiabatic_exponent": 1}, {"lumen.adiabatic_exponent": 1.0 + 1e-11}),
    "reflex": (
        {"reflex.enabled": False},
        {"reflex.excitation_intensity": "1e-12 uA/cm^2", "reflex.inhibition_conductance": "1e-12 mS/cm^2"},
    ),
    "pacemaker": ({"pacemaker.kind": "none"}, {"pacemaker.intensity": "1e-12 uA/cm^2"}),
    "pacemaker cell": ({"pacemaker.kind": "none"}, {"pacemaker.kind": "cell", "pacemaker.cell_coupling": "0 mS/cm^2"}),
    "trigger": ({"trigger.rule": "none"}, {"trigger.intensity": "1e-12 uA/cm^2"}),
    "rings": ({}, {"rings.enabled": True, "rings.intensity": "1e-12 uA/cm^2"}),
    "conduction": ({"longitudinal.conduction": False}, {"longitudinal.conductivity_scale": 1e-15}),
    "packed folds": ({"wall.fold_tension": "0 mN/cm"}, {"wall.fold_tension": "1e-12 mN/cm"}),
    "bending": ({"wall.bending_stiffness": "0 mN*cm"}, {"wall.bending_stiffness": "1e-15 mN*cm"}),
    "longitudinal muscle": ({"longitudinal.active": 0}, {"longitudinal.active": 1e-12}),
    "c6": ({"wall.c6": 0}, {"wall.c6": 1e-12}),
    "one pulse of a train": ({}, {"pacemaker.kind": "periodic", "pacemaker.count": 1}),
}


@pytest.mark.parametrize("name", PAIRS)
def test_an_option_at_its_limit_is_the_option_off(name: str) -> None:
    """Track to 1e-9 cm, force to 1e-6 mN, balance of work to 1e-9 of the work done."""
    off, limit = (ps.run("baseline", SMALL | changes) for changes in PAIRS[name])
    assert off.status == limit.status
    for array, allowed in (("pellet_position", 1e-9), ("axial_force", 1e-6), ("power_residual", 1e-7)):
        assert np.abs(off.arrays[array] - limit.arrays[array]).max() <= allowed, array


def test_pressing_friction_grows_from_nothing() -> None:
    """Eq. (51) on the wall: what the coefficient changes is in proportion to it."""
    tracks = [
        ps.run("baseline", SMALL | WALL | {"pellet.friction_coefficient": mu}).arrays["pellet_position"]
        for mu in (0.0, 1e-4, 2e-4)
    ]
    once, twice = (float(np.abs(track - tracks[0]).max()) for track in tracks[1:])
    assert 1e-8 < once < 1e-4
    assert twice == pytest.approx(2.0 * once, rel=0.05)


def test_part_of_the_friction_that_presses() -> None:
    """All of it where there is no other, none where there is no pressing, less where viscous friction joins in."""
    law = FrictionLaw(1.0, 0.1)
    assert pressed_part(0.0, law, 300.0, 10.0, 30.0) == 1.0
    assert pressed_part(20.0, law, 0.0, 10.0, 20.0) == 0.0
    assert pressed_part(0.0, law, 0.0, 0.0, 0.0) == 0.0
    assert pressed_part(10.0, law, 300.0, 40.0, 40.0) == pytest.approx(0.75)
    assert pressed_part(10.0, law, 300.0, -400.0, 40.0) == pytest.approx(0.075)


def test_energy_of_a_nearly_isothermal_gas_does_not_cancel() -> None:
    """p0 V0 ln(V0/V) in the limit, to rounding: the plain difference is wrong in the sixth digit."""
    model = build(ps.configuration("baseline"))

    def energy(exponent: float) -> float:
        lumen = model.lumen._replace(reference_volume=20.0, exponent=exponent)
        return _gas_energy(replace(model, lumen=lumen), 19.0)

    assert energy(1.0 + 1e-10) == pytest.approx(energy(1.0), rel=1e-10)
    assert energy(1.0 + 0.999e-3) == pytest.approx(energy(1.0 + 1.001e-3), rel=1e-6)
