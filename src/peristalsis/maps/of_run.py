"""Maps of a run, the same objects as those of a recording: `result.maps.diameter`, `.pressure()` and so on."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ConfigurationError
from ..plots import data
from .recording import EVEN, Floats, Map, Track

if TYPE_CHECKING:
    from ..results.result import Result

SPACING = 10.0
"""Distance between the channels of a catheter unless another is asked for [mm]."""


class RunMaps:
    """What a run would look like to a laboratory: places are fixed in space, from the oral end of the segment [mm].

    A last field that was stored out of step, where a run ended, is left out, and the history says so.
    """

    def __init__(self, result: Result) -> None:
        self._result = result
        self._name = str(result.summary["scenario"])

    @cached_property
    def diameter(self) -> Map:
        """Inner diameter [mm]; that of the circle with the area of the ring where it varies around."""
        return self._map("diameter", *data.diameter_map(self._result))

    @cached_property
    def stretch(self) -> Map:
        """Longitudinal stretch of the wall, seen from outside. Raises ConfigurationError where it was not stored."""
        self._needs("stretch_longitudinal")
        axis = data.laboratory_axis(self._result)
        field = data.around(self._result, "stretch_longitudinal")
        return self._map(
            "stretch", data.values(self._result, "time"), axis, data.in_laboratory(self._result, field, axis)
        )

    def pressure(self, spacing: float = SPACING) -> Map:
        """What channels `spacing` [mm] apart would read [mmHg]: lumen pressure, and contact with the pellet."""
        self._needs("contact_pressure")
        return self._map("pressure", *data.manometry(self._result, spacing))

    @cached_property
    def pellet(self) -> Track:
        """Where the pellet's centre was, at every step, with the pellet's girth. Raises ConfigurationError if none."""
        if not data.has_pellet(self._result):
            raise ConfigurationError("this run has no pellet (pellet.enabled = false), so there is no track of it")
        time, position = data.values(self._result, "time_step"), data.values(self._result, "pellet_position", "mm")
        size = 20.0 * float(self._result.configuration.pellet.radius)
        return Track(time, position, f"pellet, {self._name}", size, (f"run of {self._name}",))

    def _needs(self, field: str) -> None:
        if field not in self._result.arrays:
            raise ConfigurationError(f"the run did not store {field}; name it in output.fields and run again")

    def _map(self, quantity: str, time: Floats, place: Floats, values: Floats) -> Map:
        history = [f"run of {self._name}"]
        steps = np.diff(time)
        if steps.size > 1 and abs(steps[-1] - steps[0]) > EVEN * steps[0]:
            time, values = time[:-1], values[:-1]
            history.append("without the last field, stored out of step at the end of the run")
        return Map(values, time, place, quantity, self._name, tuple(history))
