"""Maps of place and time, measured in a laboratory or simulated: read, shown, measured, written; no model is needed.

>>> from peristalsis import maps
>>> recorded = maps.read("recording.csv")
>>> for one in maps.contractions(recorded): print(one.direction, one.speed)
"""

from __future__ import annotations

from .comparing import Compared, compare
from .contractions import Contraction, Contractions, Rule, contractions
from .files import read, tracks, write, write_tracks
from .recording import Map, Track
from .synthetic import STANDING, Ring, recording
from .treatment import despiked, filled, level, resampled

__all__ = [
    "STANDING",
    "Compared",
    "Contraction",
    "Contractions",
    "Map",
    "Ring",
    "Rule",
    "Track",
    "compare",
    "contractions",
    "despiked",
    "filled",
    "level",
    "read",
    "recording",
    "resampled",
    "tracks",
    "write",
    "write_tracks",
]
