"""Runs side by side: their numbers, their tracks, and what differs between their diameter maps."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import ConfigurationError

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure as Canvas
    from numpy.typing import NDArray

    from ..inputs.config import Configuration
    from ..results.result import Result

    Floats = NDArray[np.float64]


SIZE = (7.4, 4.6)
"""Width and height of a picture [inch]."""


class Number(NamedTuple):
    """One number of a summary: its key (dotted inside tables), what it is, its unit, and a second unit."""

    key: str
    label: str
    unit: str
    other: str = ""
    factor: float = 1.0
    decisive: bool = True
    """False for what says how the run was computed, not what came out."""
    seldom: bool = False
    """Shown only where it is not zero."""


NUMBERS = (
    Number("transit_s", "transit time", "s"),
    Number("oral_exit_s", "expelled orally at", "s"),
    Number("mean_velocity_cm_s", "mean velocity of the pellet", "cm/s", "mm/s", 10.0),
    Number("max_velocity_cm_s", "largest velocity of the pellet", "cm/s", "mm/s", 10.0),
    Number("start_cm", "first position of the pellet", "cm", "mm", 10.0),
    Number("final_position_cm", "last position of the pellet", "cm", "mm", 10.0),
    Number("travel_cm", "travel", "cm", "mm", 10.0),
    Number("max_axial_force_mN", "largest axial force on the pellet", "mN", "N", 1e-3),
    Number("max_normal_force_mN", "largest normal force on the pellet", "mN", "N", 1e-3),
    Number("beyond_oral_end_cm", "oral pole beyond the oral end, at most", "cm", "mm", 10.0, seldom=True),
    Number("max_end_reaction_mN", "largest force of a closed end", "mN", "N", 1e-3, seldom=True),
    Number("max_lumen_pressure_kPa", "largest lumen pressure", "kPa", "mmHg", 1.0 / 0.133322),
    Number("max_contact_pressure_kPa", "largest contact pressure", "kPa", "mmHg", 1.0 / 0.133322),
    Number("wave_speed_cm_s.longitudinal", "wave speed, longitudinal", "cm/s", "mm/s", 10.0),
    Number("wave_speed_cm_s.circular", "wave speed, circular", "cm/s", "mm/s", 10.0),
    Number("min_diameter_cm", "smallest inner diameter", "cm", "mm", 10.0),
    Number("max_diameter_cm", "largest inner diameter", "cm", "mm", 10.0),
    Number("bulge_cm.oral", "wall beyond the oral end, at most", "cm", "mm", 10.0, seldom=True),
    Number("bulge_cm.anal", "wall beyond the anal end, at most", "cm", "mm", 10.0, seldom=True),
    Number("simulated_s", "simulated time", "s"),
    Number("power_residual", "work left over, of all work", "1", decisive=False),
    Number("momentum_residual", "axial force left over, of the largest", "1", decisive=False),
    Number("steps", "steps of the wall", "1", decisive=False),
    Number("solver_wall_s", "time in the solver", "s", decisive=False),
    Number("compile_wall_s", "time to compile", "s", decisive=False),
)


def value_of(summary: Mapping[str, Any], number: Number) -> Any:
    """One number of a summary; None where a run has none."""
    value: Any = summary
    for part in number.key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    return value


def changed_keys(runs: Mapping[str, Result]) -> dict[str, list[Any]]:
    """The parameters in which the runs differ, as they would stand in a file, one value a run."""
    texts = [_in_words(result.configuration) for result in runs.values()]
    return {
        key: [text[key] for text in texts] for key in texts[0] if any(text[key] != texts[0][key] for text in texts[1:])
    }


def _in_words(configuration: Configuration) -> dict[str, Any]:
    """Every input as it would stand in a file, but regions and stimuli in a few words, and maps by a digest."""
    texts = configuration.texts()
    words = "; ".join(region.words() for region in configuration.regions)
    if any(region.shape.NAME == "map" for region in configuration.regions):
        words += f" (sha256 {_short_hash(texts['regions'])})"
    listed = texts.get("stimuli", [])
    said = "; ".join(listed) if len(listed) <= 3 else f"{len(listed)} of them, sha256 {_short_hash(listed)}"
    doses = "; ".join(dose.words() for dose in configuration.drugs)
    return texts | {"regions": words or "none", "stimuli": said or "none", "drugs": doses or "none"}


def _short_hash(content: object) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode("ascii")).hexdigest()[:12]


def diameters(result: Result) -> Floats:
    """Diameter of the wall [cm], mean around the tube, shape (n_time, n_z); z of the undeformed tube."""
    return 2.0 * result.arrays["radius"].mean(axis=2)


def diameter_difference(first: Result, second: Result) -> tuple[Floats, Floats, Floats]:
    """Times [s], places [cm] and diameter of `second` less that of `first` [cm], shape (n_time, n_z).

    On the stored times and nodes of `first`, over the time and length that both runs have; linear in between.
    Raises ConfigurationError when the runs have less than two stored times in common.
    """
    from scipy.interpolate import RegularGridInterpolator

    time, z = first.arrays["time"], first.arrays["z"]
    until = min(time[-1], second.arrays["time"][-1])
    time = time[time <= until * (1.0 + 1e-12)]
    z = z[z <= second.arrays["z"][-1] * (1.0 + 1e-12)]
    if time.size < 2:
        raise ConfigurationError(
            f"the runs share {time.size} stored time up to {until:g} s, too few for a map of differences; "
            "run them longer or shorten output.interval"
        )
    read = RegularGridInterpolator(
        (second.arrays["time"], second.arrays["z"]), diameters(second), bounds_error=False, fill_value=None
    )
    grid = (time[:, None], z[None, :])
    return time, z, read(grid) - diameters(first)[: time.size, : z.size]


def cuts(runs: Mapping[str, Result]) -> list[str]:
    """What a comparison leaves out because the runs are not of one duration or one length, a sentence each."""
    said = []
    for label, unit, extents in (
        ("time", "s", {name: float(result.arrays["time"][-1]) for name, result in runs.items()}),
        ("place", "cm", {name: float(result.arrays["z"][-1]) for name, result in runs.items()}),
    ):
        least, most = min(extents.values()), max(extents.values())
        if most - least > 1e-9 * most:
            ends = ", ".join(f"{name} {extent:.4g} {unit}" for name, extent in extents.items())
            said.append(
                f"the runs end at different {label}s ({ends}): maps of differences stop at the first, and numbers of "
                "whole runs are over unequal parts"
            )
    return said


def tracks_figure(runs: Mapping[str, Result]) -> Canvas:
    """The position of the pellet over time, every run in one picture, the oral end at the top."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.subplots()
    for name, result in runs.items():
        if result.configuration.pellet.enabled:
            axes.plot(result.arrays["time_step"], 10.0 * result.arrays["pellet_position"], label=_label(name))
    if not axes.lines:
        raise ConfigurationError("none of the runs has a pellet, so there is no track; compare other runs")
    longest = max(result.configuration.wall.length for result in runs.values())
    axes.set(xlabel="time (s)", ylabel="position of the pellet (mm)", ylim=(10.0 * longest, 0.0), title="Tracks")
    axes.legend()
    return figure


