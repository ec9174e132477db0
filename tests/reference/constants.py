"""The constants of the model, read from the shipped parameter files by path: shared data, no shared code."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, NamedTuple

PARAMETERS = Path(__file__).resolve().parents[2] / "src" / "peristalsis" / "inputs" / "parameters"
SOURCES = ("al_qatrawi_miftahof", "chosen", "plant_1981", "tong_fung_1976")

# Units of the files that are not already mN, cm, s, mV. Cells keep ms, mS/cm^2, uF/cm^2.
TO_INTERNAL = {"kPa": 100.0, "mg/cm^2": 1.0e-5}


class Layer(NamedTuple):
    """One muscle layer: active tension (5), threshold (19), conductances (21), axial diffusivity [cm^2/ms]."""

    c7: float
    c8: float
    c9: float
    threshold: float
    fast: float
    slow: float
    potassium: float
    calcium_potassium: float
    leak: float
    diffusivity: float


class Constants(NamedTuple):
    """Everything both implementations need, internal units (pulses: µA/cm^2, s, cm)."""

    radius: float
    length: float
    surface_density: float
    viscosity: float
    c1: float
    c2: float
    c3: float
    c4: float
    c5: float
    c6: float
    c10: float
    published: bool
    blend: float
    slope: float
    fold_stretch: float
    fold_tension: float
    bending: float
    bending_viscosity: float
    pressure: float
    exponent: float
    pellet_radius: float
    start_gap: float
    viscous_friction: float
    dry_friction: float
    longitudinal: Layer
    circular: Layer
    capacitance: float
    kinetics: float
    pacemaker_intensity: float
    pacemaker_duration: float
    pacemaker_width: float
    trigger_rule: str
    trigger_delay: float
    trigger_level: float
    trigger_intensity: float
    trigger_duration: float
    trigger_refractory: float
    reflex: bool
    reflex_threshold: float
    oral_length: float
    anal_length: float
    reflex_delay: float
    reflex_refractory: float
    excitation: float
    excitation_duration: float
    inhibition: float
    inhibition_duration: float
    reversal_calcium: float
    reversal_potassium: float
    reversal_leak: float
    half_saturation: float
    calcium_rate: float
    calcium_influx: float
    calcium_entry: float
    gate_factor: float
    slow_time: float


def load(reading: str = "tight", **changes: Any) -> Constants:
    """The constants of a reading, with some replaced by name (fields of `Constants`)."""
    files = {name: tomllib.loads((PARAMETERS / f"{name}.toml").read_text("utf-8")) for name in SOURCES}
    table = {key: entry for name in SOURCES for key, entry in files[name].items() if key != "source"}
    for key, entry in tomllib.loads((PARAMETERS / "readings.toml").read_text("utf-8"))[reading].items():
        if key != "why":
            table[key] = files[entry["from"]][key] if "from" in entry else entry

    def number(key: str) -> Any:
        value = table[key]["value"]
        return value * TO_INTERNAL.get(table[key].get("unit", ""), 1.0) if isinstance(value, float) else value

    def layer(name: str) -> Layer:
        inside, outside = number(f"{name}.intracellular_axial"), number(f"{name}.extracellular_axial")
        series = number(f"{name}.conductivity_scale") * inside * outside / (inside + outside)
        keys = ("c7", "c8", "c9", "threshold", "fast_calcium", "slow_calcium", "potassium", "calcium_potassium", "leak")
        return Layer(
            *(number(f"{name}.{key}") for key in keys),
            diffusivity=number("tissue.volume_to_surface") * series / number("tissue.capacitance"),
        )

    constants = Constants(
        radius=number("wall.radius"),
        length=number("wall.length"),
        surface_density=number("wall.surface_density"),
        viscosity=number("wall.viscosity"),
        c1=number("wall.c1"),
        c2=number("wall.c2"),
        c3=number("wall.c3"),
        c4=number("wall.c4"),
        c5=number("wall.c5"),
        c6=number("wall.c6"),
        c10=number("wall.c10"),
        published=number("wall.tension") == "published",
        blend=number("wall.slack_blend"),
        slope=number("wall.slack_slope"),
        fold_stretch=number("wall.fold_stretch"),
        fold_tension=number("wall.fold_tension"),
        bending=number("wall.bending_stiffness"),
        bending_viscosity=number("wall.bending_viscosity"),
        pressure=number("lumen.pressure"),
        exponent=number("lumen.adiabatic_exponent"),
        pellet_radius=number("pellet.radius"),
        start_gap=number("pellet.start_gap"),
        viscous_friction=number("pellet.viscous_friction"),
        dry_friction=number("pellet.dry_friction"),
        longitudinal=layer("longitudinal"),
        circular=layer("circular"),
        capacitance=number("tissue.capacitance"),
        kinetics=number("tissue.kinetics_rate"),
        pacemaker_intensity=number("pacemaker.intensity"),
        pacemaker_duration=number("pacemaker.duration"),
        pacemaker_width=number("pacemaker.width"),
        trigger_rule=number("trigger.rule"),
        trigger_delay=number("trigger.delay"),
        trigger_level=number("trigger.level"),
        trigger_intensity=number("trigger.intensity"),
        trigger_duration=number("trigger.duration"),
        trigger_refractory=number("trigger.refractory"),
        reflex=number("reflex.enabled"),
        reflex_threshold=number("reflex.threshold"),
        oral_length=number("reflex.oral_length"),
        anal_length=number("reflex.anal_length"),
        reflex_delay=number("reflex.delay"),
        reflex_refractory=number("reflex.refractory"),
        excitation=number("reflex.excitation_intensity"),
        excitation_duration=number("reflex.excitation_duration"),
        inhibition=number("reflex.inhibition_conductance"),
        inhibition_duration=number("reflex.inhibition_duration"),
        reversal_calcium=number("cell.calcium_reversal"),
        reversal_potassium=number("cell.potassium_reversal"),
        reversal_leak=number("cell.chloride_reversal"),
        half_saturation=number("cell.calcium_half_saturation"),
        calcium_rate=number("cell.calcium_rate"),
        calcium_influx=number("cell.calcium_influx"),
        calcium_entry=number("cell.calcium_entry_potential"),
        gate_factor=number("cell.gate_time_factor"),
        slow_time=number("cell.slow_gate_time"),
    )
    return constants._replace(**changes)
