"""Stimuli: what is delivered does not depend on the step or on the cells, Eq. (24)."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis.control.pulses import Pulse, add_pulses, covered, covered_around, overlap_in_time


@given(
    st.floats(0.0, 0.3),
    st.floats(0.001, 0.3),
    st.floats(0.0, 8.0),
    st.floats(0.01, 2.0),
    st.integers(1, 300),
    st.integers(8, 200),
)
def test_charge_does_not_depend_on_step_and_grid(
    begin: float, duration: float, low: float, width: float, steps: int, cells: int
) -> None:
    """Strength x duration x width, for any step that the pulse begins and ends inside of, and any cells."""
    h = 10.0 / cells
    z = (np.arange(cells) + 0.5) * h
    pulse = Pulse(begin, begin + duration, low, low + width, 2.5)
    ends, charge = np.linspace(0.0, 1.0, steps + 1), 0.0
    for start, stop in pairwise(ends):
        drive = np.zeros((cells, 2))
        add_pulses([pulse], z, h, start, stop, drive)
        charge += drive[:, 1].sum() * h * (stop - start)
    assert charge == pytest.approx(2.5 * duration * width, rel=1e-9)


def test_pulses_add_up() -> None:
    drive = np.zeros((10, 1))
    z = np.arange(10) + 0.5
    add_pulses([Pulse(0, 1, 0, 3, 2.0), Pulse(0, 0.5, 2, 4, 1.0)], z, 1.0, 0.0, 1.0, drive)
    assert drive[:, 0].tolist() == [2, 2, 2.5, 0.5, 0, 0, 0, 0, 0, 0]


def test_partly_covered_cells_and_steps_count_in_part() -> None:
    assert covered(np.array([0.0, 1.0]), np.array([1.0, 2.0]), 0.25, 1.5).tolist() == [0.75, 0.5]
    assert overlap_in_time(0.2, 0.7, 0.5, 1.0) == pytest.approx(0.4)
    assert overlap_in_time(2.0, 3.0, 0.5, 1.0) == 0.0


@given(st.floats(-7.0, 7.0), st.floats(0.01, 6.2), st.integers(1, 64))
def test_charge_around_the_ring_does_not_depend_on_angle_and_columns(angle: float, sector: float, columns: int) -> None:
    """A sector brings its share of the ring wherever it lies, across the angle 0 too."""
    drive = np.zeros((1, columns))
    add_pulses([Pulse(0.0, 1.0, 0.0, 1.0, 2.0, angle, sector)], np.array([0.5]), 1.0, 0.0, 1.0, drive)
    assert drive.mean() == pytest.approx(2.0 * sector / (2.0 * np.pi), rel=1e-9)
    assert drive.max() <= 2.0 * (1.0 + 1e-9)


def test_a_sector_lies_about_its_angle() -> None:
    assert covered_around(8, np.pi / 2.0, np.pi / 2.0).tolist() == pytest.approx([0, 0.5, 1, 0.5, 0, 0, 0, 0])
    assert covered_around(8, 0.0, 2.0 * np.pi).tolist() == [1.0] * 8


def test_cells_answer_as_their_response_says() -> None:
    drive = np.zeros((2, 3))
    add_pulses([Pulse(0, 1, 0, 2, 2.0)], np.array([0.5, 1.5]), 1.0, 0.0, 1.0, drive, np.array([[0, 1, 2], [3, 4, 5]]))
    assert drive.tolist() == [[0, 2, 4], [6, 8, 10]]
