"""`peristalsis warm-up`: compile the kernels of runs to come, once on a machine."""

from __future__ import annotations

from .inputs import Input
from .streams import Screen


def warm_up(described: Input, surface: bool, explicit: bool, screen: Screen) -> int:
    """Have the kernels of a configuration ready, those of the whole surface and the explicit scheme where asked for."""
    from ..numerics.compiled import CACHE_FOLDER
    from ..running.warm_up import warmed

    configuration = described.configuration()
    surface = surface or configuration.grid.n_theta > 1
    explicit = explicit or configuration.solver.integrator == "explicit"
    found = warmed(surface, explicit, configuration.parts_chosen())
    place = "nowhere: no folder for them can be written" if CACHE_FOLDER is None else str(CACHE_FOLDER)
    made = f"{found.compiled} of them compiled now, kept in {place}" if found.compiled else "none had to be compiled"
    screen.say(f"{found.kernels} kernels are ready after {found.seconds:.1f} s; {made}")
    screen.answer({"kernels": found.kernels, "compiled": found.compiled, "seconds": found.seconds, "kept in": place})
    return 0
