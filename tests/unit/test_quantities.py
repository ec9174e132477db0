"""Quantities of a run, on synthetic tracks and flows whose answers are known."""

import numpy as np
import pytest

from peristalsis.inputs.config import Configuration
from peristalsis.inputs.shape import shape_of
from peristalsis.results import quantities as q

TIME = np.linspace(0.0, 2.0, 2001)
SPHERE = shape_of(Configuration().with_changes({"pellet.radius": "9 mm"}))
PLACE = np.linspace(0.0, 1.0, 201)


def shear(amplitude: float, steps: int = 201) -> tuple[np.ndarray, np.ndarray]:
    """Content that passes every inner wall node in one direction: a steady shear between axis and wall."""
    time = np.linspace(0.0, 2.0, steps)
    upstream = PLACE[None] + 0.5 * amplitude * np.sin(np.pi * PLACE)[None] * time[:, None]
    return time, np.clip(upstream, 0.0, 1.0)


def test_mean_velocity_is_travel_over_time() -> None:
    assert q.mean_velocity(TIME, 3.0 * TIME) == pytest.approx(3.0)
    assert q.mean_velocity(TIME, TIME**2, until=1.0) == pytest.approx(1.0, abs=1e-6)


def test_uniform_motion_is_regular_and_a_sine_is_not() -> None:
    """1 + sin has the coefficient of variation 1/sqrt(2), less what bins of a quarter period average away."""
    assert q.irregularity(TIME, 2.0 * TIME) == pytest.approx(0.0, abs=1e-9)
    period = 0.2
    sine = TIME - period / (2.0 * np.pi) * np.sin(2.0 * np.pi * TIME / period)
    averaged = np.sinc(0.25) / np.sqrt(2.0)
    assert q.irregularity(TIME, sine) == pytest.approx(averaged, rel=0.02)


def test_stop_and_go_has_irregularity_one() -> None:
    moving = (TIME % 0.2) < 0.1
    track = np.concatenate([[0.0], np.cumsum(np.diff(TIME) * moving[:-1])])
    assert q.irregularity(TIME, track, bin_length=0.01) == pytest.approx(1.0, abs=0.05)


def test_irregularity_of_a_pellet_that_hardly_moves_is_undefined() -> None:
    assert q.irregularity(TIME, 0.01 * TIME) is None
    assert q.irregularity(TIME, np.zeros_like(TIME)) is None


def test_stops_are_counted_on_the_way_only() -> None:
    """A pellet that waits at the start and at the end, and once in between, has stopped once."""
    track = np.interp(TIME, [0.0, 0.4, 0.8, 1.1, 1.5, 2.0], [0.0, 0.0, 1.0, 1.0, 2.0, 2.0])
    assert q.stops(TIME, track) == 1
    assert q.stops(TIME, TIME) == 0
    assert q.stops(TIME, np.interp(TIME, [0.0, 0.8, 0.85, 1.5], [0.0, 1.0, 1.0, 2.0])) == 0


def test_reversals_and_librations_of_a_sine() -> None:
    track = 0.3 * np.sin(2.0 * np.pi * 2.0 * TIME)
    assert q.reversals(track) == 4
    assert q.libration(track) == pytest.approx(0.3, rel=1e-3)
    assert q.libration(track + 0.0 * TIME) > q.libration(0.5 * track)


def test_a_drift_does_not_librate() -> None:
    assert q.libration(3.0 * TIME) == 0.0
    assert q.reversals(3.0 * TIME) == 0
    assert q.libration(np.full_like(TIME, 2.0)) == 0.0


def test_content_upstream_of_a_straight_tube_is_the_place() -> None:
    radius, axial = np.ones((1, 201)), PLACE[None]
    assert q.content_upstream(radius, axial)[0] == pytest.approx(PLACE)


def test_the_pellet_is_not_content() -> None:
    """Upstream of the middle of a tube lies half of the content, wherever half of the pellet lies there too."""
    axial = np.linspace(0.0, 10.0, 1001)[None]
    share = q.content_upstream(np.ones_like(axial), axial, np.array([5.0]), SPHERE.volume_oral_of)
    assert share[0, 500] == pytest.approx(0.5, abs=1e-9)
    behind = q.content_upstream(np.ones_like(axial), axial, np.array([2.0]), SPHERE.volume_oral_of)
    tube, pellet = np.pi * 10.0, 4.0 / 3.0 * np.pi * 0.9**3
    assert behind[0, 500] == pytest.approx((0.5 * tube - pellet) / (tube - pellet), rel=1e-6)


def test_a_uniformly_translating_field_does_not_mix() -> None:
    """Wall and content moving together carry nothing past each other."""
    time, upstream = np.linspace(0.0, 2.0, 101), np.tile(PLACE, (101, 1))
    assert q.mixing(time, upstream) == 0.0


