"""What the figures show, as arrays in the units of the axes; no drawing here.

Fields are those of the first column around (an axisymmetric wall has only that one), unless a function says otherwise:
diameters are those of the circle with the area of the ring, manometry is the mean around it, and a cut through the tube
shows the first column and the one opposite.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import ConfigurationError
from ..names import FIELDS, OUTPUTS

if TYPE_CHECKING:
    from ..inputs.shape import PelletShape
    from ..results.result import Result

Floats = NDArray[np.float64]

KPA_PER_MMHG = 0.133322387415

FACTORS = {
    ("cm", "mm"): 10.0,
    ("cm/s", "mm/s"): 10.0,
    ("mN", "N"): 1e-3,
    ("mN/cm", "N/cm"): 1e-3,
    ("mN*cm", "mJ"): 1e-2,
    ("kPa", "mmHg"): 1.0 / KPA_PER_MMHG,
}
"""(unit of the file, unit shown) -> factor."""


def values(result: Result, name: str, unit: str | None = None) -> Floats:
    """An output as an array over time and, for fields, place; in `unit`, or in the unit of the file."""
    output = OUTPUTS[name]
    array = np.asarray(stored(result, name), dtype=np.float64)
    if len(output.dimensions) > 1 and output.dimensions[-1] in ("theta", "theta_cell"):
        array = array[..., 0]
    return array * _factor(name, unit)


SMALL_FORCE = 500.0
"""Force up to which an axis is in mN and not in N [mN]."""


def force_unit(result: Result, *names: str) -> str:
    """The unit in which forces are shown together: mN where all stay small, else N."""
    largest = max(float(np.nanmax(np.abs(values(result, name)), initial=0.0)) for name in names)
    return "mN" if largest < SMALL_FORCE else "N"


def around(result: Result, name: str, unit: str | None = None) -> Floats:
    """Mean of a field around the ring, over time and place; as `values` where there is one column."""
    return np.asarray(np.nan_to_num(stored(result, name)).mean(axis=-1) * _factor(name, unit))


def cut(result: Result, name: str, unit: str | None = None) -> Floats:
    """A field in the plane of the first column: there and opposite, shape (2, n_time, n)."""
    field = stored(result, name)
    return np.stack([field[..., 0], field[..., field.shape[-1] // 2]]) * _factor(name, unit)


def profile(result: Result) -> Floats:
    """Distance of the wall from the tube's axis in the plane of the first column [mm], (2, n_time, n_z): up, down."""
    field = 10.0 * stored(result, "radius")
    if field.shape[-1] == 1:
        return np.stack([field[..., 0], -field[..., 0]])
    height, opposite = field * np.cos(stored(result, "angle")), field.shape[-1] // 2
    return np.stack([height[..., 0], height[..., opposite]])


def ring_diameter(result: Result) -> Floats:
    """Diameter of the circle with the area of each ring of wall [mm], (n_time, n_z)."""
    if stored(result, "radius").shape[-1] == 1:
        return 2.0 * values(result, "radius", "mm")
    from ..geometry.surface import equivalent_radius

    frames = zip(stored(result, "radius"), stored(result, "angle"), strict=True)
    return np.stack([20.0 * equivalent_radius(np.stack([r, a, np.zeros_like(r)], axis=2)) for r, a in frames])


def _factor(name: str, unit: str | None) -> float:
    own = OUTPUTS[name].unit
    return 1.0 if unit in (None, own) else FACTORS[own, str(unit)]


def stored(result: Result, name: str) -> Floats:
    """The array of an output. Raises ConfigurationError where the run was told not to keep it."""
    if name not in result.arrays:
        if OUTPUTS[name] in FIELDS:
            fix = f"repeat it with output.fields = ['all'], or with {name} among them"
        else:  # numbers of every step, of probes and of events are always kept: an older version did not know this one
            fix = "its version of peristalsis did not record it yet; run its config.toml again with this one"
        raise ConfigurationError(f"{name} was not stored by this run; {fix}")
    return result.arrays[name]


def has_pellet(result: Result) -> bool:
    """Whether the run has a pellet."""
    return result.configuration.pellet.enabled


def length(result: Result) -> float:
    """Length of the undeformed tube [mm]."""
    return 10.0 * result.configuration.wall.length


def span(result: Result) -> float:
    """Distance between the clamped ends [mm]: the length of the tube in space, however it deforms."""
    return 10.0 * result.configuration.wall.span


def pellet_shape(result: Result) -> PelletShape:
    """The pellet's shape, in cm."""
    from ..inputs.shape import shape_of

    return shape_of(result.configuration)


def poles(result: Result) -> tuple[float, float]:
    """Distances of the oral and of the anal pole from the pellet's centre [mm]."""
    shape = pellet_shape(result)
    return 10.0 * shape.oral, 10.0 * shape.anal


def pellet_outline(result: Result, centre: float = 0.0) -> Floats:
    """The pellet's outline in a plane through its axis [mm], (points, 2): along the tube, from a centre, and across."""
    axial, radii = pellet_shape(result).outline()
    along, across = 10.0 * axial + centre, 10.0 * radii
    return np.column_stack([np.r_[along, along[-2:0:-1]], np.r_[across, -across[-2:0:-1]]])


