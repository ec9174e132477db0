"""Arrays as the bytes of a NetCDF-4 file, written without xarray, which takes longer to import than this to write."""

from __future__ import annotations

import io
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .names import OUTPUTS, Output

LARGE = 1_000
"""Arrays with more numbers than this are compressed."""


def netcdf_image(
    arrays: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, str | int],
    foreign: Mapping[str, Output] = MappingProxyType({}),
) -> bytes:
    """The content of a file with these outputs, numbers or texts, each with its dimensions, unit and long name.

    foreign: outputs that `names` does not have.

    Built in memory: the HDF5 library does not survive a disk that fills up under an open file.
    """
    import h5netcdf
    import h5py

    image = io.BytesIO()
    with h5netcdf.File(image, "w") as file:
        file.attrs.update(attributes)
        for name, given in arrays.items():
            output = foreign[name] if name in foreign else OUTPUTS[name]
            values = np.asarray(given)
            for dimension, size in zip(output.dimensions, values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.dimensions[dimension] = size
            more: dict[str, Any] = {}
            if values.dtype.kind in "OUT":
                values, more["dtype"] = values.astype(object), h5py.string_dtype()
            else:
                more["fillvalue"] = np.nan
            if values.size > LARGE:
                more |= {"compression": "gzip", "compression_opts": 1, "shuffle": True}
            variable = file.create_variable(name, output.dimensions, data=values, **more)
            variable.attrs.update({"units": output.unit, "long_name": output.long_name})
    return image.getvalue()
