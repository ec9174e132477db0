"""What a step cost, and what it was made of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from .model import Model
from .state import State


class Part(NamedTuple):
    """One of the shorter steps that a step was made in: the model with its own length, the states of its two ends."""

    model: Model
    before: State
    after: State


@dataclass(frozen=True)
class StepReport:
    """What a step cost: Newton iterations, assemblies of the wall, wall solves (more than one after halving).

    krylov_iterations: of the linear solver on the whole surface.
    halved: why the whole step was made in parts, empty if it was not.
    parts: what a step whose length follows its error was made of, empty for a step made as a whole; rejected: how
    often it was tried with a longer one.
    """

    newton_iterations: int
    assemblies: int
    wall_solves: int
    krylov_iterations: int = 0
    halved: str = ""
    parts: tuple[Part, ...] = ()
    rejected: int = 0

    def made_of(self, model: Model, before: State, after: State) -> Iterator[Part]:
        """The parts of the step from `before` to `after`: itself, if it was made as a whole."""
        yield from self.parts or (Part(model, before, after),)