def difference_figure(names: tuple[str, str], first: Result, second: Result) -> Canvas:
    """Diameter of the second run less that of the first, over time and place, the oral end at the top."""
    from matplotlib.figure import Figure

    time, z, difference = diameter_difference(first, second)
    largest = 10.0 * float(abs(difference).max()) or 1.0  # equal runs give an empty map
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.subplots()
    mesh = axes.pcolormesh(
        time,
        10.0 * z,
        10.0 * difference.T,
        cmap="PuOr_r",
        vmin=-largest,
        vmax=largest,
        shading="nearest",
        rasterized=True,
    )
    figure.colorbar(mesh, ax=axes, label="difference of diameter (mm)")
    axes.set(
        xlabel="time (s)",
        ylabel="place in the undeformed tube (mm)",
        title=f"Diameter: {_label(names[1])} less {_label(names[0])}",
    )
    axes.invert_yaxis()
    return figure


def _label(name: str) -> str:
    """A name as matplotlib shows it: no formula, and never left out of a legend."""
    plain = name.replace("$", r"\$")
    return f" {plain}" if plain.startswith("_") else plain


def draw(runs: Mapping[str, Result], folder: Path) -> tuple[list[Path], list[str]]:
    """Write tracks.png and maps of every further run less the first; the files, and what was left out."""
    from ..plots import style

    names, results = list(runs), list(runs.values())
    plans: list[tuple[str, Callable[[], Canvas]]] = [("tracks.png", partial(tracks_figure, runs))]
    for index in range(1, len(names)):
        pair = (names[0], names[index])
        ending = "" if len(names) == 2 else f"_{index + 1}"
        plans.append((f"diameter_difference{ending}.png", partial(difference_figure, pair, results[0], results[index])))
    written, left_out = [], []
    for name, figure in plans:
        try:
            with style.applied():
                figure().savefig(folder / name, dpi=160)
        except ConfigurationError as error:
            left_out.append(f"{name}: {error}")
        else:
            written.append(folder / name)
    return written, left_out
