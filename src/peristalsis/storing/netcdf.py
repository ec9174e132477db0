"""Arrays as the bytes of a NetCDF-4 file, by h5py alone.

What makes an HDF5 file a NetCDF-4 file is little: dimensions are scales that variables are attached to, with a number
each (The NetCDF-4 file format, NetCDF user's guide, appendix). Libraries for it take longer to keep track of that than
the data take to be written, and longer to be imported.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..names import COORDINATES, OUTPUTS, Output

LARGE = 1_000
"""Arrays with more numbers than this are compressed."""

CHUNK = 2**16
"""Bytes that are compressed together: a picture of one moment reads little more than it needs."""

PLACE = "This is a netCDF dimension but not a netCDF variable.%10d"
"""What NetCDF-4 calls a scale that only says how long its dimension is."""

LONGEST_ATTRIBUTE = 60_000
"""Bytes of an attribute of fixed length; HDF5 keeps at most 64 KiB in this way."""


def netcdf_image(
    arrays: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, str | int],
    foreign: Mapping[str, Output] = MappingProxyType({}),
) -> bytes:
    """The content of a file with these outputs, numbers or texts, each with its dimensions, unit and long name.

    foreign: outputs that `names` does not have. Of the classic data model, so that every program reads it: texts are
    arrays of characters, integers have 32 bits, and what lies on a dimension without length is left out (a length of 0
    would mean "unlimited"). Built in memory: the HDF5 library does not survive a disk that fills up under an open file.
    """
    import h5py

    coordinates = {output.name for output in COORDINATES}
    image = io.BytesIO()
    with h5py.File(image, "w", track_order=True) as file:
        for name, value in attributes.items():
            if value != "":
                file.attrs[name] = _characters(value) if isinstance(value, str) else np.array([value], dtype=np.int32)
        file.attrs["_NCProperties"] = _characters(f"version=2,h5py={h5py.__version__},hdf5={h5py.version.hdf5_version}")
        scales = _Scales(file)
        outputs = {name: foreign[name] if name in foreign else OUTPUTS[name] for name in arrays}
        # What measures a dimension comes first: it is the scale of the others.
        for name in sorted(arrays, key=lambda name: outputs[name].dimensions != (name,)):
            output, values = outputs[name], np.asarray(arrays[name])
            if 0 in values.shape:
                continue
            dimensions, about = output.dimensions, {"units": output.unit, "long_name": output.long_name}
            more = dict[str, Any]()
            if values.dtype.kind in "OUT":
                values = np.char.encode(values.astype(str), "utf-8")
                width = max(values.dtype.itemsize, 1)
                values = values.astype(f"S{width}").view("S1").reshape(*values.shape, width)
                dimensions = (*dimensions, f"{name}_length")
                about["_Encoding"] = "utf-8"
            elif name not in coordinates:
                more["fillvalue"] = np.nan
            if values.size > LARGE:
                more |= {"compression": "gzip", "compression_opts": 1, "shuffle": True, "chunks": _chunks(values)}
            variable = scales.variable(name, dimensions, values, more)
            if "fillvalue" in more:
                variable.attrs["_FillValue"] = np.array([np.nan], dtype=values.dtype)
            for key, text in about.items():
                if text:
                    variable.attrs[key] = _characters(text)
        scales.attach()
    return image.getvalue()


class _Scales:
    """The dimensions of a file: a variable of the same name, or a place that only says how long the dimension is.

    Variables are attached at once at the end: HDF5 writes the list of a scale's variables anew with each.
    """

    def __init__(self, file: Any) -> None:
        self._file = file
        self._scales: dict[str, Any] = {}
        self._attached: list[tuple[Any, tuple[str, ...]]] = []

    def variable(self, name: str, dimensions: tuple[str, ...], values: NDArray[Any], more: dict[str, Any]) -> Any:
        """A new variable on these dimensions."""
        own = dimensions == (name,)
        for dimension, size in zip(dimensions, values.shape, strict=True):
            if dimension not in self._scales and not own:
                self._begin(self._file.create_dataset(dimension, shape=(size,), dtype=">f4"), dimension, PLACE % size)
        made = self._file.create_dataset(name, data=values, track_times=False, track_order=True, **more)
        if own:
            self._begin(made, name, name)
        else:
            self._attached.append((made, dimensions))
        return made

    def _begin(self, scale: Any, dimension: str, title: str) -> None:
        scale.make_scale(title)
        scale.attrs["_Netcdf4Dimid"] = np.int32(len(self._scales))
        self._scales[dimension] = scale

    def attach(self) -> None:
        """Attach every variable to its dimensions."""
        numbers = {name: number for number, name in enumerate(self._scales)}
        for variable, dimensions in self._attached:
            variable.attrs["_Netcdf4Coordinates"] = np.array([numbers[one] for one in dimensions], dtype=np.int32)
            for place, dimension in enumerate(dimensions):
                variable.dims[place].attach_scale(self._scales[dimension])


def _chunks(values: NDArray[Any]) -> tuple[int, ...]:
    """Pieces in which an array is compressed: whole rows, some `CHUNK` bytes of them."""
    rows = max(1, CHUNK * len(values) // values.nbytes)
    return (min(rows, len(values)), *values.shape[1:])


def _characters(text: str) -> Any:
    """A text as characters of fixed length, which any program reads; one that is too long for that as it is."""
    content = text.encode("utf-8")
    return np.bytes_(content) if len(content) <= LONGEST_ATTRIBUTE else text