def test_the_cross_section_as_a_whole_stays_where_it_is() -> None:
    """Averaged over the cross-section nothing moves past the content: slice by slice the mean of s is kept."""
    time, upstream = shear(0.4)
    y = np.linspace(0.0005, 0.9995, 1000)
    for start in (0.2, 0.5, 0.8):
        s, _ = q.carried(time[:6], upstream[:6], np.full_like(y, start), y)
        assert s.mean() == pytest.approx(start, abs=1e-4)
        assert s.std() > 1e-3


def test_shear_mixes_the_more_the_longer() -> None:
    found = [q.mixing(*shear(amplitude)) for amplitude in (0.05, 0.1, 0.2, 0.4)]
    assert found == sorted(found)
    assert 0.03 < found[0] < found[-1] < 0.8


def test_flow_there_and_back_unmixes() -> None:
    """Slow flow is reversible: what was carried there comes back."""
    time, there = shear(0.3)
    back = np.concatenate([there, there[::-1][1:]])
    assert q.mixing(np.linspace(0.0, 4.0, len(back)), back) < 0.05 < q.mixing(time, there)


def test_a_random_mixture_is_mixed_whatever_the_number() -> None:
    random = np.random.default_rng(1)
    for count in (400, 4000, 40000):
        found = [q.lacey_index(random.random(count), np.arange(count) % 2 == 0) for _ in range(20)]
        assert np.mean(found) == pytest.approx(1.0, abs=0.02)


def test_halves_in_order_are_not_mixed() -> None:
    assert q.lacey_index(np.linspace(0.0, 1.0, 4000), np.arange(4000) < 2000) == 0.0


@pytest.mark.parametrize("amplitude", [0.1, 0.2, 0.4])
def test_mixing_does_not_depend_on_the_number_of_tracers(amplitude: float) -> None:
    time, upstream = shear(amplitude)
    found = [q.mixing(time, upstream, tracers) for tracers in (2000, 4000, 8000, 16000)]
    assert max(found) / min(found) < 1.02


def test_tracers_stay_in_the_content_and_evenly_spread() -> None:
    """The flow keeps volume: evenly spread tracers stay evenly spread over the cross-section and along the tube."""
    time, upstream = shear(0.4)
    s, y = q.carried(time, upstream, *q.seeded(8000))
    assert (s >= 0.0).all()
    assert (s <= 1.0).all()
    counts, _, _ = np.histogram2d(s, y, bins=(5, 4), range=((0, 1), (0, 1)))
    assert counts == pytest.approx(np.full((5, 4), 400.0), rel=0.15)


def test_way_of_fewer_than_two_bins_has_no_irregularity() -> None:
    assert q.irregularity(TIME, 2.0 * TIME, bin_length=1.0) is None


def test_pellet_that_does_not_move_has_no_stops() -> None:
    """It is not on its way, so it does not stop on it."""
    assert q.stops(TIME, np.zeros_like(TIME)) == 0


def test_turning_points_of_a_pellet_that_goes_back_first() -> None:
    """Swings below the least are none; the first place and the last extreme belong to them."""
    track = np.array([5.0, 4.9, 4.0, 4.05, 3.0, 6.0, 5.95, 2.0])
    assert q.turning_points(track, 0.5) == pytest.approx([5.0, 3.0, 6.0, 2.0])
    assert q.turning_points(10.0 - track, 0.5) == pytest.approx([5.0, 7.0, 4.0, 8.0])


@pytest.mark.parametrize("track", [np.full(11, np.nan), np.array([]), np.r_[np.zeros(10), np.inf]])
def test_tracks_that_hold_nothing_have_no_quantities(track: np.ndarray) -> None:
    """A run without a pellet, without a step, or that broke off: none is None, never a number."""
    time = np.linspace(0.0, 1.0, track.size)
    assert q.mean_velocity(time, track) is None
    assert q.irregularity(time, track) is None
    assert q.stops(time, track) is None
    assert q.reversals(track) is None
    assert q.libration(track) is None


def test_mean_velocity_needs_time_and_a_track_up_to_its_end() -> None:
    assert q.mean_velocity(np.zeros(1), np.ones(1)) is None
    assert q.mean_velocity(TIME, TIME, until=5.0) is None


def test_mixing_of_nothing_is_undefined() -> None:
    """A lumen without content, one stored time, one kind of tracers: no index, and no warning."""
    time, upstream = shear(0.1)
    assert q.mixing(time[:1], upstream[:1]) is None
    empty = q.content_upstream(np.zeros((2, 5)), np.tile(np.linspace(0.0, 1.0, 5), (2, 1)))
    assert np.isnan(empty).all()
    assert q.mixing(time[:2], empty) is None
    assert q.lacey_index(PLACE, np.ones(PLACE.size, dtype=bool)) is None
    assert q.lacey_index(PLACE[:30], np.arange(30) < 10) is None
