"""Arrays as the bytes of a NetCDF-4 file, written without xarray, which takes longer to import than this to write."""

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
    import h5netcdf

    coordinates = {output.name for output in COORDINATES}
    image = io.BytesIO()
    with h5netcdf.File(image, "w") as file:
        for name, value in attributes.items():
            if value != "":
                file.attrs[name] = _characters(value) if isinstance(value, str) else np.int32(value)
        for name, given in arrays.items():
            output = foreign[name] if name in foreign else OUTPUTS[name]
            values = np.asarray(given)
            if 0 in values.shape:
                continue
            dimensions, more = output.dimensions, dict[str, Any]()
            if values.dtype.kind in "OUT":
                values = np.char.encode(values.astype(str), "utf-8")
                width = max(values.dtype.itemsize, 1)
                values = values.astype(f"S{width}").view("S1").reshape(*values.shape, width)
                dimensions = (*dimensions, f"{name}_length")
                more["dtype"] = "S1"
            elif name not in coordinates:
                more["fillvalue"] = np.nan
            for dimension, size in zip(dimensions, values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.dimensions[dimension] = size
            if values.size > LARGE:
                more |= {"compression": "gzip", "compression_opts": 1, "shuffle": True}
            variable = file.create_variable(name, dimensions, data=values, **more)
            about = {"units": output.unit, "long_name": output.long_name}
            if values.dtype.kind == "S":
                about["_Encoding"] = "utf-8"
            for key, text in about.items():
                if text:
                    variable.attrs[key] = _characters(text)
    return image.getvalue()


def _characters(text: str) -> Any:
    """A text as characters of fixed length, which any program reads; one that is too long for that as it is."""
    content = text.encode("utf-8")
    return np.bytes_(content) if len(content) <= LONGEST_ATTRIBUTE else text
