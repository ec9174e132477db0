"""Maps in NetCDF and .mat files: read whatever their variables are called, written under names with units."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError, shown
from .recording import QUANTITIES, Floats, Map, Numbers, factor, locked
from .stated import Stated, finished
from .text_files import content_of
from .words import LENGTHS, PRESSURES, quantity_of

HDF5, CLASSIC, MATLAB = b"\x89HDF", b"CDF", b"MATLAB 5.0"
TIMES, PLACES = r"t|times?(_.*)?", r"x|z|y|places?(_.*)?|positions?(_.*)?|distances?(_.*)?|length(_.*)?"


class Array(NamedTuple):
    """A variable of a file: numbers, the unit it states, the names of its dimensions if it has such."""

    values: Numbers
    unit: str | None
    dimensions: tuple[str, ...] | None


def read_arrays(path: Path, said: Stated) -> Map:
    """The map in a NetCDF (classic or 4) or .mat (to 7.3) file. Raises ConfigurationError."""
    content = content_of(path)
    try:
        found, about = _variables(content, path)
    except ConfigurationError:
        raise
    except Exception as error:  # the libraries raise whatever a broken file makes them stumble on
        cause = " ".join(str(error).split())[:100] or type(error).__name__
        raise ConfigurationError(f"{shown(str(path))} cannot be read: {cause}; export it anew") from None
    name = shown(str(path))
    key = _chosen({one: array for one, array in found.items() if array.values.ndim == 2}, said, name)
    array = found[key]
    time, place, turned = _axes(array, found, said, name)
    values = array.values.T if turned else array.values
    if values.dtype.kind not in "fiu":
        raise ConfigurationError(f"{name}: {key} holds no numbers but {values.dtype}; name another variable")
    values = np.array(values, dtype=np.float32 if values.dtype == np.float32 else np.float64)
    history = [*about, f"read from {path.name}, variable {key}"]
    unit = array.unit or _unit_in(key)
    return finished(
        path,
        locked(values),
        time,
        place,
        (quantity_of(key, unit), unit),
        said,
        history,
        ("variable", "time_unit", "place_unit"),
    )


def _variables(content: bytes, path: Path) -> tuple[dict[str, Array], list[str]]:
    """All arrays of numbers in a file, and the lines of its history."""
    if content.startswith(HDF5) and path.suffix.lower() == ".mat":
        import h5py

        with h5py.File(io.BytesIO(content), "r") as file:
            sets = {key: np.asarray(one).T for key, one in file.items() if hasattr(one, "shape")}
        return {key: Array(_flat(one), None, None) for key, one in sets.items() if one.dtype.kind in "fiu"}, []
    if content.startswith(HDF5):
        import h5netcdf

        with h5netcdf.File(io.BytesIO(content), "r") as file:
            read = {
                key: Array(np.asarray(one[...]), _text(one.attrs.get("units")), tuple(one.dimensions))
                for key, one in file.variables.items()
            }
            return read, _lines(_text(file.attrs.get("history")))
    if content.startswith(CLASSIC):
        from scipy.io import netcdf_file

        with netcdf_file(io.BytesIO(content), "r", mmap=False, maskandscale=True) as file:
            read = {
                key: Array(_plain(one[:]), _text(getattr(one, "units", None)), tuple(one.dimensions))
                for key, one in file.variables.items()
            }
            return read, _lines(_text(getattr(file, "history", None)))
    if content.startswith(MATLAB):
        from scipy.io import loadmat

        loaded = {key: one for key, one in loadmat(io.BytesIO(content)).items() if not key.startswith("__")}
        about = [str(np.ravel(one)[0]).rstrip() for one in np.ravel(loaded.get("history", [])) if np.size(one)]
        arrays = {key: _flat(one) for key, one in loaded.items() if np.asarray(one).dtype.kind in "fiu"}
        return {key: Array(one, None, None) for key, one in arrays.items()}, about
    raise ConfigurationError(f"{shown(str(path))} is no NetCDF and no .mat file; export it anew")


def _plain(values: Any) -> Numbers:
    native: Numbers = np.ma.filled(np.ma.asarray(values).astype(np.asarray(values).dtype.newbyteorder("=")), np.nan)
    return native


def _flat(values: Any) -> Numbers:
    """A row or column of .mat, where everything has two dimensions, as a vector."""
    array = np.asarray(values)
    return array.ravel() if array.ndim == 2 and 1 in array.shape else array


def _text(value: Any) -> str | None:
    if value is None:
        return None
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _lines(text: str | None) -> list[str]:
    return [line for line in (text or "").splitlines() if line]


def _chosen(maps: Mapping[str, Array], said: Stated, name: str) -> str:
    if said.variable is not None:
        if said.variable not in maps:
            raise ConfigurationError(
                f"{name} has no map {shown(said.variable)} but {', '.join(maps) or 'none at all'}; name one of these"
            )
        return said.variable
    if len(maps) != 1:
        listed = ", ".join(list(maps)[:8])
        raise ConfigurationError(
            f"{name} holds {len(maps)} arrays of two dimensions ({listed or 'none'}); name one (variable, --variable)"
        )
    return next(iter(maps))


def _axes(array: Array, found: Mapping[str, Array], said: Stated, name: str) -> tuple[Floats, Floats, bool]:
    """Times [s], places [mm], and whether the array has its places down and times across."""
    rows, columns = array.values.shape
    if array.dimensions is not None:
        names = array.dimensions
        turned = re.fullmatch(TIMES, names[1].lower()) is not None
        pair = names[::-1] if turned else names
        axes = [(one, found.get(one)) for one in pair]
    else:
        vectors = {key: one for key, one in found.items() if one.values.ndim == 1}
        axes = [_vector(vectors, pattern, what, name) for pattern, what in ((TIMES, "times"), (PLACES, "places"))]
        sizes = tuple(one.values.size for _, one in axes if one is not None)
        turned = sizes == (columns, rows) and rows != columns
    for (key, one), size in zip(axes, (columns, rows) if turned else (rows, columns), strict=True):
        if one is None or one.values.ndim != 1 or one.values.size != size:
            raise ConfigurationError(
                f"{name}: the axis {shown(key)} of {size} entries is missing; store it with the map"
            )
    (t_key, t), (x_key, x) = axes
    assert t is not None
    assert x is not None
    time = _converted(t, t_key, "s", said.time_unit, "time_unit", name)
    return time, _converted(x, x_key, "mm", said.place_unit, "place_unit", name), turned


def _vector(vectors: Mapping[str, Array], pattern: str, what: str, name: str) -> tuple[str, Array]:
    chosen = [key for key in vectors if re.fullmatch(pattern, key.lower())]
    if len(chosen) != 1:
        raise ConfigurationError(
            f"{name}: which of {', '.join(vectors) or 'no vectors'} holds the {what} cannot be told; call it "
            f"{what[:-1]}_{'s' if what == 'times' else 'mm'}"
        )
    return chosen[0], vectors[chosen[0]]


def _converted(array: Array, key: str, wanted: str, stated: str | None, option: str, name: str) -> Floats:
    unit = stated or array.unit or _unit_in(key)
    if unit is None:
        raise ConfigurationError(f"{name}: the unit of {key} is not stated; state {option} = {wanted}, for example")
    unit = {"seconds": "s", "second": "s", "minutes": "min"}.get(unit, unit)
    return np.asarray(array.values, dtype=np.float64) * factor(unit, wanted, f"{name}, unit of {key}")


def _unit_in(key: str) -> str | None:
    """A unit at the end of a name, such as "diameter_mm"."""
    last = key.rpartition("_")[2]
    known = {one.lower(): one for one in (*LENGTHS, *PRESSURES, "s", "ms", "min")}
    return known.get(last.lower()) if "_" in key else None


def write_netcdf(recorded: Map, path: Path) -> Path:
    """Write a map as NetCDF-4 of the classic model, with units, names and history; nothing is lost."""
    import h5netcdf

    image = io.BytesIO()
    with h5netcdf.File(image, "w") as file:
        file.attrs["Conventions"] = np.bytes_(b"CF-1.10")
        file.attrs["title"] = np.bytes_(recorded.name.encode())
        file.attrs["history"] = np.bytes_("\n".join(recorded.history).encode())
        file.dimensions = {"time": recorded.time.size, "place": recorded.place.size}
        axes: Sequence[tuple[str, Floats, str, str]] = (
            ("time", recorded.time, "s", "time"),
            ("place", recorded.place, "mm", "distance from the oral end"),
        )
        for key, values, unit, words in axes:
            axis = file.create_variable(key, (key,), data=values)
            axis.attrs["units"], axis.attrs["long_name"] = np.bytes_(unit.encode()), np.bytes_(words.encode())
        more: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
        variable = file.create_variable(
            recorded.quantity,
            ("time", "place"),
            data=recorded.values,
            fillvalue=recorded.values.dtype.type(np.nan),
            **more,
        )
        variable.attrs["units"] = np.bytes_(recorded.unit.encode())
        variable.attrs["long_name"] = np.bytes_(QUANTITIES[recorded.quantity].label.encode())
    path.write_bytes(image.getvalue())
    return path


def write_mat(recorded: Map, path: Path) -> Path:
    """Write a map as .mat of version 5: time_s, place_mm, diameter_mm (or so), history; nothing is lost."""
    from scipy.io import savemat

    unit = "" if recorded.unit == "1" else f"_{recorded.unit}"
    image = io.BytesIO()
    savemat(
        image,
        {
            "time_s": recorded.time,
            "place_mm": recorded.place,
            f"{recorded.quantity}{unit}": recorded.values,
            "history": np.array(recorded.history, dtype=object),
        },
        do_compression=True,
        oned_as="column",
    )
    path.write_bytes(image.getvalue())
    return path