def end_time(result: Result) -> float:
    """Right edge of a time axis [s]: the last step, or one output interval if nothing was computed."""
    last = float(values(result, "time_step")[-1])
    return last if last > 0.0 else result.configuration.output.interval


def at_frames(result: Result, name: str, unit: str | None = None) -> Floats:
    """A scalar at the times of the stored fields."""
    return np.interp(values(result, "time"), values(result, "time_step"), values(result, name, unit))


def transit(result: Result) -> float | None:
    """When the pellet was expelled [s], or None."""
    found = result.summary.get("transit_s")
    return None if found is None else float(found)


def left(result: Result) -> tuple[float, str] | None:
    """When the pellet left [s], and how in words; None if it did not."""
    found = transit(result)
    if found is not None:
        return found, "expelled"
    orally = result.summary.get("oral_exit_s")
    return None if orally is None else (float(orally), "expelled orally")


def beyond_ends(result: Result) -> tuple[float, float]:
    """How far pellet or wall stand out over the oral and over the anal end at most [mm]."""
    wall = result.summary.get("bulge_cm") or {}
    oral = max(float(wall.get("oral") or 0.0), float(result.summary.get("beyond_oral_end_cm") or 0.0))
    return 10.0 * oral, 10.0 * float(wall.get("anal") or 0.0)


def laboratory_axis(result: Result, count: int | None = None) -> Floats:
    """Axial places fixed in space [mm], from the oral to the anal end; as many as the wall has nodes."""
    return np.linspace(0.0, span(result), values(result, "z").size if count is None else count)


def in_laboratory(result: Result, field: Floats, axis: Floats) -> Floats:
    """A field on wall nodes, shape (n_time, n_z), at places fixed in space [mm], shape (n_time, n_axis).

    Nodes move along the tube, so each frame is interpolated anew. Where a fold makes the wall run backwards, the
    places already passed are skipped.
    """
    places = np.maximum.accumulate(around(result, "axial_position", "mm"), axis=1)
    return np.stack([np.interp(axis, place, row) for place, row in zip(places, field, strict=True)])


def diameter_map(result: Result) -> tuple[Floats, Floats, Floats]:
    """Time [s], axial place [mm] and inner diameter [mm], shape (n_time, n_axis), in space."""
    axis = laboratory_axis(result)
    return values(result, "time"), axis, in_laboratory(result, ring_diameter(result), axis)


def manometry(result: Result, spacing: float) -> tuple[Floats, Floats, Floats]:
    """Time [s], places of sensors [mm] and pressure [mmHg], shape (n_time, n_sensors).

    spacing: distance between sensors [mm]; the first is one spacing from the oral end. A sensor reads the lumen
    pressure and, where the wall is pressed onto the pellet, the contact pressure besides.
    """
    count = max(1, int(np.ceil(span(result) / spacing - 1e-9)) - 1)
    axis = np.asarray(spacing * np.arange(1, count + 1), dtype=np.float64)
    contact = around(result, "contact_pressure", "mmHg")
    lumen = at_frames(result, "lumen_pressure", "mmHg")
    return values(result, "time"), axis, lumen[:, None] + in_laboratory(result, contact, axis)


def contact_map(result: Result, count: int = 241) -> tuple[Floats, Floats, Floats]:
    """Time [s], place relative to the pellet's centre [mm] and contact pressure [kPa], shape (n_time, count)."""
    oral, anal = poles(result)
    relative = np.linspace(-oral, anal, count)
    centre = at_frames(result, "pellet_position", "mm")
    contact = around(result, "contact_pressure")
    places = np.maximum.accumulate(around(result, "axial_position", "mm"), axis=1)
    rows = [
        np.interp(relative + middle, place, row) for middle, place, row in zip(centre, places, contact, strict=True)
    ]
    return values(result, "time"), relative, np.stack(rows)


def frames_at(result: Result, times: Sequence[float]) -> list[int]:
    """Indices of the stored fields nearest to the given times [s], each once."""
    stored = values(result, "time")
    return sorted({int(np.argmin(np.abs(stored - time))) for time in times})


def spread_frames(result: Result, count: int) -> list[int]:
    """Indices of `count` stored fields spread evenly over the run; fewer if there are not as many."""
    return frames_at(result, [float(time) for time in np.linspace(0.0, values(result, "time")[-1], count)])


def edges(centres: Floats, width: float = 1.0) -> Floats:
    """Borders of the cells around rising `centres`, one more than these; a single cell is `width` wide."""
    if centres.size == 1:
        return np.array([centres[0] - 0.5 * width, centres[0] + 0.5 * width])
    middle = 0.5 * (centres[1:] + centres[:-1])
    return np.concatenate([[centres[0]], middle, [centres[-1]]])


def limits(*arrays: Floats, least: float) -> tuple[float, float]:
    """Smallest and largest finite value, pushed apart to at least `least`."""
    finite = np.concatenate([np.ravel(array)[np.isfinite(np.ravel(array))] for array in arrays])
    if finite.size == 0:
        return 0.0, least
    low, high = float(finite.min()), float(finite.max())
    missing = max(0.0, least - (high - low))
    return low - 0.5 * missing, high + 0.5 * missing
