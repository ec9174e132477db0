"""The oral pacemaker as a train of pulses: once, or as periodic slow waves."""

from __future__ import annotations

from typing import NamedTuple

from .pulses import RING, Pulse


class PulseTrain(NamedTuple):
    """`pulses` pulses of `duration` every `period` [s] from `onset`, over z in [low, high] [cm], in uA/cm^2.

    Around the ring they reach over `sector` [rad], centred at `angle`.
    """

    onset: float
    period: float
    pulses: int
    duration: float
    intensity: float
    low: float
    high: float
    angle: float = 0.0
    sector: float = RING

    def between(self, start: float, stop: float) -> list[Pulse]:
        """The pulses that are on at some time in [start, stop] [s]."""
        if self.pulses <= 0 or stop <= self.onset:
            return []
        first = max(0, int((start - self.onset - self.duration) / self.period)) if self.pulses > 1 else 0
        found = []
        for k in range(first, self.pulses):
            begin = self.onset + k * self.period
            if begin >= stop:
                break
            if begin + self.duration > start:
                end = begin + self.duration
                found.append(Pulse(begin, end, self.low, self.high, self.intensity, self.angle, self.sector))
        return found
