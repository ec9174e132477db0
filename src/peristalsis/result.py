"""What a run leaves behind: a dataset with units, a summary, the configuration, and how they are stored."""

from __future__ import annotations

import json
import math
import os
import platform
import shutil
import uuid
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._version import __version__
from .config import Configuration
from .errors import ConfigurationError, WriteError, shown
from .names import COORDINATES, OUTPUTS

if TYPE_CHECKING:
    import xarray

    from .plots import Plots

Floats = NDArray[np.float64]

FAST_PART = (3.0, 8.0)
"""Stretch of the undeformed tube over which wave speeds are measured [cm]."""

SMALLEST_WORK = 1.0
"""Least work against which the balance of a run is measured [mN cm]: at rest there is nothing to compare with."""

RESULT_FILE, SUMMARY_FILE, CONFIGURATION_FILE = "result.nc", "summary.json", "config.toml"


@dataclass(frozen=True)
class Result:
    """One run: `dataset` (xarray, every output with its unit), `summary` (the numbers of --json), `configuration`.

    `status` and `error` say how it ended; `plot` draws its figures.
    """

    configuration: Configuration
    summary: Mapping[str, Any]
    arrays: Mapping[str, Floats]
    remarks: tuple[str, ...] = ()

    @property
    def status(self) -> str:
        """expelled, arrested, in_transit, finished, diverged or interrupted."""
        return str(self.summary["status"])

    @property
    def error(self) -> str | None:
        """Why the run broke off, or None."""
        text = self.summary.get("error")
        return None if text is None else str(text)

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """All outputs with dimensions, units and long names; the configuration and versions are attributes."""
        import xarray

        coordinates = {output.name for output in COORDINATES}
        variables = {}
        for name, values in self.arrays.items():
            output = OUTPUTS[name]
            attributes = {"units": output.unit, "long_name": output.long_name}
            variables[name] = (output.dimensions, values, attributes)
        data = {name: value for name, value in variables.items() if name not in coordinates}
        coords = {name: value for name, value in variables.items() if name in coordinates}
        return xarray.Dataset(data, coords, self._attributes())

    @property
    def plot(self) -> Plots:
        """The figures of this run: `result.plot.diameter_map()` and so on."""
        from .plots import Plots

        return Plots(self)

    def save(
        self,
        folder: str | os.PathLike[str],
        overwrite: bool = False,
        extras: Callable[[Path], None] | None = None,
    ) -> Path:
        """Write result.nc, summary.json and config.toml into `folder`; the folder appears complete or not at all.

        extras: called with the folder before it is put in place, to add files such as pictures. Raises WriteError
        when the folder exists (without `overwrite`) or cannot be written.
        """
        target = Path(folder)
        check_target(target, overwrite)
        temporary = target.parent / f".tmp-{uuid.uuid4().hex}"
        try:
            temporary.mkdir(parents=True)
            # Built in memory: the HDF5 library does not survive a disk that fills up under an open file.
            image = self.dataset.to_netcdf(engine="h5netcdf", encoding=self._encoding())
            (temporary / RESULT_FILE).write_bytes(image)
            (temporary / CONFIGURATION_FILE).write_text(self.configuration.to_toml(), encoding="utf-8")
            text = json.dumps(json_ready(self.summary), indent=2, allow_nan=False) + "\n"
            (temporary / SUMMARY_FILE).write_text(text, encoding="utf-8")
            if extras is not None:
                extras(temporary)
            _synchronise(temporary)
            _put_in_place(temporary, target)
        except OSError as error:
            raise WriteError(
                f"could not write {shown(str(target))}: {error.strerror or error}; free some space or choose another "
                "folder with --out"
            ) from None
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
        return target

    def _encoding(self) -> dict[str, dict[str, Any]]:
        large = [name for name, values in self.arrays.items() if np.size(values) > 10_000]
        return {name: {"zlib": True, "complevel": 1, "shuffle": True} for name in large}

    def _attributes(self) -> dict[str, Any]:
        configuration = self.configuration
        sources = sorted({entry.source for entry in configuration.items() if entry.source})
        return {
            "Conventions": "CF-1.10",
            "title": f"peristalsis run {configuration.scenario}, reading {configuration.reading}",
            "source": f"peristalsis {__version__}",
            "configuration": configuration.to_toml(),
            "configuration_digest": configuration.digest(),
            "summary": json.dumps(json_ready(self.summary), allow_nan=False),
            "parameter_sources": "; ".join(sources),
            "versions": json.dumps(versions()),
            "remarks": " | ".join(self.remarks),
        }


def load(folder: str | os.PathLike[str]) -> Result:
    """The result stored in a folder, as it was. Raises ConfigurationError if it is not there or not whole."""
    import xarray

    path = Path(folder)
    file = path / RESULT_FILE if path.is_dir() else path
    if not file.is_file():
        raise ConfigurationError(f"no result in {shown(str(folder))}: {RESULT_FILE} is missing; run a scenario first")
    try:
        with xarray.open_dataset(file, engine="h5netcdf") as stored:
            dataset = stored.load()
        configuration = Configuration.from_toml(str(dataset.attrs["configuration"]))
        summary = json.loads(dataset.attrs["summary"])
    except (OSError, ValueError, KeyError) as error:
        reason = " ".join(str(error).split())[:120]
        raise ConfigurationError(f"{shown(str(file))} is not a whole result of peristalsis ({reason})") from None
    arrays = {str(name): np.asarray(dataset[name].values) for name in dataset.variables}
    remarks = tuple(text for text in str(dataset.attrs.get("remarks", "")).split(" | ") if text)
    return Result(configuration, summary, arrays, remarks)


