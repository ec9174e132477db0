"""Waves found in activation times that are made by hand, with known answers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from peristalsis.results.measures import FASTEST, Speed, in_order, speed_of_passage, wave_speed
from peristalsis.results.waves import CONDUCTED, SPONTANEOUS, STIMULATED, Wave, waves

LENGTH = 10.0
Z = (np.arange(200) + 0.5) * LENGTH / 200
SPEED = 4.2


def passage(times: np.ndarray) -> Speed:
    return speed_of_passage(Z, times, LENGTH)


def found(*fronts: np.ndarray, origin: int = STIMULATED) -> list[Wave]:
    """The waves of fronts given by their times of arrival, nan where they do not come; each begins by `origin`."""
    time, cell, kind = [], [], []
    for front in fronts:
        there = np.flatnonzero(np.isfinite(front))
        time.append(front[there])
        cell.append(there)
        kind.append(np.where(front[there] <= front[there].min() + 1e-9, origin, CONDUCTED))
    return waves(Z, np.concatenate(time), np.concatenate(cell), np.concatenate(kind))


def test_antegrade_wave_has_its_speed() -> None:
    speed = passage(0.3 + Z / SPEED)
    assert speed.speed == pytest.approx(SPEED, rel=1e-12)
    assert speed.reason is None
    assert speed.residual == pytest.approx(0.0, abs=1e-12)
    assert speed.cells == 100
    (wave,) = found(0.3 + Z / SPEED)
    assert (wave.start, wave.end) == (pytest.approx(Z[0]), pytest.approx(Z[-1]))
    assert wave.direction == "antegrade"
    assert wave.origin == "stimulus"
    assert wave.speed == pytest.approx(SPEED, rel=1e-9)
    assert wave.time == pytest.approx(0.3 + Z[0] / SPEED)


def test_retrograde_wave_has_a_negative_speed() -> None:
    times = 0.3 + (LENGTH - Z) / SPEED
    assert passage(times).speed == pytest.approx(-SPEED, rel=1e-12)
    (wave,) = found(times, origin=SPONTANEOUS)
    assert wave.direction == "retrograde"
    assert wave.origin == "spontaneous"
    assert wave.start > wave.end
    assert wave.speed == pytest.approx(-SPEED, rel=1e-9)


def test_each_of_two_waves_is_found() -> None:
    first, second = found(Z / SPEED, 1.0 + Z / 2.5)
    assert first.speed == pytest.approx(SPEED, rel=1e-9)
    assert second.speed == pytest.approx(2.5, rel=1e-9)
    assert second.time - first.time == pytest.approx(1.0 + Z[0] * (1 / 2.5 - 1 / SPEED))


def test_fronts_that_meet_are_two_waves_and_no_speed_of_passage() -> None:
    times = np.minimum(Z, LENGTH - Z) / SPEED
    speed = passage(times)
    assert speed.speed is None
    assert "not reached in order" in str(speed.reason)
    first, second = found(times)
    assert {first.direction, second.direction} == {"antegrade", "retrograde"}
    assert abs(first.end - second.end) < 0.2, "they meet"
    assert sorted([first.speed, second.speed]) == pytest.approx([-SPEED, SPEED], rel=1e-9)


def test_wave_that_begins_in_the_middle_runs_both_ways() -> None:
    times = np.abs(Z - 5.0) / SPEED
    assert passage(times).speed is None
    first, second = found(times)
    assert first.start == pytest.approx(5.0, abs=0.1)
    assert second.start == pytest.approx(5.0, abs=0.1)
    assert {first.direction, second.direction} == {"antegrade", "retrograde"}


@pytest.mark.parametrize("times", [np.full(200, 0.5), 0.5 + 1e-4 * Z, 0.5 - 1e-17 * Z])
def test_cells_that_fire_together_have_no_speed(times: np.ndarray) -> None:
    """A plateau is not a wave of 1e19 cm/s."""
    speed = passage(times)
    assert speed.speed is None
    assert "together" in str(speed.reason)
    (wave,) = found(times)
    assert wave.direction == "standing"
    assert math.isnan(wave.speed)


def test_cell_that_stays_silent_does_not_stop_the_wave() -> None:
    times = Z / SPEED
    times[100] = np.nan
    speed = passage(times)
    assert speed.speed == pytest.approx(SPEED, rel=1e-9)
    assert speed.cells == 99
    (wave,) = found(times)
    assert wave.end == pytest.approx(Z[-1])


def test_wave_that_stops_in_the_middle_has_no_speed_of_passage() -> None:
    times = np.where(Z < 6.0, Z / SPEED, np.nan)
    speed = passage(times)
    assert speed.speed is None
    assert speed.reason == "no wave passed: 60 of 100 cells between 3 and 8 cm were reached"
    (wave,) = found(times)
    assert wave.end == pytest.approx(6.0, abs=0.1)


def test_noise_leaves_the_speed_and_shows_in_the_residual() -> None:
    noise = np.random.default_rng(1).normal(0.0, 1e-3, Z.size)
    speed = passage(Z / SPEED + noise)
    assert speed.speed == pytest.approx(SPEED, rel=0.01)
    assert speed.residual == pytest.approx(1e-3, rel=0.3)
    (wave,) = found(Z / SPEED + noise)
    assert wave.speed == pytest.approx(SPEED, rel=0.01)


def test_delay_in_the_middle_is_no_one_speed() -> None:
    """Two fast halves with a long wait between them: a line through them would be a number and no speed."""
    speed = passage(Z / SPEED + np.where(Z > 5.5, 3.0, 0.0))
    assert speed.speed is None
    assert "no one speed" in str(speed.reason)
    assert speed.share is not None
    assert speed.share > 0.1


def test_some_cells_out_of_order_are_left_out() -> None:
    times = Z / SPEED
    times[[90, 120]] += 0.8
    speed = passage(times)
    assert speed.speed == pytest.approx(SPEED, rel=1e-9)
    assert speed.cells == 98


def test_fast_part_goes_with_the_length() -> None:
    """The middle half of any tube; of 10 cm it is 3 to 8 cm."""
    times = np.where((Z > 3.0) & (Z < 8.0), Z / SPEED, np.nan)
    assert passage(times).speed == pytest.approx(SPEED)
    assert speed_of_passage(0.2 * Z, times, 2.0).speed == pytest.approx(0.2 * SPEED)
    assert speed_of_passage(0.2 * Z, times, LENGTH).speed is None


def test_too_few_cells_have_no_speed() -> None:
    z = (np.arange(4) + 0.5) * 2.5
    assert "raise grid.n_z" in str(speed_of_passage(z, z / SPEED, LENGTH).reason)


def test_faster_than_conduction_is_no_wave() -> None:
    """Cells that oscillate by themselves may fire in an order that no front has."""
    assert passage(Z / 30.0).speed == pytest.approx(30.0)
    limited = speed_of_passage(Z, Z / 30.0, LENGTH, fastest=20.0)
    assert limited.speed is None
    assert "oscillate" in str(limited.reason)


def test_local_response_travels_nowhere() -> None:
    times = np.where((Z > 4.0) & (Z < 4.3), 1.0, np.nan)
    (wave,) = found(times)
    assert wave.direction == "local"
    assert math.isnan(wave.speed)


def test_response_to_a_wide_stimulus_begins_under_it() -> None:
    """What a pulse excites at once belongs to the wave that leaves it."""
    (wave,) = found(np.maximum(Z - 0.3, 0.0) / SPEED)
    assert wave.direction == "antegrade"
    assert wave.speed == pytest.approx(SPEED, rel=0.01)


def test_longest_part_in_order() -> None:
    assert in_order(np.array([1.0, 2.0, 9.0, 3.0, 3.0])).tolist() == [0, 1, 3, 4]
    assert in_order(np.array([5.0, 4.0, 9.0, 3.0])).tolist() == [0, 1, 3]
    assert in_order(np.array([])).tolist() == []


NUMBERS = st.floats(min_value=-1e9, max_value=1e9) | st.just(math.nan) | st.floats(0.0, 10.0) | st.just(0.0)


@settings(max_examples=200, deadline=None)
@given(arrays.arrays(np.float64, st.integers(0, 60), elements=NUMBERS), st.floats(0.1, 100.0))
def test_speed_is_sane_or_none(times: np.ndarray, length: float) -> None:
    """Whatever the arrivals: a finite speed that something could have, or none and a reason."""
    z = (np.arange(times.size) + 0.5) * length / max(times.size, 1)
    speed = speed_of_passage(z, times, length)
    if speed.speed is None:
        assert speed.reason
    else:
        assert speed.reason is None
        assert 0.0 < abs(speed.speed) <= FASTEST
        assert speed.share is not None
        assert 0.0 <= speed.share <= 0.1
    alone = wave_speed(z, times, length)
    assert alone == speed.speed


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.floats(0.0, 5.0), st.integers(0, 199), st.integers(0, 2)), max_size=300))
def test_waves_are_sane(upstrokes: list[tuple[float, int, int]]) -> None:
    """Any upstrokes: every wave lies in the tube and in time, and has a sane speed that agrees with its direction."""
    time, cell, origin = (np.array([row[k] for row in upstrokes]) for k in range(3))
    for wave in waves(Z, time.astype(float), cell.astype(np.int64), origin.astype(np.int64)):
        assert Z[0] <= wave.start <= Z[-1]
        assert Z[0] <= wave.end <= Z[-1]
        assert time.min() <= wave.time <= time.max()
        if wave.direction == "antegrade":
            assert wave.end > wave.start
        if math.isfinite(wave.speed):
            assert abs(wave.speed) <= FASTEST
            assert (wave.speed > 0.0) == (wave.direction == "antegrade")
