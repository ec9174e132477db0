"""Pictures and films of the tube in space: the wall cut open, the pellet in it. Needs the extra `surface`.

The graphics library draws without a screen where the machine's libraries allow it, and may end the whole process
where they do not. So it is tried in a process of its own first, and what is missing is said.
"""

from __future__ import annotations

import os
import subprocess
import sys
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError, shown
from ..names import FIELDS, OUTPUTS
from ..paths import located
from . import data, surface
from .placing import whole_in_folder

if TYPE_CHECKING:
    from collections.abc import Iterable

    from PIL import Image

    from ..results.result import Result

PICTURES, FILMS = (".png",), (".gif", ".mp4")
SIZE = (1280, 560)
"""Pixels of a picture; films have half as many to a side."""
CUT = 90.0
"""Angle of the wall that is left out, so that the inside is seen [deg]."""
PROBE_SECONDS = 120

_PROBE = """
import sys
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(32, 24))
plotter.add_mesh(pyvista.Sphere())
picture = plotter.screenshot(return_img=True)
sys.exit(0 if picture is not None and picture.std() > 0 else 3)
"""

COLOURS = {
    "contact_pressure": "magma_r",  # most of the wall has none, and must not be black
    "stretch_longitudinal": "RdBu",
    "stretch_circumferential": "RdBu",
    "potential_longitudinal": "cividis",
    "potential_circular": "cividis",
}
"""Colour maps of outputs; all others have viridis."""


class View(NamedTuple):
    """What is drawn: the output that colours the wall, its name among the surface's fields, one scale for all."""

    name: str
    label: str
    limits: tuple[float, float]


