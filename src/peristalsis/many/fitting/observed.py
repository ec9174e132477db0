"""What was observed: tracks of pellets, brought to the time and place of the model."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ConfigurationError, shown

if TYPE_CHECKING:
    from ...maps.recording import Track

Floats = NDArray[np.float64]
FEWEST = 3


@dataclass(frozen=True)
class Observed:
    """A track on the axes of the model: times [s] and places of the pellet's centre [cm], each (n,).

    changes: what is set in the configuration for this track besides, such as another pellet.
    """

    name: str
    time: Floats
    place: Floats
    changes: Mapping[str, Any] = field(default_factory=dict)


def observed(
    tracks: Sequence[Track | tuple[Track, Mapping[str, Any]]] | str | os.PathLike[str],
    *,
    scale: tuple[float, float] | None = None,
    time_offset: float = 0.0,
    place_offset: float = 0.0,
) -> tuple[Observed, ...]:
    """The tracks of a CSV file, or those given, each alone or with what is set for it.

    scale: millimetres a pixel and frames a second, of a file in pixels and frames. time_offset [s], place_offset [cm]:
    where the zero of the model's time lies on the clock of the recording, and its oral end on its scale; they are taken
    away. Raises ConfigurationError.
    """
    from ... import maps

    if isinstance(tracks, str | os.PathLike):
        tracks = list(maps.tracks(tracks, scale=scale))
    elif scale is not None:
        raise ConfigurationError("a scale is for files; tracks are in s and mm already")
    found = []
    for item in tracks:
        track, changes = item if isinstance(item, tuple) else (item, {})
        if track.time.size < FEWEST:
            raise ConfigurationError(
                f"track {shown(track.name)} has {track.time.size} positions; {FEWEST} or more are needed for a fit"
            )
        found.append(Observed(track.name, track.time - time_offset, 0.1 * track.position - place_offset, dict(changes)))
    if not found:
        raise ConfigurationError("there is no track to fit; give one or more")
    return tuple(found)


def check(listed: Sequence[Observed], length: float) -> None:
    """Raise ConfigurationError for tracks that the model cannot have: before its start, or outside of the tube."""
    for one in listed:
        if one.time[-1] <= 0.0:
            raise ConfigurationError(
                f"track {shown(one.name)} ends at {one.time[-1]:g} s, before the model starts; state the offset in time"
            )
        if one.place.min() < -0.1 * length or one.place.max() > 1.5 * length:
            raise ConfigurationError(
                f"track {shown(one.name)} goes from {one.place.min():.4g} to {one.place.max():.4g} cm, and the tube is "
                f"{length:g} cm long; state the scale or the offset in place, or set wall.length"
            )
