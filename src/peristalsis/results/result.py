"""What a run leaves behind: a dataset with units, a summary, the configuration, and how they are stored."""

from __future__ import annotations

import hashlib
import importlib
import io
import json
import os
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._version import __version__
from ..errors import ConfigurationError, shown
from ..inputs import tables
from ..inputs.config import Configuration
from ..inputs.recording import probe_names
from ..inputs.shape import size_in_words
from ..names import CERTAIN, COORDINATES, OUTPUTS, PROBE, Output
from ..paths import located
from ..storing.disk import read_regular
from ..storing.environment import code_version, machine, versions
from ..storing.locks import Claim
from ..storing.manifest import FILE as MANIFEST_FILE
from ..storing.manifest import SCHEMA, Manifest
from ..storing.netcdf import netcdf_image
from ..storing.readonly import ReadOnly, unwritable
from ..storing.store import (
    CONFIGURATION_FILE,
    RECORDS,
    RESULT_FILE,
    SUMMARY_FILE,
    Workspace,
    check_target,
    damaged,
    read_file,
    read_manifest,
    recover,
    verify,
)
from . import acceptance
from .acceptance import MAY_BE_EMPTY
from .plain import json_ready as json_ready

if TYPE_CHECKING:
    import xarray

    from ..maps.of_run import RunMaps
    from ..plots import Plots

Floats = NDArray[np.float64]

LARGEST_RESULT = 4_000_000_000
"""Bytes of a file without a manifest that are read."""

CLOCK = ("solver_wall_s", "compile_wall_s")
"""Numbers of a summary that are times on the clock, different in every run."""

FOREIGN = (
    *(ArithmeticError, AttributeError, LookupError, MemoryError, OSError, RuntimeError, TypeError, ValueError),
    *(ConfigurationError, Warning),
)
"""What libraries raise when they are given a file that somebody else made."""
LEFT_OUT = (*CLOCK, CERTAIN)
"""Entries of a summary that a fingerprint leaves out."""

UNFINISHED = ("interrupted", "diverged")
"""Runs that broke off: their last checkpoint is kept with them."""


def _above(module: str, name: str) -> Any:
    """Something of the package that is made for results and stands above them, looked up by name when it is used.

    Pictures and maps import results; an import the other way round would close a circle.
    """
    return getattr(importlib.import_module(f"peristalsis.{module}"), name)


