"""Boundaries between classes found with few evaluations: the same classes as on the full grid."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import pytest

from peristalsis.many.studies.boundary import Node, refine, spacing_of

Field = Callable[[float, float], str]


def circle(x: float, y: float) -> str:
    return "in" if x * x + y * y < 0.5 else "out"


def island(x: float, y: float) -> str:
    return "in" if math.hypot(x - 0.5, y - 0.5) < 0.1 else "out"


def three(x: float, y: float) -> str:
    return "a" if y < 0.4 + 0.2 * math.sin(7.0 * x) else "b" if x < 0.6 else "c"


def band(x: float, y: float) -> str:
    return "in" if abs(y - 0.3 - 0.3 * x) < 0.03 else "out"


def refined(field: Field, nodes: int, coarse: int):
    asked: list[Node] = []

    def evaluate(wanted: Sequence[Node]) -> dict[Node, str]:
        asked.extend(wanted)
        return {(i, j): field(i / (nodes - 1), j / (nodes - 1)) for i, j in wanted}

    found = refine((nodes, nodes), (coarse, coarse), evaluate)
    assert len(asked) == len(set(asked)) == len(found.evaluated), "nothing is evaluated twice"
    return found


@pytest.mark.parametrize(("nodes", "coarse"), [(33, 5), (33, 9), (65, 9)])
@pytest.mark.parametrize("field", [circle, island, three, band])
def test_the_same_classes_as_on_the_full_grid(field: Field, nodes: int, coarse: int) -> None:
    found = refined(field, nodes, coarse)
    full = tuple(tuple(field(i / (nodes - 1), j / (nodes - 1)) for j in range(nodes)) for i in range(nodes))
    assert found.classes == full
    assert found.share < 1.0 / 3.0 or (field in (three, band) and nodes == 33)


def test_a_boundary_is_followed_into_cells_whose_corners_agree() -> None:
    """A tongue that one coarse node meets, and that goes on into coarse cells between their corners."""

    def tongue(x: float, y: float) -> str:
        return "in" if abs(y - 0.5 - 0.35 * x) < 0.06 else "out"

    assert {tongue(x, y) for x in (0.5, 1.0) for y in (0.0, 0.5, 1.0)} == {"out"}
    found = refined(tongue, 33, 3)
    assert found.classes == tuple(tuple(tongue(i / 32, j / 32) for j in range(33)) for i in range(33))


def test_one_class_needs_the_coarse_grid_alone() -> None:
    found = refined(lambda x, y: "all", 33, 5)
    assert len(found.evaluated) == 25
    assert found.crossings() == []


def test_crossings_are_where_neighbours_differ() -> None:
    found = refined(lambda x, y: "left" if x < 0.4 else "right", 5, 3)
    assert found.crossings() == [((1, j), (2, j)) for j in range(5)]


@pytest.mark.parametrize(("fine", "coarse"), [(33, 10), (33, 12), (9, 17), (7, 3), (33, 1)])
def test_grids_that_do_not_divide_are_refused(fine: int, coarse: int) -> None:
    with pytest.raises(ValueError, match="power of two"):
        spacing_of((fine, fine), (coarse, coarse))


def test_grids_that_divide() -> None:
    assert spacing_of((33, 17), (9, 5)) == 4
    assert spacing_of((9, 9), (9, 9)) == 1
