"""The door to Myokit: files of other programs as its models, its simulation as the reference."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ConfigurationError, shown
from .description import Floats

READERS = {".cellml": "cellml", ".xml": "", ".sbml": "sbml", ".mmt": ""}


def myokit() -> Any:
    """The library. Raises ConfigurationError without it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import myokit as kit
            import myokit.formats
    except ImportError:
        raise ConfigurationError(
            "files of other programs are read and written by Myokit; install it with pip install 'peristalsis[cells]'"
        ) from None
    return kit


def read(file: Path) -> Any:
    """The model in a CellML (1.0 to 2.0), SBML or .mmt file; a ConfigurationError of one sentence says what stands in
    the way."""
    kit = myokit()
    if not file.is_file():
        raise ConfigurationError(f"there is no file {shown(str(file))}; check the path")
    kind = _kind(file)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if kind == "mmt":
                model = kit.load_model(str(file))
                if model is None:
                    raise ConfigurationError(f"{shown(file.name)} holds no model; add a [[model]] section")
            else:
                model = kit.formats.importer(kind).model(str(file))
            model.validate()
    except ConfigurationError:
        raise
    except Exception as error:  # each format has errors of its own
        raise ConfigurationError(_reason(file, kind, str(error))) from None
    return model


def _kind(file: Path) -> str:
    if file.suffix == ".mmt":
        return "mmt"
    head = file.read_text(encoding="utf-8", errors="replace")[:4000]
    if "<sbml" in head:
        return "sbml"
    if "cellml.org/cellml" in head:
        return "cellml"
    raise ConfigurationError(f"{shown(file.name)} is neither CellML nor SBML nor .mmt; give a file of one of these")


def _reason(file: Path, kind: str, said: str) -> str:
    """What Myokit said, with what can be done."""
    first = " ".join(said.split()).rstrip(".")[:300]
    low = first.lower()
    text = file.read_text(encoding="utf-8", errors="replace") if kind == "cellml" else ""
    name = shown(file.name)
    if "<import" in text or "import" in low:
        return f"{name} imports parts of other CellML files; flatten it into one file first"
    if "cycl" in low or "circular" in low or "interdependent" in low:
        return f"{name} has an algebraic loop, which a cell cannot solve for: {first}; solve it by hand"
    if "unit" in low:
        return f"{name} has a unit that is not known: {first}; define it in the file"
    return f"{name} could not be read: {first}; mend the file, or ask the program that wrote it for another format"


def simulation(model: Any, times: Sequence[float] | Floats, names: Sequence[str]) -> tuple[Floats, str]:
    """Variables of a Myokit model at times (in its own unit), shape (names, times), and which solver gave them.

    Myokit's own simulation needs SUNDIALS and a C compiler; without them its equations go through SciPy's LSODA.
    """
    kit = myokit()
    at = np.asarray(times, dtype=np.float64)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            run = kit.Simulation(model.clone())
            run.set_tolerance(1e-9, 1e-9)
            log = run.run(float(at[-1]) * (1 + 1e-12) + 1e-9, log=list(names), log_times=at)
        return np.array([log[name] for name in names]), "Myokit's CVODES"
    except Exception:  # no compiler, no headers: each system says it otherwise
        return _by_scipy(model, at, names), "SciPy's LSODA on Myokit's equations"


def right_side(model: Any) -> Any:
    """The derivatives of a Myokit model as a Python function of (time, states), in its own units and order."""
    kit = myokit()
    writer = kit.formats.ewriter("python")
    writer.set_lhs_function(lambda lhs: _python(lhs))
    lines = ["def f(t, y):"]
    for k, state in enumerate(model.states()):
        lines.append(f"    {_python(kit.Name(state))} = y[{k}]")
    order = model.solvable_order()
    for component in order.values():
        for equation in component:
            left = equation.lhs
            if isinstance(left, kit.Name) and left.var().binding() == "time":
                lines.append(f"    {_python(left)} = t")
            else:
                lines.append(f"    {writer.eq(equation)}")
    lines.append("    return [" + ", ".join(_python(kit.Derivative(kit.Name(s))) for s in model.states()) + "]")
    import math

    scope: dict[str, Any] = {"math": math}
    exec("\n".join(lines), scope)
    return scope["f"]


def _python(lhs: Any) -> str:
    kit = myokit()
    if isinstance(lhs, kit.Derivative):
        return "d_" + lhs.var().qname().replace(".", "__")
    return "v_" + lhs.var().qname().replace(".", "__")


def _by_scipy(model: Any, at: Floats, names: Sequence[str]) -> Floats:
    from scipy.integrate import solve_ivp

    f = right_side(model)
    initial = model.initial_values(as_floats=True)
    span = float(at[-1])
    solved = solve_ivp(f, (0.0, span + 1e-9), initial, method="LSODA", rtol=1e-9, atol=1e-11, t_eval=at,
                       max_step=span / 50)  # fmt: skip
    states = [state.qname() for state in model.states()]
    return np.asarray(solved.y[[states.index(name) for name in names]])
