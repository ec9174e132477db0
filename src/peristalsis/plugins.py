"""What users add from their own files: cells, laws, shapes and other parts, outputs, scenarios and figures.

A file that says KIND and NAME is a part, and is read without being executed (`inputs.parts`). Any other file is
executed once, in every process that runs something, and registers what it defines.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import sys
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import Any

from . import scenarios
from .errors import ConfigurationError, PeristalsisError, shown
from .inputs import parts
from .inputs.parts import CODE_VARIABLE, Part
from .names import Output
from .names import register as register_output
from .paths import located
from .scenarios import Scenario
from .scenarios import register as register_scenario

_executed: dict[str, ModuleType] = {}


def register(what: Output | Scenario | str | PathLike[str] | ModuleType | Any) -> Any:
    """Make something known to this process, and, if it stands in a file that is named here, to those it starts.

    what: an `Output`, a `Scenario`, a `Figure`; or the path of a file (or an imported module) that is a part, such as a
    cell, or that registers what it defines. Returns what was registered. Raises ValueError for an output that is taken
    and ConfigurationError for anything else that cannot be registered.
    """
    if isinstance(what, Output):
        return register_output(what)
    if isinstance(what, Scenario):
        return register_scenario(what)
    if isinstance(what, ModuleType):
        what = what.__file__
    if isinstance(what, str | PathLike):
        return load(what)
    from .plots.figure import Figure

    if isinstance(what, Figure):
        from .plots.registry import register as register_figure

        return register_figure(what)
    raise ConfigurationError(
        f"{shown(type(what).__name__)} cannot be registered; give an Output, a Scenario, a Figure or the path of a file"
    )


def load(file: str | PathLike[str]) -> Part | ModuleType:
    """Register the part in a file, or execute the file, once. Raises ConfigurationError with what is wrong in it."""
    place = located(file).resolve()
    if parts.is_part(place):
        return parts.register(place)
    if str(place) not in _executed:
        given = os.environ.get(CODE_VARIABLE, "").split(os.pathsep)
        if str(place) not in given:
            os.environ[CODE_VARIABLE] = os.pathsep.join([*filter(None, given), str(place)])
        _execute(place)
    return _executed[str(place)]


def forget_all() -> None:
    """Take out everything that was registered from files, scenarios and figures among it; outputs stay."""
    from .plots import registry

    os.environ.pop(CODE_VARIABLE, None)
    parts.forget_all()
    scenarios.forget_all()
    registry.forget_all()
    _executed.clear()


def ready() -> None:
    """Execute the files that the process which started this one has executed."""
    for name in filter(None, os.environ.get(CODE_VARIABLE, "").split(os.pathsep)):
        if name not in _executed:
            _execute(Path(name))


def _execute(place: Path) -> None:
    name = f"peristalsis_plugin_{hashlib.sha256(str(place).encode()).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(name, place)
    if spec is None or spec.loader is None:
        raise ConfigurationError(f"{shown(str(place))} is no Python file; give one that ends in .py")
    module = importlib.util.module_from_spec(spec)
    _executed[str(place)] = sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException as error:
        del _executed[str(place)], sys.modules[name]
        if isinstance(error, PeristalsisError) or not isinstance(error, Exception):
            raise
        line = _line_in(place, error)
        raise ConfigurationError(
            f"plug-in {shown(str(place))}{line}: {type(error).__name__}: {shown(str(error), 200)}; correct it"
        ) from None


def _line_in(place: Path, error: Exception) -> str:
    """Where in the file the error came from."""
    found = error.lineno if isinstance(error, SyntaxError) else None
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == str(place):
            found = trace.tb_lineno
        trace = trace.tb_next
    return "" if found is None else f", line {found}"
