"""A cell of ours as a model of Myokit, and as CellML 2: every formula read from the file that is compiled."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import ConfigurationError, WriteError, shown
from .description import FOLDER, Description, Floats, described, plain_module, start
from .symbols import RESERVED, Formula, Reader, as_formula, inside

UNITS = {"mV": "mV", "ms": "ms", "1/ms": "1/ms", "mS/cm^2": "mS/cm^2", "uF/cm^2": "uF/cm^2", "uA/cm^2": "uA/cm^2"}
UNITS |= {
    "mM": "mM",
    "K": "K",
    "um^2": "um^2",
    "um^3": "um^3",
    "mM/ms": "mM/ms",
    "1/K": "1/K",
    "1/mV": "1/mV",
    "1": "1",
}
FORMATS = {".mmt": "Myokit's own format", ".cellml": "CellML 2"}


@dataclass(frozen=True)
class Equations:
    """What a model consists of: lines of variables by component, and begin: potential [mV] and states."""

    name: str
    title: str
    constants: tuple[tuple[str, float, str], ...]
    channels: tuple[tuple[str, float, str], ...]
    components: tuple[tuple[str, tuple[tuple[str, Formula], ...]], ...]
    states: tuple[tuple[str, Formula], ...]
    current: Formula
    begin: Floats


def equations(name: str) -> Equations:
    """The equations of a cell: "plant", another shipped name, or a description's file."""
    return _of_plant() if name == "plant" else _of_description(described(name))


def _names(kind: str, names: tuple[str, ...]) -> dict[str, Formula]:
    return {name: Formula(f"{kind}.{_safe(name)}") for name in names}


def _safe(name: str) -> str:
    return f"{name}_" if name in RESERVED else name


def _of_description(cell: Description) -> Equations:
    m: Any = cell.module
    reader = Reader(cell.tree, m)
    v = Formula("membrane.V")
    constants = _names("constants", m.CellConstants._fields)
    states = {(k): Formula(f"states.{_safe(name)}") for k, name in enumerate(cell.states)}
    channels = {k: Formula(f"channels.{_safe(name)}") for k, name in enumerate(m.CHANNELS)}
    gates: dict[Any, Any] = {}
    instants: dict[Any, Any] = {}
    rest: dict[Any, Any] = {}
    components = []

    def component(title: str, function: str, *arguments: Any) -> Any:
        reader.lines, reader.taken = [], set()
        result = reader.call(function, *arguments)
        for filled in arguments:
            if isinstance(filled, dict) and filled in (gates, instants, rest):
                for key, value in list(filled.items()):
                    filled[key] = reader.note(f"{title}_{key}", value)
        found = reader.note("total", result) if result is not None else None
        # What later components see of this one carries its name.
        for filled in (gates, instants, rest):
            if any(filled is one for one in arguments):
                for key, value in filled.items():
                    if isinstance(value, Formula) and value in reader.taken:
                        filled[key] = Formula(f"{title}.{value}")
        if reader.lines:
            components.append((title, tuple(reader.lines)))
        return Formula(f"{title}.{found}") if found is not None and found in reader.taken else found

    if m.GATES:
        component("gating", "gates", v, constants, gates)
    if m.INSTANT:
        component("instant", "instant", v, constants, instants)
    if len(cell.states) > m.GATES:
        component("sources", "others", v, states, channels, 0, constants, rest)
    current = component("ionic", "current", v, states, channels, instants, 0, constants)
    rates = []
    for k in range(m.GATES):
        steady, rate = as_formula(gates[2 * k]), as_formula(gates[2 * k + 1])
        rates.append(
            (_safe(cell.states[k]), Formula(f"{inside(rate, 2)} * ({inside(steady, 1)} - {_safe(cell.states[k])})", 2))
        )
    for k in range(m.GATES, len(cell.states)):
        source, decay = as_formula(rest[2 * (k - m.GATES)]), as_formula(rest[2 * (k - m.GATES) + 1])
        own = _safe(cell.states[k])
        rates.append((own, Formula(f"{inside(source, 1)} - {inside(decay, 2)} * {own}", 1)))
    units = {one.name: one.unit for one in getattr(m, "PARAMETERS", ())}
    amounts = {one.name: one.unit for one in m.CONDUCTANCES if hasattr(one, "unit")}
    return Equations(
        cell.name,
        cell.title,
        tuple((n, float(x), units.get(n, "1")) for n, x in zip(m.CellConstants._fields, m.SHIPPED, strict=True)),
        tuple((n, float(x), amounts.get(n, "mS/cm^2")) for n, x in zip(m.CHANNELS, cell.conductances, strict=True)),
        tuple(components),
        tuple(rates),
        as_formula(current),
        start(cell),
    )


