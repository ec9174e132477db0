"""Measured courses as inputs of a run: a pressure as a protocol, contractions as currents that repeat them."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ..errors import ConfigurationError, shown
from ..paths import located
from ..plots.placing import whole_in_folder
from .contractions import Contractions
from .recording import Map, Numbers, factor
from .treatment import across_gaps

PARAMETER = "lumen.pressure"


def write_course(recorded: Map, place: float, path: str | os.PathLike[str], least: float = 0.0) -> Path:
    """Write the pressure at a place [mm] as a table for `protocols = ["lumen.pressure: table FILE"]`.

    Times begin at 0; gaps are filled linearly, those at the ends left out; pressures in kPa, not below `least` [kPa].
    Raises ConfigurationError for other quantities: the diameter of a run cannot be prescribed, its contractions can
    (`write_stimuli`).
    """
    if recorded.quantity != "pressure":
        raise ConfigurationError(
            f"{recorded.name} is a map of {recorded.quantity}; a run takes a pressure as its protocol, and "
            "contractions as stimuli (--stimuli)"
        )
    course = np.asarray(recorded.at(place), dtype=np.float64)
    whole: Numbers = across_gaps(course[:, None], recorded.time, np.inf)[:, 0]
    known = np.isfinite(whole)
    time = recorded.time[known] - recorded.time[known][0]
    values = np.maximum(whole[known] * factor("mmHg", "kPa", "pressure"), least)
    return _table(path, [f"time [s],{PARAMETER} [kPa]", *_rows(time, values)])


def write_stimuli(
    found: Contractions, path: str | os.PathLike[str], strength: float, width: float = 3.0, duration: float = 0.05
) -> Path:
    """Write the contractions of a map as a table of stimuli of the circular layer, for `stimuli` of a configuration.

    Along the front of each, one stimulus of `strength` [uA/cm^2] for `duration` [s] every `width` [mm]. They repeat
    when and where the gut contracted, not how deep. Contractions that began before time 0 are left out up to there.
    """
    if not found.found:
        raise ConfigurationError("there are no contractions to make stimuli of; lower the threshold")
    lines = ["onset [s],duration [s],strength [uA/cm^2],place [cm],width [cm],layer"]
    for one in found:
        place, when = one.front
        for edge in np.arange(place[0], place[-1] + 1e-9, width):
            onset = float(np.interp(edge + 0.5 * width, place, when))
            if onset >= 0.0:
                lines.append(f"{onset:.6g},{duration:g},{strength:g},{0.1 * edge:.6g},{0.1 * width:.6g},circular")
    if len(lines) == 1:
        raise ConfigurationError("all contractions lie before time 0; nothing is left for a run")
    return _table(path, lines)


def _rows(*columns: Numbers) -> list[str]:
    return [",".join(map(repr, row)) for row in zip(*(one.tolist() for one in columns), strict=True)]


def _table(path: str | os.PathLike[str], lines: list[str]) -> Path:
    target = located(path)
    if target.suffix.lower() != ".csv":
        raise ConfigurationError(f"{shown(str(path))}: a table for a run is a .csv; rename it")
    with whole_in_folder(target) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return target
