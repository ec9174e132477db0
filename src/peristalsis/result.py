"""What a run leaves behind: a dataset with units, a summary, the configuration, and how they are stored."""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import tables
from ._version import __version__
from .config import Configuration
from .disk import read_regular
from .environment import code_version, machine, versions
from .errors import ConfigurationError, shown
from .manifest import FILE as MANIFEST_FILE
from .manifest import SCHEMA
from .names import COORDINATES, OUTPUTS
from .netcdf import netcdf_image
from .store import (
    CONFIGURATION_FILE,
    RESULT_FILE,
    SUMMARY_FILE,
    Workspace,
    check_target,
    damaged,
    read_file,
    read_manifest,
    recover,
)

if TYPE_CHECKING:
    import xarray

    from .plots import Plots

Floats = NDArray[np.float64]

FAST_PART = (3.0, 8.0)
"""Stretch of the undeformed tube over which wave speeds are measured [cm]."""

SMALLEST_WORK = 1.0
"""Least work against which the balance of a run is measured [mN cm]: at rest there is nothing to compare with."""
SMALLEST_FORCE = 1.0
"""The same for the balance of axial momentum [mN]."""

LARGEST_RESULT = 4_000_000_000
"""Bytes of a file without a manifest that are read."""

CLOCK = ("solver_wall_s", "compile_wall_s")
"""Numbers of a summary that are times on the clock, different in every run."""

UNFINISHED = ("interrupted", "diverged")
"""Runs that broke off: their last checkpoint is kept with them."""


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

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of every recorded number and of the summary, times on the clock left out: equal runs have one.

        It does not depend on how a run was stored, nor on the sign or payload of a nan.
        """
        digest = hashlib.sha256()
        numbers = {key: value for key, value in self.summary.items() if key not in CLOCK}
        digest.update(json.dumps(json_ready(numbers), sort_keys=True).encode("ascii"))
        for name in sorted(self.arrays):
            values = np.asarray(self.arrays[name])
            if values.dtype.kind == "f":
                values = np.where(np.isnan(values), np.nan, values)
            if values.dtype.kind in "OUT":
                content = json.dumps([str(text) for text in values.ravel()]).encode("ascii")
            else:
                content = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<")).tobytes()
            digest.update(f"{name} {values.shape} ".encode("ascii") + content)
        return digest.hexdigest()

    def save(
        self,
        folder: str | os.PathLike[str],
        overwrite: bool = False,
        extras: Callable[[Path], None] | None = None,
        workspace: Workspace | None = None,
    ) -> Path:
        """Write result.nc, summary.json, config.toml and manifest.json; the folder appears complete or not at all.

        extras: called with the folder before it is put in place, to add files such as pictures. workspace: the hidden
        folder of the run, if it has one; its checkpoints stay with a run that broke off. Raises WriteError when the
        folder exists (without `overwrite`) or cannot be written; a workspace with checkpoints stays then.
        """
        target = Path(folder)
        check_target(target, overwrite)
        own = workspace is None
        place = Workspace(target) if workspace is None else workspace
        try:
            image = netcdf_image(self.arrays, self._attributes())
            summary = json.dumps(json_ready(self.summary), indent=2, allow_nan=False) + "\n"
            files = tables.files_of(self.configuration.naming_tables()) | {
                RESULT_FILE: image,
                CONFIGURATION_FILE: self.configuration.to_toml().encode("utf-8"),
                SUMMARY_FILE: summary.encode("utf-8"),
            }
            place.publish(files, self.status, self._about(), extras, self.status in UNFINISHED)
        except BaseException:
            if own or not place.has_checkpoints():
                place.discard()
            place.close()
            raise
        return target

    def _about(self) -> dict[str, Any]:
        return {
            "scenario": self.configuration.scenario,
            "configuration_sha256": self.configuration.digest(),
            "fingerprint": self.fingerprint,
            "code": code_version(),
            "versions": versions(),
            "machine": machine(),
        }

    def _attributes(self) -> dict[str, Any]:
        configuration = self.configuration
        sources = sorted({entry.source for entry in configuration.items() if entry.source})
        return {
            "Conventions": "CF-1.10",
            "schema": SCHEMA,
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
    """The result stored in a folder, as it was; every file must agree with the hashes of the manifest.

    Raises ConfigurationError if there is none, and DamagedResult if it is not whole. Results of versions without a
    manifest are read as they are.
    """
    path = Path(folder)
    place = path if path.is_dir() or path.name != RESULT_FILE else path.parent
    recover(place)
    found = read_manifest(place)
    contents: dict[str, bytes] = {}
    if found is None:
        image = _without_manifest(place)
    elif RESULT_FILE not in found.files:
        raise ConfigurationError(
            f"{shown(str(place))} holds the record of a run that is {found.status.replace('_', ' ')} and has no "
            f"numbers; {SUMMARY_FILE} says why"
        )
    else:
        contents = {name: read_file(place, name, entry) for name, entry in found.files.items()}
        image = contents[RESULT_FILE]
    try:
        tables.take_in(contents)
        return _decoded(image, checked=found is not None)
    except (OSError, ValueError, KeyError, TypeError, RuntimeError) as error:
        raise damaged(place, f"{RESULT_FILE}: {' '.join(str(error).split())[:120]}") from None


def _without_manifest(place: Path) -> bytes:
    """The content of a result of a version without a manifest."""
    try:
        return read_regular(place / RESULT_FILE, LARGEST_RESULT)
    except (FileNotFoundError, NotADirectoryError):
        raise ConfigurationError(
            f"no result in {shown(str(place))}: {RESULT_FILE} is missing; run a scenario first"
        ) from None
    except OSError as error:
        raise damaged(place, f"{RESULT_FILE}: {error.strerror or error}") from None


def _decoded(image: bytes, checked: bool) -> Result:
    """The result in the content of result.nc. Raises the errors of the libraries, and ValueError."""
    import xarray

    with xarray.open_dataset(io.BytesIO(image), engine="h5netcdf") as stored:
        dataset = stored.load()
    if not checked and "schema" in dataset.attrs:
        raise ValueError(f"{MANIFEST_FILE} is missing")
    configuration = Configuration.from_toml(str(dataset.attrs["configuration"]))
    summary = json.loads(dataset.attrs["summary"])
    arrays = {str(name): np.asarray(dataset[name].values) for name in dataset.variables}
    remarks = tuple(text for text in str(dataset.attrs.get("remarks", "")).split(" | ") if text)
    return Result(configuration, summary, arrays, remarks)


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
    axial = max(float(np.abs(arrays[name]).max()) for name in ("oral_reaction", "anal_reaction", "axial_force"))
    momentum = arrays["momentum_residual"][np.isfinite(arrays["momentum_residual"])]

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
        "momentum_residual": float(np.abs(momentum).max(initial=0.0)) / max(axial, SMALLEST_FORCE),
        "simulated_s": simulated,
        "solver_wall_s": cost.get("solver_wall_s", 0.0),
        "compile_wall_s": cost.get("compile_wall_s", 0.0),
        "steps": int(time.size - 1),
        "version": __version__,
    }
    cleaned: dict[str, Any] = json_ready(summary)
    return cleaned
