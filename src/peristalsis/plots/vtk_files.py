"""Writes surfaces of polygons as VTK XML files (.vtp) and series of them (.pvd), as ParaView opens them.

The format is that of the VTK file formats page, version 1.0: one piece, arrays as base64 of zlib blocks with 64-bit
headers, little-endian. Numbers are kept to single precision: these files are for looking at, `result.nc` for numbers.
"""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

BLOCK = 1 << 20
"""Bytes of a compressed block."""

_HEAD = (
    '<?xml version="1.0"?>\n'
    '<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64"{more}>\n'
)


def write_polygons(
    path: Path, points: NDArray[np.float64], polygons: NDArray[np.int64], fields: Mapping[str, NDArray[np.float64]]
) -> None:
    """Write one surface. points: (n, 3); polygons: (k, corners) of point numbers; fields: name to (n,) or (n, 3)."""
    corners = polygons.shape[1]
    offsets = corners * np.arange(1, polygons.shape[0] + 1)
    data = "".join(_array(name, np.asarray(values, np.float32)) for name, values in fields.items())
    text = (
        _HEAD.format(kind="PolyData", more=' compressor="vtkZLibDataCompressor"')
        + f'<PolyData>\n<Piece NumberOfPoints="{points.shape[0]}" NumberOfVerts="0" NumberOfLines="0" '
        + f'NumberOfStrips="0" NumberOfPolys="{polygons.shape[0]}">\n'
        + f"<PointData>\n{data}</PointData>\n"
        + f"<Points>\n{_array('Points', np.asarray(points, np.float32))}</Points>\n"
        + f"<Polys>\n{_array('connectivity', polygons.ravel())}{_array('offsets', offsets)}</Polys>\n"
        + "</Piece>\n</PolyData>\n</VTKFile>\n"
    )
    path.write_text(text, encoding="ascii", newline="\n")


def write_series(path: Path, files: Iterable[tuple[float, str]]) -> None:
    """Write the list of a series: (time [s], file relative to the list), in the order of time."""
    entries = "".join(
        f'<DataSet timestep="{time!r}" group="" part="0" file={quoteattr(name)}/>\n' for time, name in files
    )
    text = _HEAD.format(kind="Collection", more="") + f"<Collection>\n{entries}</Collection>\n</VTKFile>\n"
    path.write_text(text, encoding="ascii", newline="\n")


def _array(name: str, values: NDArray[Any]) -> str:
    kind = {"f": "Float32", "i": "Int64"}[values.dtype.kind]
    components = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    packed = values.astype("<f4" if kind == "Float32" else "<i8").tobytes()
    return (
        f'<DataArray type="{kind}" Name={quoteattr(name)}{components} format="binary">{_encoded(packed)}</DataArray>\n'
    )


def _encoded(content: bytes) -> str:
    """Header of block sizes, then the blocks, each in base64 of its own."""
    blocks = [content[start : start + BLOCK] for start in range(0, len(content), BLOCK)]
    packed = [zlib.compress(block, 4) for block in blocks]
    last = len(content) % BLOCK
    head = struct.pack(f"<{3 + len(packed)}Q", len(packed), BLOCK, last, *map(len, packed))
    return base64.b64encode(head).decode() + base64.b64encode(b"".join(packed)).decode()
