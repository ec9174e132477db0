"""Flexible GMRES: the residual is minimised over a space that a preconditioner, which may change, has spanned.

Source: Y. Saad, "A flexible inner-outer preconditioned GMRES algorithm", SIAM J. Sci. Comput. 14 (1993) 461-469.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[Any]

ENDED = 45.0
"""The space is exhausted where a new direction is that many roundings of what it was made from."""


class KrylovSolution(NamedTuple):
    """Solution, norm of its residual and the number of iterations."""

    solution: Floats
    residual: float
    iterations: int


def flexible_gmres(
    apply: Callable[[Floats], Floats],
    precondition: Callable[[Floats, float], Floats],
    right: Floats,
    target: float,
    most: int,
) -> KrylovSolution:
    """Solve apply(x) = right until the residual's norm is at most `target` or `most` iterations are done.

    precondition(v, size) is given unit vectors, and the size that they had in the residual at that time. Vectors are in
    single or double precision, as `right` is.
    """
    norm = float(np.linalg.norm(right))
    if norm <= target or most < 1:
        return KrylovSolution(np.zeros_like(right), norm, 0)
    kind = right.dtype
    smallest = ENDED * float(np.finfo(kind).eps)
    basis = np.empty((most + 1, right.size), kind)
    spanned = np.empty((most, right.size), kind)
    hessenberg = np.zeros((most + 1, most))
    cosine, sine = np.zeros(most), np.zeros(most)
    rotated = np.zeros(most + 1)
    rotated[0] = norm
    basis[0] = right / norm
    used = 0
    for k in range(most):
        spanned[k] = precondition(basis[k], abs(rotated[k]))
        image = apply(spanned[k])
        start = float(np.linalg.norm(image))
        weights = basis[: k + 1] @ image
        image = image - weights @ basis[: k + 1]
        again = basis[: k + 1] @ image
        image -= again @ basis[: k + 1]
        column = hessenberg[:, k]
        column[: k + 1] = weights + again
        column[k + 1] = np.linalg.norm(image)
        ended = bool(column[k + 1] <= smallest * start)
        if not ended:
            basis[k + 1] = image / float(column[k + 1])
        for q in range(k):
            upper = cosine[q] * column[q] + sine[q] * column[q + 1]
            column[q + 1] = cosine[q] * column[q + 1] - sine[q] * column[q]
            column[q] = upper
        size = float(np.hypot(column[k], column[k + 1]))
        if size == 0.0:
            break
        cosine[k], sine[k] = column[k] / size, column[k + 1] / size
        column[k], column[k + 1] = size, 0.0
        rotated[k + 1] = -sine[k] * rotated[k]
        rotated[k] *= cosine[k]
        used = k + 1
        if abs(rotated[k + 1]) <= target or ended:
            break
    shares = np.linalg.solve(np.triu(hessenberg[:used, :used]), rotated[:used]) if used else np.zeros(0)
    return KrylovSolution(shares.astype(kind) @ spanned[:used], float(abs(rotated[used])), used)
