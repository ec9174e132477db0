"""Maps as grey pictures, TIFF or PNG of 8 or 16 bit: read with their scale, written so that ImageJ opens them with it.

The scale of a TIFF is where ImageJ keeps it: pixels per unit in the tags XResolution and YResolution, units and the
straight line from grey to value (c0, c1, vunit) in the lines of ImageDescription. In a PNG the same lines stand in its
text. The values of pixels are those at their origin: the time of column k is (k - xorigin) times the width of a pixel.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError, shown
from .recording import MOST_VALUES, QUANTITIES, Floats, Map, Numbers, locked
from .stated import Stated, finished
from .text_files import content_of

DESCRIPTION, X_RESOLUTION, Y_RESOLUTION, RESOLUTION_UNIT = 270, 282, 283, 296
SECONDS = {"s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3, "min": 60.0, "h": 3600.0}
MILLIMETRES = {
    "mm": 1.0,
    "cm": 10.0,
    "m": 1000.0,
    "um": 1e-3,
    "micron": 1e-3,
    "microns": 1e-3,
    "µm": 1e-3,
    "\\u00B5m": 1e-3,
    "inch": 25.4,
    "in": 25.4,
}
TEXT = "Description"
"""Key of the text of a PNG."""


class Scale(NamedTuple):
    """What a file says of its pixels: width (x) and height (y), their units, the pixel of the origin in each."""

    size: tuple[float, float]
    units: tuple[str, str]
    origin: tuple[float, float]


def read_picture(path: Path, said: Stated) -> Map:
    """The map in a grey picture. Raises ConfigurationError naming what is not stated or cannot be read."""
    grey, lines, scale = _opened(path)
    name, history = shown(str(path)), [*_history(lines), f"read from {path.name}, {grey.dtype.itemsize * 8} bit"]
    direction = said.time or _direction(scale) or "right"
    if said.time is None and _direction(scale) is None:
        history.append("time runs right, by default")
    across = (0, 1) if direction == "right" else (1, 0)  # axis of time, axis of place
    step, first = _axis(scale, across[0], said.s_per_px, SECONDS, "s_per_px (--s-per-px)", name)
    distance, begin = _axis(scale, across[1], said.mm_per_px, MILLIMETRES, "mm_per_px (--mm-per-px)", name)
    if scale is None or said.mm_per_px is not None or said.s_per_px is not None:
        history.append(f"scale {distance:g} mm/px and {step:g} s/px, as stated")
    else:
        history.append(f"scale {distance:.9g} mm/px and {step:.9g} s/px, of the file")
    turned = grey.T if direction == "right" else grey
    values, unit = _valued(turned, lines, said, name, history)
    time = first + step * np.arange(turned.shape[0], dtype=np.float64)
    place = begin + distance * np.arange(turned.shape[1], dtype=np.float64)
    quantity = lines.get("quantity")
    if quantity is None and said.quantity is None and unit == "mm":
        quantity = "diameter"
    return finished(
        path, values, time, place, (quantity, unit), said, history, ("mm_per_px", "s_per_px", "grey", "gap", "time")
    )


def write_picture(recorded: Map, path: Path, bits: int = 16, time: str = "right") -> Path:
    """Write a map as a grey picture with its scale, .tif or .png; grey 0 is a gap, and the step is in its lines.

    Half a step, (highest - lowest) / 65534 / 2 of 16 bit or / 254 / 2 of 8 bit, is what is lost. bits: 8 or 16. time:
    runs right, places down, or down, places to the right. Raises ConfigurationError where the axes are not even.
    """
    from PIL import Image, PngImagePlugin, TiffImagePlugin

    if bits not in (8, 16):
        raise ConfigurationError(f"bits = {shown(bits)}: a picture has 8 or 16; choose one")
    steps = (recorded.time_step(), recorded.place_step())
    low, high = float(np.nanmin(recorded.values)), float(np.nanmax(recorded.values))
    most = 2**bits - 1
    step = (high - low) / (most - 1) or 1.0
    levels = np.round((recorded.values - low) / step) + 1.0
    grey = np.where(np.isnan(levels), 0.0, np.clip(levels, 1.0, most)).astype(np.uint16 if bits == 16 else np.uint8)
    origins = (-float(recorded.time[0]) / steps[0], -float(recorded.place[0]) / steps[1])
    order = (0, 1) if time == "right" else (1, 0)
    units = ("sec", "mm")
    lines = {
        "ImageJ": "1.53k",
        "unit": units[order[0]],
        "yunit": units[order[1]],
        "xorigin": repr(origins[order[0]]),
        "yorigin": repr(origins[order[1]]),
        "cf": "0",
        "c0": repr(low - step),
        "c1": repr(step),
        "vunit": recorded.unit,
        "min": "1",
        "max": str(most),
        "quantity": recorded.quantity,
        "gap": "0",
        "pixelwidth": repr(steps[order[0]]),
        "pixelheight": repr(steps[order[1]]),
        "history": " | ".join(recorded.history).replace("\n", " "),
    }
    text = "".join(f"{key}={value}\n" for key, value in lines.items())
    picture = Image.fromarray(np.ascontiguousarray(grey.T if time == "right" else grey))
    image = io.BytesIO()
    if path.suffix.lower() == ".png":
        about = PngImagePlugin.PngInfo()
        about.add_text(TEXT, text)
        picture.save(image, "PNG", pnginfo=about)
    else:
        tags = TiffImagePlugin.ImageFileDirectory_v2()
        tags[DESCRIPTION] = text.encode("ascii", "replace").decode("ascii")
        tags[RESOLUTION_UNIT] = 1
        tags[X_RESOLUTION] = TiffImagePlugin.IFDRational(*_fraction(1.0 / steps[order[0]]))
        tags[Y_RESOLUTION] = TiffImagePlugin.IFDRational(*_fraction(1.0 / steps[order[1]]))
        picture.save(image, "TIFF", tiffinfo=tags)
    path.write_bytes(image.getvalue())
    return path


def _fraction(value: float) -> tuple[int, int]:
    """A number as the fraction of two integers of 32 bits that a tag holds, to nine digits."""
    from fractions import Fraction

    found = Fraction(value).limit_denominator(1_000_000)
    return found.numerator, found.denominator


def _opened(path: Path) -> tuple[Numbers, dict[str, str], Scale | None]:
    """Grey values as stored, (height, width), the lines of the description, and the scale if there is one."""
    from PIL import Image, UnidentifiedImageError

    name, content = shown(str(path)), content_of(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a long recording is a large picture, and is meant
            with Image.open(io.BytesIO(content)) as picture:
                if picture.width * picture.height > MOST_VALUES:
                    raise ConfigurationError(
                        f"{name} has {picture.width} x {picture.height} pixels, more than {MOST_VALUES}; cut it"
                    )
                pages = int(getattr(picture, "n_frames", 1))
                if pages > 1:
                    raise ConfigurationError(f"{name} has {pages} pages; save the one that is the map")
                pixels = np.asarray(picture)
                tags: Mapping[int, Any] = dict(getattr(picture, "tag_v2", {}))
                text = str(tags.get(DESCRIPTION, "") or picture.info.get(TEXT, ""))
                mode = picture.mode
    except ConfigurationError:
        raise
    except (UnidentifiedImageError, OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        cause = "it is no picture" if isinstance(error, UnidentifiedImageError) else " ".join(str(error).split())[:100]
        raise ConfigurationError(f"{name} cannot be read: {cause}; save it as TIFF or PNG, grey, 8 or 16 bit") from None
    if pixels.ndim == 3:
        pixels = _without_colour(pixels, name)
    if mode in ("P", "1", "CMYK") or pixels.ndim != 2:
        raise ConfigurationError(f"{name} is a picture of mode {mode}, not of greys; save it as grey, 8 or 16 bit")
    lines = dict(line.partition("=")[::2] for line in text.splitlines() if "=" in line)
    return pixels, lines, _scale(tags, lines)


def _without_colour(pixels: Numbers, name: str) -> Numbers:
    if not (pixels[..., :3] == pixels[..., :1]).all():
        raise ConfigurationError(
            f"{name} is in colours, whose order from low to high nobody states; export the map as grey, 8 or 16 bit"
        )
    return pixels[..., 0]


def _scale(tags: Mapping[int, Any], lines: Mapping[str, str]) -> Scale | None:
    """The scale in ImageJ's tags, or in lines of ours; a resolution in dots per inch alone is none."""
    if "pixelwidth" in lines:
        size = (_number(lines["pixelwidth"]), _number(lines.get("pixelheight", "1")))
    elif lines.get("ImageJ") and X_RESOLUTION in tags and Y_RESOLUTION in tags:
        per_unit = (float(tags[X_RESOLUTION]), float(tags[Y_RESOLUTION]))
        if not all(0.0 < one < float("inf") for one in per_unit):
            return None
        size = (1.0 / per_unit[0], 1.0 / per_unit[1])
    else:
        return None
    unit = lines.get("unit") or {2: "inch", 3: "cm"}.get(int(tags.get(RESOLUTION_UNIT, 1)), "")
    if not unit:
        return None
    origin = (_number(lines.get("xorigin", "0")), _number(lines.get("yorigin", "0")))
    return Scale(size, (unit, lines.get("yunit") or unit), origin)


