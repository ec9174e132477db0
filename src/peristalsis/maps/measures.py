"""Numbers of maps and tracks: frequency, high-amplitude waves, speed of pellets, velocity against diameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..errors import ConfigurationError, shown
from .contractions import Contraction, Contractions
from .recording import Floats, Map, Numbers, Track
from .treatment import across_gaps, median_of_places


@dataclass(frozen=True)
class Spectrum:
    """Power along the gut: frequency [1/min], shape (n,); place [mm]; power (n, n_place) in unit^2 min.

    peak: the frequency of the highest power of the mean over places, between low and high: its 95 % limits, from
    leaving out one segment after the other; None where it does not stand `least` times above the median power.
    """

    frequency: Floats
    place: Floats
    power: Floats
    unit: str
    segments: int
    peak: float | None
    limits: tuple[float, float] | None
    contrast: float


def spectrum(
    recorded: Map, segment: float, lowest: float | None = None, highest: float | None = None, least: float = 6.0
) -> Spectrum:
    """Welch's spectrum at each place: half overlapping segments of `segment` [s], Hann window, no means.

    lowest, highest: where the peak is looked for [1/min]; from two periods a segment to half the Nyquist frequency
    unless given. Segments with more than a tenth of gaps at a place are left out there, smaller gaps filled linearly.
    """
    step = recorded.time_step()
    size = round(segment / step)
    if size < 16 or size > recorded.time.size:
        raise ConfigurationError(
            f"segment = {segment:g} s holds {size} of the {recorded.time.size} times of {recorded.name}; give one "
            "of at least 16 steps and no longer than the recording"
        )
    window = np.hanning(size + 2)[1:-1]
    scale = 2.0 * step / float((window**2).sum()) / 60.0  # of power in unit^2 min
    starts = range(0, recorded.time.size - size + 1, max(1, size // 2))
    single, known = [], []
    for begin in starts:
        block = recorded.values[begin : begin + size]
        missing = np.isnan(block).mean(axis=0)
        whole = across_gaps(block, recorded.time[begin : begin + size], segment) if missing.any() else block
        good = missing <= 0.1
        level = np.nanmean(np.where(good, whole, 0.0), axis=0)
        change = np.where(np.isnan(whole) | ~good, 0.0, whole - level)
        single.append(scale * np.abs(np.fft.rfft(change * window[:, None], axis=0)) ** 2)
        known.append(good)
    powers, weight = np.stack(single), np.stack(known)
    number = weight.sum(axis=0)
    with np.errstate(invalid="ignore"):
        power = np.where(number > 0, (powers * weight[:, None, :]).sum(axis=0) / np.maximum(number, 1), np.nan)
    frequency = np.asarray(60.0 * np.fft.rfftfreq(size, step), dtype=np.float64)
    low = 120.0 / segment if lowest is None else lowest
    high = 15.0 / step if highest is None else highest
    band = (frequency >= low - 1e-9) & (frequency <= high + 1e-9)
    if band.sum() < 3:
        raise ConfigurationError(
            f"between {low:g} and {high:g} per minute lie no three frequencies; give a longer segment"
        )
    each = np.where(weight[:, None, :], powers, np.nan)
    per_segment = _mean(each, 2)[:, band]
    mean = _mean(per_segment, 0)
    contrast = float(mean.max() / max(float(np.median(mean)), 1e-300))
    peak = limits = None
    if contrast >= least:
        peak, limits = _peak(per_segment, frequency[band])
    return Spectrum(frequency, recorded.place, power, recorded.unit, len(single), peak, limits, contrast)


def _mean(values: Numbers, axis: int) -> Floats:
    known = np.isfinite(values)
    total = np.where(known, values, 0.0).sum(axis=axis)
    return np.asarray(total / np.maximum(known.sum(axis=axis), 1), dtype=np.float64)


def _peak(powers: Floats, frequency: Floats) -> tuple[float, tuple[float, float] | None]:
    """The peak of the mean of segments, and its 95 % limits by the jackknife; None of one segment."""
    peak = _top(_mean(powers, 0), frequency)
    count = len(powers)
    if count < 3:
        return peak, None
    others = np.array([_top(_mean(np.delete(powers, k, axis=0), 0), frequency) for k in range(count)])
    error = float(np.sqrt((count - 1) / count * np.sum((others - others.mean()) ** 2)))
    from scipy.stats import t

    half = max(float(t.ppf(0.975, count - 1)) * error, 0.25 * float(frequency[1] - frequency[0]))
    return peak, (peak - half, peak + half)


def _top(power: Floats, frequency: Floats) -> float:
    """The frequency of the highest power, by a parabola through the logarithms of three."""
    k = int(np.argmax(power))
    if not 0 < k < power.size - 1 or power[k - 1 : k + 2].min() <= 0.0:
        return float(frequency[k])
    left, middle, right = np.log(power[k - 1 : k + 2])
    bend = left - 2.0 * middle + right
    shift = 0.0 if bend == 0.0 else 0.5 * (left - right) / bend
    return float(frequency[k] + np.clip(shift, -0.5, 0.5) * (frequency[1] - frequency[0]))


class HighAmplitude(NamedTuple):
    """When a wave counts as one of high amplitude: `high` in `many` channels and `lower` in `more` others [mmHg]."""

    high: float = 100.0
    many: int = 2
    lower: float = 80.0
    more: int = 1
    directions: tuple[str, ...] = ("antegrade",)
    source: str = "doi 10.1046/j.1365-2982.2002.00342.x (human; 92 % sensitivity; abstract)"


def high_amplitude(recorded: Map, found: Contractions, rule: HighAmplitude | None = None) -> list[Contraction]:
    """The contractions of a map of pressures that satisfy a rule. The largest pressure counts, its resting value in it.

    It is looked for at each channel of a front within half the duration of the contraction.
    """
    if recorded.quantity != "pressure":
        raise ConfigurationError(f"{recorded.name} is a map of {recorded.quantity}; the rule is about pressures")
    chosen = rule or HighAmplitude()
    kept = []
    for one in found:
        tops = []
        half = max(0.5 * one.duration if np.isfinite(one.duration) else 0.0, recorded.time_step())
        for place, when in zip(*one.front, strict=True):
            column = int(np.argmin(np.abs(recorded.place - place)))
            first, last = np.searchsorted(recorded.time, (when - half, when + half))
            window = recorded.values[first : last + 1, column]
            tops.append(float(np.nanmax(window)) if np.isfinite(window).any() else -np.inf)
        top = np.sort(np.array(tops))[::-1]
        enough = (top >= chosen.high).sum() >= chosen.many and (top >= chosen.lower).sum() >= chosen.many + chosen.more
        if enough and one.direction in chosen.directions:
            kept.append(one)
    return kept


class Passage(NamedTuple):
    """A pellet over a marked stretch: when it reached both marks [s], and its mean speed between them [mm/s].

    speed is None where it did not get there, and `why` says so.
    """

    track: str
    begin: float | None
    end: float | None
    speed: float | None
    diameter: float | None
    why: str


def passage(track: Track, first: float, last: float) -> Passage:
    """The first passage of a pellet from one mark to another [mm]; linear between the positions that were seen."""
    if first == last:
        raise ConfigurationError(f"both marks are at {first:g} mm; give a stretch with a length")
    begin = _reaches(track, first, last > first, -np.inf)
    if begin is None:
        return Passage(track.name, None, None, None, track.diameter, f"did not pass {first:g} mm")
    end = _reaches(track, last, last > first, begin)
    if end is None or end == begin:
        return Passage(track.name, begin, None, None, track.diameter, f"did not reach {last:g} mm")
    return Passage(track.name, begin, end, (last - first) / (end - begin), track.diameter, "")


def _reaches(track: Track, mark: float, upwards: bool, after: float) -> float | None:
    sign = 1.0 if upwards else -1.0
    ahead = sign * (track.position - mark) >= 0.0
    for k in np.flatnonzero(ahead[1:] & ~ahead[:-1]) + 1:
        a, b = float(track.position[k - 1]), float(track.position[k])
        when = float(track.time[k - 1] + (mark - a) / (b - a) * (track.time[k] - track.time[k - 1]))
        if when >= after:
            return when
    return float(track.time[0]) if bool(ahead[0]) and track.position[0] == mark and track.time[0] >= after else None


def velocity(track: Track, window: float) -> tuple[Floats, Floats]:
    """Times [s] and velocities [mm/s] of a pellet: slopes of straight lines through what lies within `window` [s]."""
    if not window > 0.0:
        raise ConfigurationError(f"window = {shown(window)} s must be above 0")
    found = []
    for when in track.time:
        near = np.abs(track.time - when) <= 0.5 * window + 1e-9
        if near.sum() < 2:
            near = np.zeros_like(near)
            k = int(np.clip(np.searchsorted(track.time, when), 1, track.time.size - 1))
            near[k - 1 : k + 1] = True
        t, x = track.time[near] - track.time[near].mean(), track.position[near]
        found.append(float(t @ x / (t @ t)))
    return track.time, np.array(found)


def velocity_against_diameter(
    track: Track, recorded: Map, window: float, behind: float = 0.0
) -> tuple[Floats, Floats, Floats]:
    """Times [s], velocities of a pellet [mm/s] and the diameter of the gut at its place, or `behind` it [mm].

    Times outside of the map, and places outside of it or in a gap, are left out.
    """
    time, speed = velocity(track, window)
    place = track.position - behind
    inside = (time >= recorded.time[0]) & (time <= recorded.time[-1])
    inside &= (place >= recorded.place[0]) & (place <= recorded.place[-1])
    rows = np.clip(np.searchsorted(recorded.time, time), 1, recorded.time.size - 1)
    share = (time - recorded.time[rows - 1]) / (recorded.time[rows] - recorded.time[rows - 1])
    width = np.full(time.size, np.nan)
    for k in np.flatnonzero(inside):
        early, late = (np.interp(place[k], recorded.place, recorded.values[row]) for row in (rows[k] - 1, rows[k]))
        width[k] = (1.0 - share[k]) * early + share[k] * late
    kept = np.isfinite(width)
    if not kept.any():
        raise ConfigurationError(f"track {shown(track.name)} and {recorded.name} share no time and place; check both")
    return time[kept], speed[kept], width[kept]


def occlusion(recorded: Map) -> Map:
    """How far each place is closed against its median over time, as strain: -0.4 is 40 % narrower."""
    if recorded.quantity != "diameter":
        raise ConfigurationError(f"{recorded.name} is a map of {recorded.quantity}; occlusion is about diameters")
    level = median_of_places(recorded.values)
    level = np.where(level > 0.0, level, np.nan)  # a place that is closed more often than not has no rest to close from
    return recorded.done(
        "diameter over its median at each place, less 1", values=recorded.values / level - 1.0, quantity="strain"
    )
