"""Film of the tube and the pellet: the wall cut along the axis, coloured by its circumferential tension."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ConfigurationError, shown
from ..paths import located
from . import data, style
from .figures.wall_shapes import segment_values, segments, tension_colours
from .placing import whole_in_folder

if TYPE_CHECKING:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    from ..results.result import Result

FILM_DPI = 96
AXES_WIDTH = 5.7
"""Width of the tube in the picture [inch]."""
MOST_FRAMES = 2000


def film(result: Result, path: str | os.PathLike[str], frames: int = 100, rate: int = 20) -> Path:
    """Write the film to `path`: a GIF always, an MP4 where ffmpeg is installed or the `movie` extra.

    frames: pictures spread evenly over the run; rate: pictures a second. Raises ConfigurationError for another
    ending or where ffmpeg is missing, WriteError if the file cannot be written.
    """
    target = located(path)
    ending = target.suffix.lower()
    if ending not in (".gif", ".mp4"):
        raise ConfigurationError(f"film {shown(target.name)}: not a film format; name a file ending in .gif or .mp4")
    if not 1 <= frames <= MOST_FRAMES or not 1 <= rate <= 100:
        raise ConfigurationError(
            f"film with {frames} frames at {rate} a second: give 1 to {MOST_FRAMES} frames, and a rate of 1 to 100"
        )
    require(target)
    with style.applied():
        pictures = _pictures(result, data.spread_frames(result, frames), rate)
    return write_film(pictures, target, rate)


def require(target: Path) -> None:
    """Refuse an MP4 where there is no ffmpeg, before anything is drawn."""
    if target.suffix.lower() == ".mp4" and ffmpeg() is None:
        raise ConfigurationError(
            f"film {shown(target.name)}: an MP4 needs ffmpeg, which is not here; install ffmpeg or "
            "'pip install imageio-ffmpeg', or name a .gif, which needs nothing"
        )


def write_film(pictures: list[Image.Image], target: Path, rate: int) -> Path:
    """Write pictures as a film of `rate` a second, by the ending of its name; it appears whole or not at all.

    Raises ConfigurationError where ffmpeg is missing or fails, WriteError if the file cannot be written.
    """
    require(target)
    program = ffmpeg() if target.suffix.lower() == ".mp4" else None
    with whole_in_folder(target) as temporary:
        if program is None:
            _write_gif(pictures, temporary, rate)
        else:
            _write_mp4(pictures, temporary, rate, program)
    return target


def ffmpeg() -> str | None:
    """The ffmpeg program of the system or of the extra, or None."""
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    try:
        import imageio_ffmpeg  # type: ignore[import-not-found,unused-ignore]

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        return None


def _pictures(result: Result, frames: list[int], rate: int) -> list[Image.Image]:
    """One picture a frame; all that stands still is drawn once, only what moves is drawn anew."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Polygon

    cmap, norm = tension_colours(result)
    axial, shape = data.cut(result, "axial_position", "mm"), data.profile(result)
    widest = float(np.abs(shape).max()) + 2.0
    canvas = style.canvas(result, 1.25 + 2.0 * widest * AXES_WIDTH / data.span(result), "Tube and pellet")
    canvas.set_dpi(FILM_DPI)
    axes = canvas.add_subplot()
    tension, time = data.cut(result, "tension_circumferential", "N/cm"), data.values(result, "time")
    wall = LineCollection(
        list(segments(axial[:, 0], shape[:, 0])), cmap=cmap, norm=norm, linewidths=2.6, capstyle="round"
    )
    axes.add_collection(wall)
    pellet = None
    if data.has_pellet(result):
        centres = data.at_frames(result, "pellet_position", "mm")
        outline = data.pellet_outline(result)
        pellet = Polygon(outline + np.array([centres[0], 0.0]), facecolor="0.82", edgecolor="0.4", linewidth=0.8)
        axes.add_patch(pellet)
    axes.set_aspect("equal")
    mark = 10.0 if widest >= 10.0 else 5.0  # a tick beyond the limits would widen them, and the picture has no room
    axes.set_yticks([-mark, 0.0, mark], [f"{mark:g}", "0", f"{mark:g}"])
    axes.set_ylim(-widest, widest)
    axes.set_ylabel("radius (mm)")
    style.axis_right(axes, result)
    clock = axes.set_title("t = 0.00 s", loc="right")
    simulated = float(time[frames[-1]] - time[frames[0]])
    if simulated > 0.0:
        axes.set_title(f"shown at {simulated * rate / (len(frames) - 1):.2g} times real speed", loc="left")
    bar = canvas.colorbar(wall, ax=axes, aspect=14, pad=0.015, fraction=0.05)
    bar.set_label("circumferential\ntension (N/cm)")
    canvas.draw_without_rendering()
    canvas.set_layout_engine("none")  # lay out once: the axes must not shift between pictures
    moving = [artist for artist in (pellet, wall, clock) if artist is not None]
    for artist in moving:
        artist.set_animated(True)
    agg = FigureCanvasAgg(canvas)
    agg.draw()
    still = agg.copy_from_bbox(canvas.bbox)
    pictures = []
    for frame in frames:
        agg.restore_region(still)
        wall.set_segments(list(segments(axial[:, frame], shape[:, frame])))
        wall.set_array(segment_values(tension[:, frame]))
        if pellet is not None:
            pellet.set_xy(outline + np.array([centres[frame], 0.0]))
        clock.set_text(f"t = {time[frame]:.2f} s")
        for artist in moving:
            artist.draw(agg.get_renderer())
        pictures.append(_picture(agg))
    return pictures


def _picture(agg: FigureCanvasAgg) -> Image.Image:
    """What is on the canvas now, as a picture of even sides."""
    from PIL import Image

    pixels = np.asarray(agg.buffer_rgba())[..., :3]
    even = pixels[: pixels.shape[0] // 2 * 2, : pixels.shape[1] // 2 * 2]  # film codecs want even sides
    return Image.fromarray(np.ascontiguousarray(even))


def _write_gif(pictures: list[Image.Image], path: Path, rate: int) -> None:
    from PIL import Image

    palette = pictures[len(pictures) // 2].quantize(colors=128, method=Image.Quantize.MEDIANCUT)
    colours = np.array(palette.getpalette()).reshape(-1, 3)
    colours[colours.min(axis=1) > 240] = 255  # else the background comes out a shade below white
    palette.putpalette(colours.ravel().tolist())
    frames = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    lengths = [round(1000 / rate)] * (len(frames) - 1) + [1500]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=lengths, loop=0, optimize=False, disposal=1)


def _write_mp4(pictures: list[Image.Image], path: Path, rate: int, program: str) -> None:
    import subprocess

    width, tall = pictures[0].size
    command = [program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{tall}"]
    command += ["-r", str(rate), "-i", "-", "-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", str(path)]
    raw = b"".join(picture.tobytes() for picture in pictures)
    done = subprocess.run(command, input=raw, capture_output=True, check=False)
    if done.returncode != 0:
        reason = done.stderr.decode(errors="replace").strip().splitlines()[-1:] or ["no reason given"]
        raise ConfigurationError(f"ffmpeg could not make {shown(path.name)}: {reason[0][:120]}; name a .gif instead")
