"""What a step cost."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class StepReport:
    """What a step cost: Newton iterations, assemblies of the wall, wall solves (more than one after halving).

    krylov_iterations: of the linear solver on the whole surface.
    halved: why the whole step was made in parts, empty if it was not.
    """

    newton_iterations: int
    assemblies: int
    wall_solves: int
    krylov_iterations: int = 0
    halved: str = ""