@dataclass(frozen=True, repr=False)
class Result:
    """One run: `dataset` (xarray, every output with its unit), `summary` (the numbers of --json), `configuration`.

    `status` and `error` say how it ended; `plot` draws its figures. Nothing of it can be changed: what is stored is
    what was computed. `dict(result.summary)` and `result.dataset.copy(deep=True)` are yours to change.
    """

    configuration: Configuration
    summary: Mapping[str, Any]
    arrays: Mapping[str, Floats]
    remarks: tuple[str, ...] = ()
    foreign: Mapping[str, Output] = field(default_factory=dict)
    """Outputs that were registered where the run was made and are not known here: by name, without their functions."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "summary", ReadOnly(self.summary))
        object.__setattr__(self, "arrays", ReadOnly({name: unwritable(one) for name, one in self.arrays.items()}))

    @property
    def status(self) -> str:
        """expelled, arrested, in_transit, finished, diverged or interrupted."""
        return str(self.summary["status"])

    @property
    def error(self) -> str | None:
        """Why the run broke off, or None."""
        text = self.summary.get("error")
        return None if text is None else str(text)

    def key_numbers(self) -> list[tuple[str, str]]:
        """What the run came to, in a few words and numbers each."""
        summary = self.summary
        numbers = (
            ("transit", "transit_s", "s"),
            ("travel", "travel_cm", "cm"),
            ("mean velocity", "mean_velocity_cm_s", "cm/s"),
            ("largest axial force", "max_axial_force_mN", "mN"),
            ("simulated", "simulated_s", "s"),
        )
        found = [(label, summary.get(key), unit) for label, key, unit in numbers]
        return [
            ("status", self.status.replace("_", " ")),
            *((label, f"{value:.4g} {unit}") for label, value, unit in found if isinstance(value, int | float)),
            *size_in_words(self.configuration),
        ]

    def __repr__(self) -> str:
        head = f"<peristalsis run {self.configuration.scenario}, reading {self.configuration.reading}>"
        lines = [head, *(f"  {label}: {words}" for label, words in self.key_numbers())]
        lines += [f"  error: {self.error}"] if self.error else []
        lines += [f"  remark: {remark}" for remark in self.remarks[:3]]
        more = len(self.remarks) - 3
        lines += [f"  and {more} more, in .remarks"] if more > 0 else []
        return "\n".join([*lines, "  see .summary, .dataset, .plot, .configuration"])

    def _repr_html_(self) -> str:
        from html import escape

        thumbnail = _above("plots.thumbnail", "thumbnail")
        about = escape(f"{self.configuration.scenario}, reading {self.configuration.reading}")
        rows = "".join(f"<tr><td>{escape(a)}</td><td>{escape(b)}</td></tr>" for a, b in self.key_numbers())
        notes = [*([f"error: {self.error}"] if self.error else []), *self.remarks]
        said = "".join(f"<li>{escape(note)}</li>" for note in notes)
        return (
            f"<div><b>peristalsis run {about}</b><table>{rows}</table>{thumbnail(self)}"
            f"{f'<ul>{said}</ul>' if said else ''}</div>"
        )

    @property
    def dataset(self) -> xarray.Dataset:
        """All outputs with dimensions, units and long names; the configuration and versions are attributes.

        A new one at each call, so that what is added to it or taken from it stays with the caller; its numbers are
        those of the result and cannot be written to.
        """
        return self._dataset.copy(deep=False)

    @cached_property
    def _dataset(self) -> xarray.Dataset:
        import xarray

        coordinates = {output.name for output in COORDINATES}
        variables = {}
        for name, values in self.arrays.items():
            output = self.foreign[name] if name in self.foreign else OUTPUTS[name]
            attributes = {"units": output.unit, "long_name": output.long_name}
            if not output.unit:  # of words
                del attributes["units"]
            variables[name] = (output.dimensions, values, attributes)
        data = {name: value for name, value in variables.items() if name not in coordinates}
        coords = {name: value for name, value in variables.items() if name in coordinates}
        return xarray.Dataset(data, coords, self._attributes())

    @property
    def plot(self) -> Plots:
        """The figures of this run: `result.plot.diameter_map()` and so on."""
        return _above("plots", "Plots")(self)

    @property
    def maps(self) -> RunMaps:
        """The maps of this run, the same objects as those of a recording: `result.maps.diameter` and so on."""
        return _above("maps.of_run", "RunMaps")(self)

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of every recorded number and of the summary, times on the clock left out: equal runs have one.

        It does not depend on how a run was stored, nor on the sign or payload of a nan.
        """
        digest = hashlib.sha256()
        numbers = {key: value for key, value in self.summary.items() if key not in LEFT_OUT}
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
        target = located(folder)
        check_target(target, overwrite)
        own = workspace is None
        place = Workspace(target, claim=Claim(target, alone=not overwrite)) if workspace is None else workspace
        try:
            image = netcdf_image(self.arrays, self._attributes(), self.foreign)
            summary = json.dumps(json_ready(self.summary), indent=2, allow_nan=False) + "\n"
            files = tables.files_of(self.configuration.naming_tables()) | {
                RESULT_FILE: image,
                CONFIGURATION_FILE: self.configuration.to_toml().encode("utf-8"),
                SUMMARY_FILE: summary.encode("utf-8"),
            }
            place.publish(files, self.status, self._about(), extras, self.status in UNFINISHED, overwrite)
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
            "remarks": list(self.remarks),
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
    """The result stored in a folder, or in a file result.nc, as it was; every file must agree with the manifest.

    Raises ConfigurationError if there is none, and DamagedResult if it is not whole or holds what no run can have. A
    file that was taken out of its folder, and results of versions without a manifest, are read as they are, with a
    remark that nothing vouches for them.
    """
    path = located(folder)
    place, file = (path.parent, path.name) if path.is_file() else (path, RESULT_FILE)
    recover(place)
    found = read_manifest(place) if file == RESULT_FILE else None
    remarks: tuple[str, ...] = ()
    contents: dict[str, bytes] = {}
    if found is None:
        image = _without_manifest(place, file)
        remarks = (f"{file} has no {MANIFEST_FILE} beside it: whether it is as it was written could not be checked",)
    elif RESULT_FILE not in found.files:
        _read_record(place, found)
        raise ConfigurationError(
            f"{shown(str(place))} holds the record of a run that is {found.status.replace('_', ' ')} and has no "
            f"numbers; {SUMMARY_FILE} says why"
        )
    else:
        contents = {name: read_file(place, name, entry) for name, entry in found.files.items()}
        image = contents[RESULT_FILE]
    try:
        tables.take_in(contents)
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # what libraries have to say of a foreign file is no business of the user's
            result = _decoded(image, remarks, alone=not (place / SUMMARY_FILE).exists())
        if found is not None and found.status != result.status:
            raise ValueError(f"it is {result.status}, and {MANIFEST_FILE} says {found.status}")
        return result
    except FOREIGN as error:
        raise damaged(path, f"{file}: {' '.join(str(error).split())[:160]}") from None


