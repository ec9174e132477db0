"""What a foreign model is made of: potential, stimulus, capacitance, channels, gates and other states."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import ConfigurationError
from .foreign import myokit
from .formulas import affine, definition, dependencies, relaxation, rests_on, split, summands, total, value

Expression = Any
Variable = Any

POTENTIALS = ("v", "vm", "v_m", "e", "u", "potential", "membrane_potential", "vm_sm", "transmembrane_potential")
CONDUCTING = re.compile(r"^(g|gbar|gmax|p)(_|$|[A-Z0-9])|^(g|p)(na|k|ca|l|cl)|conductance|permeability", re.IGNORECASE)
LOWEST, HIGHEST = -150.0, 100.0


@dataclass
class Gate:
    """A state that relaxes to `steady` at `rate`, both of the potential alone, in the model's own units."""

    state: Variable
    steady: Expression
    rate: Expression


@dataclass
class Other:
    """A state with s' = source - decay s, in the model's own units; None is 0."""

    state: Variable
    source: Expression | None
    decay: Expression | None


@dataclass
class Channel:
    """Terms of dV/dt that are proportional to one constant, or to none; factor: its unit in mS/cm^2."""

    name: str
    conductance: Variable | None
    terms: list[Expression] = field(default_factory=list)
    factor: float = 1.0
    unit: str = "mS/cm^2"


@dataclass
class Anatomy:
    """All of it. potential_scale, time_scale: mV, ms in one unit of the model; capacitance_scale: likewise uF/cm^2."""

    model: Any
    potential: Variable
    potential_scale: float
    time_scale: float
    capacitance: Variable | None
    capacitance_scale: float
    per_cell: bool
    gates: list[Gate]
    others: list[Other]
    channels: list[Channel]
    stimuli: list[str]
    remarks: list[str]


def analysed(model: Any) -> Anatomy:
    """Take a model apart; a ConfigurationError of one sentence says why it is no cell."""
    model = model.clone()
    remarks: list[str] = []
    potential = _potential(model)
    stimuli = _leave_out_stimuli(model, potential)
    potential_scale = _scale(potential.unit(), "mV", potential.qname(), remarks)
    time = model.time()
    time_scale = _scale(None if time is None else time.unit(), "ms", "time", remarks)
    gates, others = _states(model, potential, potential_scale)
    capacitance, capacitance_scale, per_cell = _capacitance(potential, remarks)
    anatomy = Anatomy(model, potential, potential_scale, time_scale, capacitance, capacitance_scale, per_cell, gates,
                      others, [], stimuli, remarks)  # fmt: skip
    anatomy.channels = _channels(anatomy)
    try:
        model.check_units()
        remarks.append("the units of the file agree with one another")
    except Exception as error:
        said = " ".join(str(error).split()).split(" on line")[0]
        remarks.append(
            f"units of the file do not agree everywhere, and its numbers are taken as they stand: {said[:150]}"
        )
    return anatomy


def _potential(model: Any) -> Variable:
    kit = myokit()
    states = list(model.states())
    if not states:
        raise ConfigurationError("the model has no differential equations, so it is no cell; choose another file")
    labelled = model.label("membrane_potential")
    if labelled is not None and labelled.is_state():
        return labelled
    volt = kit.parse_unit("V")
    by_unit = [s for s in states if s.unit() is not None and kit.Unit.close_exponent(s.unit(), volt)]
    by_name = [s for s in states if s.name().lower() in POTENTIALS]
    for found in (by_unit, [s for s in by_unit if s in by_name], by_name):
        if len(found) == 1:
            return found[0]
    if not by_unit and not by_name:
        raise ConfigurationError(
            "the model has no membrane potential among its states: none is in volts or named V; label one in an "
            ".mmt file"
        )
    names = ", ".join(s.qname() for s in by_unit or by_name)
    raise ConfigurationError(f"{names} could each be the membrane potential; label one of them in an .mmt file")


