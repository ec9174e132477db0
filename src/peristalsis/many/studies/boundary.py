"""Classes on a grid of two parameters with few evaluations: cells are divided only where a boundary runs through them.

A coarse grid is classified first. A cell whose corners differ is divided into four, and so is a neighbour on whose side
a new corner differs from the ends of that side: a boundary that is met once is followed wherever it goes. What lies
inside a cell of one class has that class. A feature that is missed by the coarse grid and by all that is divided is not
seen: the coarse grid must be as fine as the smallest island.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

Node = tuple[int, int]
Evaluate = Callable[[Sequence[Node]], Mapping[Node, str]]
"""Classes of many nodes at once."""


@dataclass(frozen=True)
class Refined:
    """Class of every node, (n, m) by index; and the nodes that were evaluated."""

    classes: tuple[tuple[str, ...], ...]
    evaluated: frozenset[Node]

    @property
    def share(self) -> float:
        """Evaluations over those of the full grid."""
        return len(self.evaluated) / (len(self.classes) * len(self.classes[0]))

    def crossings(self) -> list[tuple[Node, Node]]:
        """Pairs of neighbouring nodes of different class."""
        found: list[tuple[Node, Node]] = []
        for i, row in enumerate(self.classes):
            for j, one in enumerate(row):
                if i + 1 < len(self.classes) and self.classes[i + 1][j] != one:
                    found.append(((i, j), (i + 1, j)))
                if j + 1 < len(row) and row[j + 1] != one:
                    found.append(((i, j), (i, j + 1)))
        return found


def refine(shape: tuple[int, int], coarse: tuple[int, int], evaluate: Evaluate) -> Refined:
    """Classes on a grid of `shape` nodes, from a coarse one of `coarse` nodes on the same ends.

    Raises ValueError unless the fine grid divides the coarse one by the same power of two both ways.
    """
    spacing = spacing_of(shape, coarse)
    known: dict[Node, str] = {}

    def know(nodes: Iterable[Node]) -> None:
        wanted = [node for node in dict.fromkeys(nodes) if node not in known]
        if wanted:
            found = evaluate(wanted)
            known.update({node: found[node] for node in wanted})

    cells = {(i, j): spacing for i in range(0, shape[0] - 1, spacing) for j in range(0, shape[1] - 1, spacing)}
    know(corner for cell, size in cells.items() for corner in _corners(cell, size))
    while mixed := [one for one in sorted(cells.items()) if one[1] > 1 and _is_mixed(*one, known)]:
        know((i + a * size // 2, j + b * size // 2) for (i, j), size in mixed for a in range(3) for b in range(3))
        for (i, j), size in mixed:
            del cells[i, j]
            half = size // 2
            cells |= {(i + a, j + b): half for a in (0, half) for b in (0, half)}
    classes = [["" for _ in range(shape[1])] for _ in range(shape[0])]
    for (i, j), size in cells.items():
        for a in range(i, i + size + 1):
            for b in range(j, j + size + 1):
                classes[a][b] = known[(i, j)]
    for (i, j), name in known.items():
        classes[i][j] = name
    return Refined(tuple(map(tuple, classes)), frozenset(known))


def spacing_of(shape: tuple[int, int], coarse: tuple[int, int]) -> int:
    """How many fine intervals a coarse one has. Raises ValueError unless it is one power of two both ways."""
    ratios = {divmod(fine - 1, few - 1) if few > 1 else (0, 1) for fine, few in zip(shape, coarse, strict=True)}
    spacing, rest = ratios.pop()
    if ratios or rest or spacing < 1 or spacing & (spacing - 1):
        raise ValueError(f"{shape} nodes do not divide {coarse} by a power of two")
    return spacing


def _corners(cell: Node, size: int) -> list[Node]:
    i, j = cell
    return [(i, j), (i, j + size), (i + size, j), (i + size, j + size)]


def _is_mixed(cell: Node, size: int, known: Mapping[Node, str]) -> bool:
    """Whether what is known of a cell's corners, sides and inside is of more than one class."""
    i, j = cell
    first = known[cell]
    for a in range(i, i + size + 1):
        for b in range(j, j + size + 1):
            if known.get((a, b), first) != first:
                return True
    return False