@lru_cache(maxsize=1)
def problem() -> str | None:
    """Why pictures in space cannot be drawn here, and what to do; None if they can. Tried in a process of its own."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", _PROBE], capture_output=True, check=False, timeout=PROBE_SECONDS, text=True
        )
    except subprocess.TimeoutExpired:
        return f"the graphics library did not answer within {PROBE_SECONDS} s; use the VTK export and ParaView instead"
    if done.returncode == 0:
        return None
    lines = [line.strip() for line in done.stderr.splitlines() if line.strip()]
    if any("No module named" in line for line in lines):
        return "the library pyvista is not installed; run 'pip install pyvista'"
    if done.returncode == 3:
        return "the graphics library draws an empty picture here; use the VTK export and ParaView instead"
    cause = f"signal {-done.returncode}" if done.returncode < 0 else (lines or ["no reason given"])[-1][:120]
    return (
        f"the graphics library cannot draw without a screen here ({cause}); install libgl1, libxrender1 and "
        "libegl1 (or Mesa's libosmesa6), or use the VTK export and ParaView instead"
    )


def scene(
    result: Result,
    path: str | os.PathLike[str],
    time: float | None = None,
    colour: str = "stretch_circumferential",
    frames: int = 60,
    rate: int = 15,
) -> Path:
    """Write a picture (.png) at the stored time nearest to `time` [s], or a film (.gif, .mp4) of the run.

    time: by default that of the hardest contact; for pictures only. colour: a field of `names.FIELDS`. frames: of a
    film, spread evenly; rate: of them a second. Raises ConfigurationError for other endings and fields, and where the
    libraries are missing; WriteError if the file cannot be written.
    """
    target = located(path)
    ending = target.suffix.lower()
    if ending not in (*PICTURES, *FILMS):
        raise ConfigurationError(
            f"scene {shown(target.name)}: not a picture or film; name a file ending in .png, .gif or .mp4"
        )
    if not 2 <= frames <= 2000 or not 1 <= rate <= 100:
        raise ConfigurationError(f"scene of {frames} frames at {rate} a second: give 2 to 2000, and a rate of 1 to 100")
    view = _view(result, colour)
    found = problem()
    if found is not None:
        raise ConfigurationError(f"scene {shown(target.name)}: {found}")
    from .film import require, write_film

    require(target)

    if ending in PICTURES:
        from .figures.surface_maps import default_frame

        chosen = default_frame(result) if time is None else data.frames_at(result, [time])[0]
        (picture,) = _pictures(result, [chosen], view, SIZE)
        _save(picture, target)
        return target
    pictures = list(_pictures(result, data.spread_frames(result, frames), view, (SIZE[0] // 2, SIZE[1] // 2)))
    return write_film(pictures, target, rate)


def _view(result: Result, colour: str) -> View:
    if colour not in {output.name for output in FIELDS}:
        from ..errors import suggestion

        names = [output.name for output in FIELDS]
        raise ConfigurationError(f"scene coloured by {shown(colour)}: not a field; {suggestion(str(colour), names)}")
    unit = OUTPUTS[colour].unit
    values = np.nan_to_num(data.stored(result, colour))
    limits = data.limits(values, least=1e-6)
    if colour.startswith("stretch"):  # the diverging colours are about the undeformed length
        farthest = max(0.05, float(np.abs(values - 1.0).max()))
        limits = 1.0 - farthest, 1.0 + farthest
    return View(colour, colour if unit == "1" else f"{colour} [{unit}]", limits)


def _pictures(result: Result, frames: Iterable[int], view: View, size: tuple[int, int]) -> Iterable[Image.Image]:
    """One picture a frame, all with the same camera and scale of colours."""
    import pyvista
    from PIL import Image

    pyvista.vtk_verbosity("off")  # it looks for a screen first and says that there is none
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="three lights")
    plotter.set_background("white")
    length = result.configuration.wall.span
    widest = float(data.stored(result, "radius").max())
    size_of_text = max(8, size[1] // 36)
    bar = {
        "title": view.label,
        "color": "black",
        "title_font_size": size_of_text,
        "label_font_size": size_of_text,
        "vertical": False,
        "position_x": 0.25,
        "position_y": 0.04,
        "width": 0.5,
        "height": 0.08,
    }
    time = data.values(result, "time")
    try:
        for frame in frames:
            wall = _cut(surface.wall(result, frame))
            colours = COLOURS.get(view.name, "viridis")
            mesh = _mesh(wall)
            plotter.add_mesh(
                mesh,
                scalars=view.label,
                clim=view.limits,
                cmap=colours,
                scalar_bar_args=bar,
                name="wall",
                smooth_shading=True,
            )
            if data.has_pellet(result):
                ball = _mesh(surface.pellet(result, frame))
                # A little smaller, or it would shine through the wall that touches it.
                ball = ball.scale(0.99, point=ball.center)
                plotter.add_mesh(ball, color="lightgrey", specular=0.4, name="pellet", smooth_shading=True)
            said = f"{result.summary['scenario']}, t = {time[frame]:.2f} s; oral end left, {length:g} cm"
            plotter.add_text(
                said, position="upper_left", font_size=round(0.6 * size_of_text), color="black", name="text"
            )
            middle = 0.5 * length
            plotter.camera_position = [
                (2.2 * widest, 2.2 * length * 0.55, middle + 0.12 * length),
                (0.0, 0.0, middle),
                (1.0, 0.0, 0.0),
            ]
            plotter.camera.parallel_projection = True
            plotter.camera.parallel_scale = 0.5 * length * size[1] / size[0] * 1.12
            yield Image.fromarray(np.asarray(plotter.screenshot(return_img=True)))
    finally:
        plotter.close()


def _cut(wall: surface.Surface) -> surface.Surface:
    """Without the facets about the angle that faces the camera, which looks along -y: about 90 deg, and above."""
    middle = wall.points[wall.quads].mean(axis=1)
    turn = np.rad2deg(np.arctan2(middle[:, 1], middle[:, 0]))
    return surface.Surface(wall.points, wall.quads[np.abs(turn - 60.0) > 0.5 * CUT], wall.fields)


def _mesh(part: surface.Surface) -> Any:
    import pyvista

    faces = np.column_stack([np.full(part.quads.shape[0], 4), part.quads]).ravel()
    mesh = pyvista.PolyData(part.points, faces)
    for name, values in part.fields.items():
        mesh.point_data[name] = values
    return mesh


def _save(picture: Image.Image, target: Path) -> None:
    with whole_in_folder(target) as temporary:
        picture.save(temporary)