def check_target(target: Path, overwrite: bool) -> None:
    """Refuse, before anything is computed, a folder that exists or cannot be made."""
    try:
        _check_target(target, overwrite)
    except OSError as error:
        raise WriteError(f"{shown(str(target))}: {error.strerror or error}; choose another folder with --out") from None


def _check_target(target: Path, overwrite: bool) -> None:
    if target.exists() and not overwrite:
        raise WriteError(f"{shown(str(target))} exists; choose another folder with --out, or say --overwrite")
    if target.exists() and not target.is_dir():
        raise WriteError(f"{shown(str(target))} is a file, not a folder; choose another one with --out")
    if target.is_dir() and any(target.iterdir()) and not (target / SUMMARY_FILE).exists():
        raise WriteError(
            f"{shown(str(target))} holds files but no result of peristalsis, so it is not overwritten; choose another"
        )
    parent = target.parent
    while not parent.exists() and parent != parent.parent:
        parent = parent.parent
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise WriteError(f"{shown(str(parent))} is not a folder that can be written to; choose another one with --out")


def _synchronise(folder: Path) -> None:
    for file in folder.rglob("*"):
        if file.is_file():
            with file.open("rb+") as handle:
                os.fsync(handle.fileno())


def _put_in_place(temporary: Path, target: Path) -> None:
    """Rename the finished folder to its name; an old result is moved aside first and removed last."""
    old = target.parent / f".old-{uuid.uuid4().hex}"
    if target.exists():
        os.replace(target, old)
    try:
        os.replace(temporary, target)
    except OSError:
        if old.exists():
            os.replace(old, target)
        raise
    shutil.rmtree(old, ignore_errors=True)


def versions() -> dict[str, str]:
    """Versions of this package and of what the numbers depend on."""
    import importlib.metadata

    found = {"peristalsis": __version__, "python": platform.python_version()}
    for name in ("numpy", "scipy", "numba", "xarray", "h5netcdf"):
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "unknown"
    return found


def json_ready(value: Any) -> Any:
    """The same with plain types only; numbers that are not finite become null."""
    if isinstance(value, Mapping):
        return {str(key): json_ready(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [json_ready(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def wave_speed(z: Floats, activation: Floats) -> float | None:
    """Speed of the first wave [cm/s]: slope of place over activation time between 3 and 8 cm; None if none passed.

    z: cells [cm], (n_z,); activation: first activation times [s], (n_z,), nan where there was none.
    """
    part = (z > FAST_PART[0]) & (z < FAST_PART[1])
    if part.sum() < 3 or not np.isfinite(activation[part]).all():
        return None
    slowness = float(np.polyfit(z[part], activation[part], 1)[0])
    return 1.0 / slowness if slowness != 0.0 else None


def summarise(
    configuration: Configuration,
    arrays: Mapping[str, Floats],
    status: str,
    error: str | None,
    transit: float | None,
    absolute_work: float,
    cost: Mapping[str, float],
) -> dict[str, Any]:
    """The numbers of --json from the recorded arrays; see docs/conventions for each of them."""
    pellet = configuration.pellet.enabled
    time = arrays["time_step"]
    simulated = float(time[-1])
    position = arrays["pellet_position"]
    travel = float(position[-1] - position[0]) if pellet else None
    until = transit if transit is not None else simulated
    if pellet and transit is not None:
        travel = float(np.interp(transit, time, position) - position[0])
    speeds = {
        layer: wave_speed(arrays["z_cell"], arrays[f"activation_{layer}"][:, 0])
        for layer in ("longitudinal", "circular")
    }
    residual = float(np.abs(arrays["power_residual"]).max()) / max(absolute_work, SMALLEST_WORK)

    def peak(name: str) -> float | None:
        return float(np.nanmax(np.abs(arrays[name]))) if pellet else None

    summary = {
        "scenario": configuration.scenario,
        "reading": configuration.reading,
        "status": status,
        "error": error,
        "transit_s": transit,
        "start_cm": float(position[0]) if pellet else None,
        "final_position_cm": float(position[-1]) if pellet else None,
        "travel_cm": travel,
        "mean_velocity_cm_s": travel / until if travel is not None and until > 0.0 else None,
        "max_velocity_cm_s": float(arrays["pellet_velocity"].max()) if pellet else None,
        "max_axial_force_mN": peak("axial_force"),
        "max_normal_force_mN": peak("normal_force"),
        "max_lumen_pressure_kPa": float(arrays["lumen_pressure"].max()),
        "max_contact_pressure_kPa": peak("max_contact_pressure"),
        "wave_speed_cm_s": speeds,
        "min_diameter_cm": float(arrays["min_diameter"].min()),
        "power_residual": residual,
        "simulated_s": simulated,
        "solver_wall_s": cost.get("solver_wall_s", 0.0),
        "compile_wall_s": cost.get("compile_wall_s", 0.0),
        "steps": int(time.size - 1),
        "version": __version__,
    }
    cleaned: dict[str, Any] = json_ready(summary)
    return cleaned