def _of_plant() -> Equations:
    """Plant's cell, whose kernels are its own: Eqs. (20)-(22) with the numbers of the longitudinal layer."""
    from ..inputs.build import build
    from ..scenarios import configuration
    from ..tissue.rest import rest_state

    file = FOLDER / "plant.py"
    tree = ast.parse(file.read_text(encoding="utf-8"))
    reader = Reader(tree, plain_module(file, tree))
    model = build(configuration("baseline"))
    conductances = model.longitudinal.conductances[:, 0]
    v = Formula("membrane.V")
    constants = _names("constants", model.cell._fields)
    h, n, x, c = (Formula(f"states.{name}") for name in ("h", "n", "x", "c"))
    channels = {k: Formula(f"channels.{name}") for k, name in enumerate(reader.module.CHANNELS)}
    targets = reader.call("gate_targets", v, constants)
    noted = [reader.note(f"gate_{k}", one) for k, one in enumerate(targets)]
    gating = tuple(reader.lines)
    gates = [Formula(f"gating.{one}") if one in reader.taken else as_formula(one) for one in noted]
    reader.lines, reader.taken = [], set()
    cubed = reader.note("m_cubed", reader.call("fast_activation_cubed", v))
    fast, slope, offset = reader.call("current_coefficients", h, n, x, c, channels, 0, constants)
    total = Formula(
        f"{inside(fast, 2)} * {cubed} * (membrane.V - constants.calcium_reversal) + ({slope}) * membrane.V "
        f"- ({offset})",
        1,
    )
    total = reader.note("total", total)
    inflow = "constants.calcium_influx * x * (constants.calcium_entry_potential - membrane.V)"
    rates = [(s, Formula(f"{inside(gates[2 * k + 1], 2)} * ({gates[2 * k]} - {s})", 2)) for k, s in enumerate("hnx")]
    rates.append(("c", Formula(f"constants.calcium_rate * ({inflow} - c)", 2)))
    rest = rest_state(conductances, model.cell, model.tables[0])
    import numpy as np

    known = {name: "mV" for name in model.cell._fields if name.endswith(("reversal", "potential"))}
    known |= {"calcium_rate": "1/ms", "slow_gate_time": "ms", "calcium_influx": "1/mV", "capacitance": "uF/cm^2"}
    return Equations(
        "plant",
        "bursting neuron of Plant (1981), constants of the longitudinal layer",
        tuple((n_, float(x_), known.get(n_, "1")) for n_, x_ in zip(model.cell._fields, model.cell, strict=True)),
        tuple((n_, float(x_), "mS/cm^2") for n_, x_ in zip(reader.module.CHANNELS, conductances, strict=True)),
        (("gating", gating), ("ionic", tuple(reader.lines))),
        tuple(rates),
        Formula(f"ionic.{total}"),
        np.array([rest.potential, *rest.gates]),
    )


def written(cell: Equations) -> str:
    """The model in Myokit's syntax; the stimulus [uA/cm^2] is the variable bound to `pace`."""
    lines = ["[[model]]", f"name: {cell.name}", f'desc: """{cell.title}"""']
    names = [f"states.{name}" for name, _ in cell.states]
    lines += [f"{name} = {value!r}" for name, value in zip(["membrane.V", *names], cell.begin.tolist(), strict=True)]
    lines += ["", "[engine]", "time = 0 [ms] bind time", "    in [ms]", "pace = 0 bind pace", "    in [uA/cm^2]"]
    for title, numbers in (("constants", cell.constants), ("channels", cell.channels)):
        lines += ["", f"[{title}]"]
        for name, value, unit in numbers:
            known = UNITS.get(unit, "1")
            lines += [f"{_safe(name)} = {value!r} [{known}]", f"    in [{known}]"]
    lines += ["", "[membrane]", "i_ion = " + cell.current, "    in [uA/cm^2]"]
    lines += ["dot(V) = (engine.pace - constants.kinetics_rate * i_ion) / constants.capacitance"]
    lines += ["    label membrane_potential", "    in [mV]"]
    for title, variables in cell.components:
        lines += ["", f"[{title}]", *(f"{name} = {formula}" for name, formula in variables)]
    lines += ["", "[states]"]
    lines += [f"dot({name}) = constants.kinetics_rate * ({rate})" for name, rate in cell.states]
    return "\n".join([*lines, ""])


def export(name: str, file: Path) -> None:
    """Write a cell as .mmt, or as .cellml (version 2), for which Myokit is needed."""
    if file.suffix not in FORMATS:
        raise ConfigurationError(f"{shown(file.name)} ends with neither of {', '.join(FORMATS)}; choose one of them")
    text = written(equations(name))
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        if file.suffix == ".mmt":
            file.write_text(text, encoding="utf-8")
            return
        from .foreign import myokit

        kit = myokit()
        model = kit.parse_model(text)
        kit.formats.exporter("cellml2").model(str(file), model)
    except OSError as error:
        raise WriteError(
            f"could not write {shown(str(file))}: {error.strerror or error}; choose another place"
        ) from None