def _direction(scale: Scale | None) -> str | None:
    """Whether time runs right or down, where the units tell."""
    across, down = (unit in SECONDS for unit in scale.units) if scale is not None else (False, False)
    return None if across == down else "right" if across else "down"


def _axis(
    scale: Scale | None, which: int, stated: float | None, known: Mapping[str, float], option: str, name: str
) -> tuple[float, float]:
    """Step and first value of an axis, in s or mm."""
    if stated is not None:
        return stated, 0.0
    if scale is None or scale.units[which] not in known:
        said = f"in {shown(scale.units[which])}" if scale is not None else "nowhere"
        raise ConfigurationError(f"{name}: the scale of its pixels is {said}; state {option}, such as 0.1")
    step = scale.size[which] * known[scale.units[which]]
    return step, -scale.origin[which] * step


def _valued(
    grey: Numbers, lines: Mapping[str, str], said: Stated, name: str, history: list[str]
) -> tuple[Floats, str | None]:
    """Values of grey pixels by the stated calibration or that of the file, gaps as nan; and their unit."""
    gap = said.gap if said.gap is not None else int(_number(lines["gap"])) if "gap" in lines else None
    if said.grey is not None:
        (g0, v0), (g1, v1) = said.grey
        slope = (v1 - v0) / (g1 - g0)
        base, unit = v0 - slope * g0, None
        unit = said.unit or QUANTITIES[said.quantity or lines.get("quantity", "diameter")].unit
        history.append(f"grey {g0:g} is {v0:g} {unit} and {g1:g} is {v1:g} {unit}, as stated")
    elif lines.get("cf") == "0" and "c0" in lines and "c1" in lines:
        base, slope = _number(lines["c0"]), _number(lines["c1"])
        unit = lines.get("vunit", "").strip() or None
        history.append(f"value = {base:.9g} + {slope:.9g} grey, of the file")
    elif grey.dtype.kind == "f":
        base, slope, unit = 0.0, 1.0, None
        history.append("values as stored, 32 bit")
    else:
        raise ConfigurationError(
            f"{name}: what its greys mean is stated nowhere; state grey, such as '0 = 5 mm, 255 = 20 mm' (--grey)"
        )
    values = base + slope * grey.astype(np.float64)
    if gap is not None:
        values[grey == gap] = np.nan
        history.append(f"grey {gap} is a gap")
    return locked(values), unit


def _history(lines: Mapping[str, str]) -> list[str]:
    return [line for line in lines.get("history", "").split(" | ") if line]


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ConfigurationError(
            f"{shown(text)} in the description of a picture is no number; state the scale"
        ) from None
