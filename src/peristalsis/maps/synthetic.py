"""Recordings with a known answer: rings of contraction with noise, drift and dropped frames, from a seed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import ConfigurationError, shown
from .recording import QUANTITIES, Floats, Map, Track, locked

STANDING = float("inf")


@dataclass(frozen=True)
class Ring:
    """One contraction, the truth of a recording. It is a bell in time at each place, of `duration` at half its height.

    begin [s] at `place` [mm], where it starts; speed [mm/s], above 0 towards the anal end, below it towards the oral
    one, STANDING at all places at once; extent [mm] from `place` on, towards the anal end if it stands; amplitude in
    the unit of the map. fade: share of the amplitude that is lost along the way.
    """

    begin: float
    place: float
    speed: float
    extent: float
    amplitude: float
    duration: float = 3.0
    fade: float = 0.0

    @property
    def direction(self) -> str:
        """antegrade, retrograde or standing."""
        return "standing" if np.isinf(self.speed) else "antegrade" if self.speed > 0.0 else "retrograde"

    @property
    def span(self) -> tuple[float, float]:
        """From where to where it reaches [mm], the oral end first."""
        other = self.place + (-self.extent if self.speed < 0.0 else self.extent)
        return min(self.place, other), max(self.place, other)

    def arrival(self, place: Floats) -> Floats:
        """When it is deepest at places [mm], reached or not [s]."""
        return self.begin + (place - self.place) / self.speed

    def depth(self, time: Floats, place: Floats) -> Floats:
        """Its height over time and place, (n_time, n_place), in the unit of the map."""
        sigma = self.duration / (2.0 * np.sqrt(2.0 * np.log(2.0)))
        along = np.abs(place - self.place) / self.extent
        low, high = self.span
        soft = 1.5  # mm over which the ends of the path come and go
        window = 0.25 * (1.0 + np.tanh((place - low) / soft)) * (1.0 + np.tanh((high - place) / soft))
        height = self.amplitude * window * np.clip(1.0 - self.fade * along, 0.0, None)
        late = (time[:, None] - self.arrival(place)[None, :]) / sigma
        return np.asarray(height * np.exp(-0.5 * late * late))


def recording(
    rings: Sequence[Ring],
    duration: float,
    time_step: float = 0.1,
    place: Floats | None = None,
    quantity: str = "diameter",
    rest: float = 12.0,
    noise: float = 0.0,
    drift: float = 0.0,
    dropped: float = 0.0,
    seed: int = 0,
) -> Map:
    """A map of rings over `duration` [s], with what recordings have besides.

    place: places [mm], 0 to 100 every 1 unless given. rest: value without contraction. noise: its standard deviation;
    drift: height of a slow wave of 0.7 periods, other at each place; both in the unit of the map. dropped: share of the
    frames that are missing, alone and in bursts of up to ten. Where rings overlap, the deeper one counts. Equal
    arguments give equal bits.
    """
    if not duration > time_step > 0.0 or not 0.0 <= dropped < 1.0:
        raise ConfigurationError(
            f"duration = {shown(duration)}, time_step = {shown(time_step)}, dropped = {shown(dropped)}: give a "
            "duration above the step and a share below 1"
        )
    random = np.random.default_rng(seed)
    axis = np.arange(0.0, 100.5, 1.0) if place is None else np.asarray(place, dtype=np.float64)
    time = time_step * np.arange(round(duration / time_step) + 1, dtype=np.float64)
    depth = np.zeros((time.size, axis.size))
    for ring in rings:
        np.maximum(depth, ring.depth(time, axis), out=depth)
    values = rest + QUANTITIES[quantity].contraction * depth
    if drift:
        phase = random.uniform(0.0, 2.0 * np.pi) + 0.02 * axis
        values += drift * np.sin(2.0 * np.pi * 0.7 * time[:, None] / duration + phase)
    if noise:
        values += noise * random.standard_normal(values.shape)
    if dropped:
        missing = np.zeros(time.size, dtype=bool)
        while missing.mean() < dropped:
            first = int(random.integers(time.size))
            missing[first : first + int(random.integers(1, 11))] = True
        values[missing] = np.nan
    line = (
        f"synthetic: {len(rings)} rings, noise {noise:g}, drift {drift:g} {QUANTITIES[quantity].unit}, "
        f"{100.0 * dropped:g} % of the frames dropped, seed {seed}"
    )
    return Map(locked(values), time, axis, quantity, "synthetic", (line,))


def example(seed: int = 1) -> tuple[Map, tuple[Ring, ...], Track]:
    """The recording of the tutorial, its truth, and the pellet that its last rings drive.

    Five minutes of a colon of 100 mm at 10 Hz: rings every 40 s towards the anal end, one back, one that stands.
    """
    random = np.random.default_rng(seed)
    waves = [
        Ring(20.0 + 40.0 * k, 5.0, float(random.uniform(1.8, 2.6)), 85.0, float(random.uniform(4.0, 5.5)), 4.0)
        for k in range(6)
    ]
    rings = (*waves, Ring(245.0, 70.0, -3.0, 45.0, 3.5, 3.0), Ring(285.0, 30.0, STANDING, 30.0, 3.5, 3.0))
    made = recording(rings, 300.0, noise=0.4, drift=0.5, dropped=0.02, seed=seed)
    pushing = waves[1]
    time = np.arange(0.0, 120.0, 0.5)
    position = np.clip(pushing.place + 12.0 + pushing.speed * (time - pushing.begin), 20.0, 92.0)
    return replace(made, name="rings"), rings, Track(time, position, "pellet", history=("synthetic",))