def check(folder: str | os.PathLike[str]) -> Manifest:
    """The manifest of a stored run whose files agree with it and hold a result, or the record of why there is none.

    Raises DamagedResult, and ConfigurationError if there is no manifest.
    """
    place = Path(folder)
    found = verify(place)
    if RESULT_FILE in found.files:
        load(place)
    else:
        _read_record(place, found)
    return found


def _read_record(place: Path, found: Manifest) -> None:
    """See to it that a result without numbers is the record of a run that has none."""
    if found.status not in RECORDS:
        raise damaged(place, f"{MANIFEST_FILE} lists no {RESULT_FILE}, and the run is {found.status}")
    read_summary(place, found)


def read_summary(place: Path, found: Manifest) -> dict[str, Any]:
    """The summary of a stored run or record. Raises DamagedResult if it is none."""
    try:
        summary = json.loads(read_file(place, SUMMARY_FILE, found.files[SUMMARY_FILE]))
        if RESULT_FILE in found.files:
            acceptance.check_summary(summary)
        else:
            acceptance.check_record(summary)
        if summary["status"] != found.status:
            raise ValueError(f"{MANIFEST_FILE} says {found.status}")
    except (KeyError, ValueError, RecursionError) as error:
        raise damaged(place, f"{SUMMARY_FILE}: {' '.join(str(error).split())[:120]}") from None
    return dict(summary)


def _without_manifest(place: Path, file: str) -> bytes:
    """The content of a file that is alone, or of a result of a version without a manifest."""
    try:
        return read_regular(place / file, LARGEST_RESULT)
    except (FileNotFoundError, NotADirectoryError):
        raise ConfigurationError(
            f"no result in {shown(str(place))}: {RESULT_FILE} is missing; run a scenario first"
        ) from None
    except OSError as error:
        raise damaged(place, f"{file}: {error.strerror or error}") from None


def _decoded(image: bytes, remarks: tuple[str, ...], alone: bool) -> Result:
    """The result in the content of result.nc. Raises ValueError where it is none, and the errors of the libraries."""
    import xarray

    with xarray.open_dataset(io.BytesIO(image), engine="h5netcdf") as stored:
        acceptance.check_sizes({str(name): stored[name].nbytes for name in stored.variables}, image)
        if remarks and "schema" in stored.attrs and not alone:
            raise ValueError(f"{MANIFEST_FILE} is missing")
        configuration = Configuration.from_record(str(stored.attrs["configuration"]))
        at_probes = probe_names(configuration.cells())  # outputs of its cells are known from here on
        known = [str(name) for name in stored.variables if name in OUTPUTS]
        foreign = {name: _foreign(name, stored[name]) for name in map(str, stored.variables) if name not in OUTPUTS}
        summary = json.loads(str(stored.attrs["summary"]))
        acceptance.check_summary(summary, configuration.scenario)
        found = {name: (tuple(map(str, stored[name].dims)), stored[name].shape) for name in known}
        steps = stored.sizes["time_step"]
        for name, output in OUTPUTS.items():  # what lies on a dimension without length is not in the file
            lacking = [one for one in output.dimensions if one in MAY_BE_EMPTY and one not in stored.sizes]
            if name not in found and lacking and (output.dimensions != PROBE or name in at_probes):
                found[name] = output.dimensions, tuple(0 if one in lacking else steps for one in output.dimensions)
        acceptance.check_shapes(found, configuration)
        arrays = {
            name: np.asarray(stored[name].values) if name in known else np.zeros(found[name][1]) for name in found
        }
        arrays |= {name: np.asarray(stored[name].values) for name in foreign}
        said = str(stored.attrs.get("remarks", ""))
    for name in acceptance.TEXTS:
        if name in arrays and name in found:
            arrays[name] = arrays[name].astype(object)
    acceptance.check_numbers(arrays, configuration.pellet.enabled)
    return Result(configuration, summary, arrays, (*(text for text in said.split(" | ") if text), *remarks), foreign)


def _foreign(name: str, variable: xarray.DataArray) -> Output:
    """An output that was registered where the run was made."""
    unit, long_name = (str(variable.attrs.get(key, "")) for key in ("units", "long_name"))
    return Output(name, tuple(map(str, variable.dims)), unit, long_name)
