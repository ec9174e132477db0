"""What a string pulls the pellet back with: a weight or a spring, Eq. (123)."""

from __future__ import annotations

from ..numerics.compiled import compiled
from .constants import PelletConstants


@compiled
def pull_of_load(place: float, pellet: PelletConstants) -> tuple[float, float]:
    """Pull towards the oral end [mN] on a pellet whose centre is at `place` [cm], and its derivative by that [mN/cm].

    A string that is slack at `pull_from` stretches with `pull_stiffness` until it lifts the weight `pull`.
    """
    stretched = place - pellet.pull_from
    if pellet.pull_stiffness == 0.0 or stretched <= 0.0:
        return 0.0, 0.0
    pulls = pellet.pull_stiffness * stretched
    if pulls >= pellet.pull:
        return pellet.pull, 0.0
    return pulls, pellet.pull_stiffness