def _leave_out_stimuli(model: Any, potential: Variable) -> list[str]:
    """Set to 0 what depends on time or a pacing protocol; their names."""
    kit = myokit()
    time = model.time()
    driven = set(model.variables(deep=True, bound=True))

    def follows(variable: Variable) -> bool:
        return not variable.is_state() and any(left.var() in driven for left in variable.rhs().references())

    while True:
        more = {v for v in model.variables(deep=True) if v not in driven and not v.is_bound() and follows(v)}
        if not more:
            break
        driven |= more
    left_out = []
    for variable in sorted(driven - {time}, key=lambda v: v.qname()):
        users = [user for user in variable.refs_by() if user not in driven]
        if not users:
            continue
        if variable.unit() is not None and kit.Unit.close_exponent(variable.unit(), kit.parse_unit("V")):
            raise ConfigurationError(
                f"{variable.qname()} sets a potential in the course of time, as a voltage clamp does; take the "
                "clamp out of the file"
            )
        left_out.append(variable.qname())
        if variable.is_bound():
            variable.set_binding(None)
        unit = variable.unit()
        variable.set_rhs(kit.Number(0, unit))
    if any(time in one.rhs().references() or any(left.var() is time for left in one.rhs().references())
           for one in model.states()):  # fmt: skip
        names = [s.qname() for s in model.states() if any(left.var() is time for left in s.rhs().references())]
        raise ConfigurationError(
            f"time stands in the equation of {', '.join(names)} itself; give the stimulus a variable of its own"
        )
    return left_out


def _scale(unit: Any, wanted: str, name: str, remarks: list[str]) -> float:
    kit = myokit()
    if unit is None or unit == kit.units.dimensionless:
        remarks.append(f"{name} has no unit and is taken to be in {wanted}")
        return 1.0
    try:
        return float(kit.Unit.conversion_factor(unit, kit.parse_unit(wanted)).value())
    except kit.IncompatibleUnitError:
        raise ConfigurationError(f"{name} is in {unit}, which is no multiple of {wanted}; mend the unit") from None


def _states(model: Any, potential: Variable, scale: float) -> tuple[list[Gate], list[Other]]:
    gates, others = [], []
    for state in model.states():
        if state is potential:
            continue
        alone = all(one in (state, potential) or one.is_literal() for one in dependencies(state.rhs()))
        gate = _gate(state, potential, scale) if alone else None
        if gate is not None:
            gates.append(gate)
        else:
            others.append(Other(state, *split(state.rhs(), state)))
    return gates, others


def _gate(state: Variable, potential: Variable, scale: float) -> Gate | None:
    kit = myokit()
    found = relaxation(state.rhs(), state)
    if found is None:
        straight = affine(state.rhs(), state)
        if straight is None or straight[1] is None:
            return None
        slope = straight[1]
        rate = slope[0] if isinstance(slope, kit.PrefixMinus) else kit.PrefixMinus(slope)
        found = (kit.Number(0) if straight[0] is None else kit.Divide(straight[0], rate)), rate
    rates = [value(found[1], {potential: v / scale}) for v in (-90.3, -60.3, -30.3, -0.3)]
    return Gate(state, *found) if all(np.isfinite(r) and r > 0.0 for r in rates) else None


def _capacitance(potential: Variable, remarks: list[str]) -> tuple[Variable | None, float, bool]:
    """The constant that divides the currents, its value in uF/cm^2 per unit, and whether it belongs to a whole cell."""
    kit = myokit()
    rate = potential.rhs()
    farad, area = kit.parse_unit("F"), kit.parse_unit("F/m^2")
    found = []
    for one in dependencies(rate):
        if not one.is_literal() or one.is_state() or one.is_bound():
            continue
        unit = one.unit()
        known = unit is not None and any(kit.Unit.close_exponent(unit, other) for other in (farad, area))
        bare = unit is None or unit == kit.units.dimensionless
        if known or (bare and one.name().lower() in ("c", "cm", "c_m", "capacitance", "cap")):
            changed = value(rate, {one: 2.0 * value(kit.Name(one))})
            if np.isclose(2.0 * changed, value(rate), rtol=1e-9, atol=0.0):
                found.append(one)
    if len(found) != 1:
        remarks.append("no capacitance was found: currents are per capacitance, at 1 uF/cm^2")
        return None, 1.0, False
    unit = found[0].unit()
    if unit is not None and kit.Unit.close_exponent(unit, farad):
        remarks.append(
            f"currents of a whole cell of {value(kit.Name(found[0])):g} {str(unit).strip('[]')} are per area, "
            "at 1 uF/cm^2"
        )
        return found[0], 1.0 / value(kit.Name(found[0])), True
    if unit is None or unit == kit.units.dimensionless:
        remarks.append(f"{found[0].qname()} has no unit and is taken to be in uF/cm^2")
        return found[0], 1.0, False
    return found[0], float(kit.Unit.conversion_factor(unit, kit.parse_unit("uF/cm^2")).value()), False


