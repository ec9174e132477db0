"""The ghost rings and the flux of the conduction operator, column by column, Eq. (30)."""

import numpy as np

from peristalsis.tissue.conduction import GHOSTS, diffuse, fill_ghosts
from verification.exact.cable import apply_operator


def test_ghosts_mirror_the_potential_over_both_ends() -> None:
    padded = np.arange(10.0)
    fill_ghosts(padded, 1)
    assert padded.tolist() == [3, 2, 2, 3, 4, 5, 6, 7, 7, 6]


def test_uniform_potential_carries_no_current() -> None:
    assert np.abs(apply_operator(np.full(30, -62.5), 1.0, 0.01)).max() == 0.0


def test_mirrored_potential_gives_a_mirrored_rate() -> None:
    """Neither end is preferred: bit for bit."""
    potential = np.random.default_rng(5).normal(size=41)
    forward, back = (apply_operator(v, 1.0, 0.1) for v in (potential, potential[::-1]))
    assert np.abs(forward - back[::-1]).max() <= 1e-12 * np.abs(forward).max()


def test_columns_do_not_mix() -> None:
    """Flattened (z, theta): each column is a cable of its own."""
    rng = np.random.default_rng(6)
    sheet = rng.normal(size=(20, 3))
    padded = np.zeros((20 + 2 * GHOSTS, 3))
    padded[GHOSTS:-GHOSTS] = sheet
    flat, rate = padded.ravel(), np.empty(60)
    fill_ghosts(flat, 3)
    diffuse(flat, np.full(57, 1.0 / (24.0 * 0.1) ** 2), np.zeros(23 * 3), rate, 3)
    alone = np.stack([apply_operator(np.ascontiguousarray(sheet[:, j]), 1.0, 0.1) for j in range(3)], axis=1)
    assert np.abs(rate.reshape(20, 3) - alone).max() <= 1e-12
