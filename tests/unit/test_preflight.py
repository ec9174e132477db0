"""Warnings before a run: the shipped grids pass, twice coarser ones do not."""

from __future__ import annotations

import pytest

from peristalsis import preflight
from peristalsis.config import Configuration


def test_shipped_grids_pass() -> None:
    for reading in ("tight", "stretched", "printed"):
        assert preflight.remarks(Configuration(reading=reading)) == []


@pytest.mark.parametrize(("key", "count"), [("grid.n_z", 500), ("grid.n_z_wall", 400)])
def test_twice_coarser_warns_and_names_a_cure(key: str, count: int) -> None:
    config = Configuration().with_changes({key: count})
    (remark,) = preflight.remarks(config)
    assert remark.startswith(f"{key} = {count}")
    needed = int(remark.rpartition("Use ")[2].split()[0])
    assert preflight.remarks(config.with_changes({key: needed})) == []


def test_slower_kinetics_make_a_longer_foot() -> None:
    """D/c with c ~ sqrt(D rate): a quarter of the rate doubles the foot."""
    slow = Configuration().with_changes({"tissue.kinetics_rate": 0.125 / 4})
    ratio = preflight.foot_length(slow, "circular") / preflight.foot_length(Configuration(), "circular")
    assert ratio == pytest.approx(2.0)


def test_no_wave_no_warning() -> None:
    still = {"longitudinal.conduction": False, "circular.conduction": False, "grid.n_z": 100, "grid.n_z_wall": 50}
    assert preflight.remarks(Configuration().with_changes(still)) == []