def _channels(cell: Anatomy) -> list[Channel]:
    rate = cell.potential.rhs()
    candidates = [v for v in dependencies(rate) if _conducts(v)]

    def apart(one: Expression) -> bool:
        return len({v for v in candidates if rests_on(one, v)}) > 1

    terms = summands(rate, lambda one: one is rate or apart(one) or (_is_sum(one) and not candidates))
    channels: dict[Any, Channel] = {}
    for k, term in enumerate(terms):
        if value(term, {cell.potential: -47.1 / cell.potential_scale}) == 0.0 and not _rests_on_states(term):
            continue
        proportional = [v for v in candidates if rests_on(term, v) and _proportional(term, v, cell)]
        key = min(proportional, key=lambda v: v.qname()) if proportional else f"current_{k + 1}"
        if key not in channels:
            name = key if isinstance(key, str) else key.name()
            channels[key] = Channel(name, None if isinstance(key, str) else key)
        channels[key].terms.append(term)
    for channel in channels.values():
        if channel.conductance is None:
            channel.name, channel.unit = _named_after(channel.terms, channel.name), "1"
        else:
            channel.factor, channel.unit = _conductance_scale(channel.conductance, cell)
    found = list(channels.values())
    for one in found:  # g_Na of two components
        if sum(other.name == one.name for other in found) > 1 and one.conductance is not None:
            one.name = one.conductance.qname().replace(".", "_")
    return found


def _named_after(terms: list[Expression], otherwise: str) -> str:
    """The name of the current, where a term is one."""
    kit = myokit()
    for term in terms:
        names = [left.var().name() for left in term.references() if isinstance(left, kit.Name)
                 and definition(left) is not None and re.match(r"[iI]", left.var().name())]  # fmt: skip
        if len(names) == 1:
            return str(names[0])
    return otherwise


def _is_sum(expression: Expression) -> bool:
    kit = myokit()
    meant = definition(expression)
    return isinstance(meant if meant is not None else expression, kit.Plus | kit.Minus)


def _rests_on_states(term: Expression) -> bool:
    return any(one.is_state() for one in dependencies(term))


def _conducts(variable: Variable) -> bool:
    kit = myokit()
    if not variable.is_literal() or variable.is_state() or variable.is_bound():
        return False
    unit = variable.unit()
    if unit is not None and any(kit.Unit.close_exponent(unit, kit.parse_unit(other)) for other in ("S", "S/m^2")):
        return True
    return CONDUCTING.search(variable.name()) is not None


def _proportional(term: Expression, variable: Variable, cell: Anatomy) -> bool:
    kit = myokit()
    g = value(kit.Name(variable))
    if g == 0.0:
        return True
    for v in (-63.7, -21.3):
        base = value(term, {cell.potential: v / cell.potential_scale})
        twice = value(term, {cell.potential: v / cell.potential_scale, variable: 2.0 * g})
        if not np.isclose(twice, 2.0 * base, rtol=1e-9, atol=1e-300):
            return False
    return True


def _conductance_scale(variable: Variable, cell: Anatomy) -> tuple[float, str]:
    """(mS/cm^2 in one unit of the constant, unit) or a number without unit where it is none of a conductance."""
    kit = myokit()
    unit = variable.unit()
    for other, wanted in (("S", "mS"), ("S/m^2", "mS/cm^2"), ("S/F", "mS/uF")):
        if unit is not None and kit.Unit.close_exponent(unit, kit.parse_unit(other)):
            factor = float(kit.Unit.conversion_factor(unit, kit.parse_unit(wanted)).value())
            if other == "S" and cell.capacitance is not None and cell.per_cell:
                own = cell.capacitance.unit()
                farads = float(kit.Unit.conversion_factor(own, kit.parse_unit("uF")).value())
                return factor / (farads * value(kit.Name(cell.capacitance))), "mS/cm^2"
            return factor, "mS/cm^2" if other != "S" else "mS"
    if unit is None or unit == kit.units.dimensionless:
        return 1.0, "1" if variable.name().lower().startswith("p") else "mS/cm^2"
    return 1.0, str(unit).strip("[]")


def as_sum(channel: Channel) -> Expression:
    """The part of dV/dt that a channel brings."""
    return total(channel.terms)
